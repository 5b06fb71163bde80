#include "model/slides.h"

#include <cmath>

namespace planar_chain {

std::string inUnitsOfSlide(std::string words) {
  constexpr const char* units[][2] = {
      {"N m s²/rad²", "N s²/m²"}, {"N m s/rad", "N s/m"}, {"N m/rad", "N/m"}, {"kg m²", "kg"},
      {"rad/s", "m/s"},           {"N m", "N"},           {"rad", "m"}};
  for (const auto& [ofAngle, ofPosition] : units) {
    const std::size_t at = words.find(ofAngle);
    if (at != std::string::npos) return words.replace(at, std::string(ofAngle).size(), ofPosition);
  }
  return words;
}

namespace {

/// rad between two rails. Nearer to 0, the equations of both slides are singular to more than half their
/// digits.
constexpr double leastAngle = 1e-6;

/// True if in some configuration a motion of the slides has no kinetic energy. Only the outermost slide
/// counts: if it moves, the other one may be at rest. Without mass, the chain alone could give it inertia. In
/// such a motion the first body turns about its centre of mass, and has I = 0. The same holds for each
/// further body whose pin this moves, up to the tip or to a pin at a centre of mass, which does not move.
bool canMoveWithoutEnergy(const std::vector<Link>& links, int slides) {
  if (links[index(slides - 1)].mass > 0) return false;
  for (std::size_t j = index(slides); j < links.size(); ++j) {
    const Link& link = links[j];
    if (link.inertia > 0 || link.com == Vec2d{}) return false;
    if (link.com == link.pin) return true;
  }
  return true;
}

}  // namespace

void requireSlides(const std::vector<Link>& links, const std::vector<Joint>& joints, int slides,
                   std::vector<Fault>& faults) {
  const std::size_t before = faults.size();
  const auto pathOf = [&](std::size_t i) { return "links/" + links[i].name; };
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (!joints[i].slides) continue;
    const Vec2d axis = joints[i].axis;
    if (i >= index(slides)) {
      faults.push_back({pathOf(i) + "/joint/type",
                        "prismatic only of the first link, or of the first two (begin the chain with it, if "
                        "its other end is free)",
                        "prismatic"});
    } else if (!isDirection(axis)) {
      faults.push_back(
          {pathOf(i) + "/joint/axis", directionInWords, "[" + toText(axis.x) + ", " + toText(axis.y) + "]"});
    } else if (i >= mostSlides) {
      faults.push_back({pathOf(i) + "/joint/type", "at most two prismatic links", "prismatic"});
    }
  }
  if (faults.size() > before || slides == 0) return;
  if (index(slides) == links.size()) {
    faults.push_back({pathOf(0), "a link that turns, behind the prismatic ones", "none"});
    return;
  }
  if (slides == 2) {
    const Vec2d a = joints[0].axis, b = joints[1].axis;
    if (std::abs(cross(a, b)) < leastAngle * length(a) * length(b)) {
      faults.push_back({pathOf(1) + "/joint/axis", "a direction that is not parallel to the first rail",
                        "[" + toText(b.x) + ", " + toText(b.y) + "]"});
    }
  }
  if (canMoveWithoutEnergy(links, slides)) {
    faults.push_back({pathOf(index(slides - 1)) + "/mass",
                      "a mass > 0 kg (the chain has none along the rail in some configuration)",
                      toText(links[index(slides - 1)].mass)});
  }
}

}  // namespace planar_chain
