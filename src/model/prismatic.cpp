#include "model/prismatic.h"

#include <cmath>

namespace planar_chain {

std::string inUnitsOfPrismatic(std::string words) {
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

/// rad between the axes of two carriages. Nearer to 0, if one has no mass, the equations of both are singular
/// to more than half their digits.
constexpr double leastAngle = 1e-6;

/// True if in some configuration a motion of the carriages has no kinetic energy. Only the outermost one
/// counts: if it moves, the other one may be at rest. Without mass, the chain alone could give it inertia. In
/// such a motion the first body behind it turns about its centre of mass, and has I = 0. So
/// does each further body whose pin this moves, up to the tip or to a pin at a centre of mass, which does not
/// move. A prismatic link with I > 0 turns with one of these bodies; one with I = 0 counts as still.
bool canMoveWithoutEnergy(const std::vector<Link>& links, const std::vector<Joint>& joints,
                          std::size_t carriages) {
  if (links[carriages - 1].mass > 0) return false;
  for (std::size_t j = carriages; j < links.size(); ++j) {
    const Link& link = links[j];
    if (joints[j].isPrismatic) return j > carriages && link.inertia == 0;
    if (link.inertia > 0 || link.com == Vec2d{}) return false;
    if (link.com == link.pin) return true;
  }
  return true;
}

}  // namespace

void requirePrismatic(const std::vector<Link>& links, const std::vector<Joint>& joints,
                      std::vector<Fault>& faults) {
  constexpr std::size_t mostCarriages = 2;
  const std::size_t before = faults.size();
  const auto pathOf = [&](std::size_t i) { return "links/" + links[i].name; };
  std::size_t carriages = 0;  // those that may have no mass
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (!joints[i].isPrismatic) continue;
    const Vec2d axis = joints[i].axis;
    if (!isDirection(axis)) {
      faults.push_back(
          {pathOf(i) + "/joint/axis", directionInWords, "[" + toText(axis.x) + ", " + toText(axis.y) + "]"});
    }
    if (i == carriages && carriages < mostCarriages) {
      ++carriages;
    } else if (!(links[i].mass > 0)) {
      faults.push_back({pathOf(i) + "/mass",
                        "a number > 0 kg (only the first two links may be prismatic without mass)",
                        toText(links[i].mass)});
    }
  }
  if (faults.size() > before || carriages == 0) return;
  // A carriage without mass, and what slides on it, must not be able to move against each other.
  const auto isMassless = [&](std::size_t i) { return links[i].mass == 0; };
  for (std::size_t i = 0; i < carriages && i + 1 < joints.size() && joints[i + 1].isPrismatic; ++i) {
    if (!isMassless(i) && !(i == 0 && isMassless(1))) continue;
    const Vec2d a = joints[i].axis, b = joints[i + 1].axis;
    if (i == 1 && isMassless(0)) {
      faults.push_back(
          {pathOf(0) + "/mass", "a mass > 0 kg of one of the first two of three prismatic links", "0"});
    } else if (std::abs(cross(a, b)) < leastAngle * length(a) * length(b)) {
      faults.push_back(
          {pathOf(i + 1) + "/joint/axis",
           "a direction that is not parallel to the axis of " + links[i].name + " (or masses > 0 kg of both)",
           "[" + toText(b.x) + ", " + toText(b.y) + "]"});
    }
  }
  if (canMoveWithoutEnergy(links, joints, carriages)) {
    faults.push_back({pathOf(carriages - 1) + "/mass",
                      "a mass > 0 kg (the chain has none along the axis in some configuration)",
                      toText(links[carriages - 1].mass)});
  }
}

}  // namespace planar_chain
