#include "scene/slides_reader.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>

#include "ode/methods.h"

namespace planar_chain {

std::optional<JointType> takeType(const Section& link) {
  const Value* joint = link.find("joint");
  if (!joint || !joint->map() || joint->map()->count("type") == 0) return JointType::revolute;
  std::string type;
  const auto isType = [](const std::string& text) {
    return text == "revolute" || text == "prismatic" || text == "floating";
  };
  if (!link.section("joint").takeText("type", isType, "revolute, prismatic or floating", type))
    return std::nullopt;
  if (type == "floating") return JointType::floating;
  return type == "prismatic" ? JointType::prismatic : JointType::revolute;
}

FreeSlide freeSlide(const std::string& link, const std::string& joint, int axis) {
  const char* suffix = axis == 0 ? "_x" : "_y";
  FreeSlide slide;
  slide.link.name = link + suffix;
  slide.joint.name = joint + suffix;
  slide.joint.slides = true;
  slide.joint.axis = axis == 0 ? Vec2d{1, 0} : Vec2d{0, 1};
  return slide;
}

void refuseBesideSlides(const Section& top, const Chain& chain, bool isFloating,
                        const std::vector<Load>& loads) {
  if (top.find("base") && isFloating) {
    top.fault("base", "no base that moves beside a floating link, which it does not hold", "both");
  }
  for (const Load& load : loads) {
    if (load.link == Load::none || load.link >= chain.slides() || load.moment == 0) continue;
    top.fault("loads/" + load.name + "/moment", "no moment on a prismatic link, which does not turn",
              toText(load.moment));
  }
}

void noteRounding(Scene& scene) {
  constexpr double rounding = 1e-16, inFixedSteps = 1e-8;
  const std::vector<Link>& links = scene.chain.links();
  const bool isFree = scene.chain.slides() == 2;
  if (!isFree && !(scene.tip && scene.tip->rows() == 2)) return;
  const double allowed =
      ode::hasFixedStep(scene.integrator.method) ? inFixedSteps : scene.integrator.tolerance;

  // Beyond a light link, one to which it is light: a heavy end that is held does not move the tip.
  constexpr double none = std::numeric_limits<double>::infinity();
  std::vector<double> lightestBehind(links.size() + 1, isFree ? 0 : none);
  for (std::size_t j = links.size(); scene.tip && j-- > 0;) {
    lightestBehind[j] = std::min(lightestBehind[j + 1], links[j].mass);
  }
  double worst = 0, lightest = none;
  const Link* heavy = nullptr;
  for (std::size_t j = index(scene.chain.slides()); j < links.size(); ++j) {
    const double ratio = links[j].mass / std::max(lightest, lightestBehind[j + 1]);
    if (ratio > worst) {
      worst = ratio;
      heavy = &links[j];
    }
    lightest = std::min(lightest, links[j].mass);
  }
  if (worst * rounding <= allowed) return;
  char text[200];
  std::snprintf(text, sizeof text,
                "is %.0e times that of a link before it: accelerations are exact to %.0e of their size%s",
                worst, worst * rounding, scene.tip ? "" : " (exact if the chain begins at its heavy end)");
  scene.notes.push_back({"links/" + heavy->name + "/mass", text});
}

}  // namespace planar_chain
