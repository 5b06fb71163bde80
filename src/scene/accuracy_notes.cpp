#include "scene/accuracy_notes.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>

#include "effects/friction.h"
#include "effects/stick_slip.h"
#include "ode/methods.h"

namespace planar_chain {

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

void noteWeakFriction(Scene& scene) {
  const std::vector<int> weak = StickSlip(scene.chain, frictionTolerance(scene.integrator)).leftOut();
  if (weak.empty()) return;
  scene.notes.push_back({"links/" + scene.chain.links()[index(weak[0])].name + "/joint/friction",
                         "is left out: it changes rates by less than a tenth of the tolerance in a second"});
  scene.notes.back().more = static_cast<int>(weak.size()) - 1;
}

void noteStiffDampers(Scene& scene) {
  // As shares of the least breakaway torque: where joints have stuck wrongly, and where none has.
  constexpr double mayCount = 1e-4, countsNot = 1e-3;
  const IntegratorSettings& settings = scene.integrator;
  if (ode::hasFixedStep(settings.method) || settings.rateTolerance) return;
  const std::vector<Joint>& joints = scene.chain.joints();
  double least = std::numeric_limits<double>::infinity(), most = 0;
  const Joint *weakest = nullptr, *stiffest = nullptr;
  for (const Joint& joint : joints) {
    // Without more breakaway than friction it sticks soon after.
    const double breakaway = joint.other("breakaway");
    if (!(breakaway > joint.other("friction")) || breakaway >= least) continue;
    least = breakaway;
    weakest = &joint;
  }
  for (const Joint& joint : joints) {
    if (&joint == weakest || joint.damping <= most) continue;
    most = joint.damping;
    stiffest = &joint;
  }
  if (!weakest || !stiffest || !(most * settings.tolerance > mayCount * least)) return;
  char text[200];
  std::snprintf(text, sizeof text,
                "is large beside the breakaway torque in %s, which may slide on where it should stick: set "
                "integrator/rate_tolerance to %.0e",
                weakest->name.c_str(), countsNot * least / most);
  scene.notes.push_back({"links/" +
                             scene.chain.links()[index(static_cast<int>(stiffest - joints.data()))].name +
                             "/joint/damping",
                         text});
}

}  // namespace planar_chain
