#include "scene/accuracy.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>

#include "effects/effect_kind.h"
#include "effects/stick_slip.h"
#include "effects/stops.h"
#include "ode/methods.h"
#include "reading/notes.h"

namespace planar_chain {

namespace {

/// If a link is so heavy between lighter ones and a free or held end that rounding exceeds the tolerance: the
/// acceleration of what is light then has the error 1e-16 of the ratio of the masses.
void noteRounding(Scene& scene) {
  constexpr double rounding = 1e-16, inFixedSteps = 1e-8;
  const std::vector<Link>& links = scene.chain.links();
  const bool isFree = scene.chain.coordinates().leading() == 2;
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
  for (std::size_t j = index(scene.chain.coordinates().leading()); j < links.size(); ++j) {
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

/// If friction is so weak that it is left out (stick_slip.h).
void noteWeakFriction(Scene& scene) {
  const std::vector<int> weak = StickSlip(scene.chain, toleranceOfRates(scene.integrator)).leftOut();
  if (weak.empty()) return;
  scene.notes.push_back({"links/" + scene.chain.links()[index(weak[0])].name + "/joint/friction",
                         "is left out: it changes rates by less than a tenth of the tolerance in a second"});
  scene.notes.back().more = static_cast<int>(weak.size()) - 1;
}

/// For each joint that begins beyond a limit: the energy in its stop moves the chain at once.
void noteStopsAtStart(Scene& scene) {
  Notes notes;
  for (std::size_t i = 0; i < scene.q.size(); ++i) {
    const Joint& joint = scene.chain.joints()[i];
    const double q = scene.q[i], energy = stopKind().energyIn(joint, q);
    if (!(energy > 0)) continue;
    const bool isAbove = q > joint.upper;
    const char* unit = joint.isPrismatic ? "m" : "rad";
    char text[250];
    std::snprintf(
        text, sizeof text,
        "%s begins at %.6g %s, %s (%.6g %s): its stop releases %.3g J at once (another initial/%s, or "
        "start: rest, avoids this)",
        joint.name.c_str(), q, unit, isAbove ? "above upper" : "below lower",
        isAbove ? joint.upper : joint.lower, unit, energy, joint.isPrismatic ? "position" : "angle");
    notes.add("links/" + scene.chain.links()[i].name + "/initial", text);
  }
  scene.notes.insert(scene.notes.end(), notes.all().begin(), notes.all().end());
}

}  // namespace

void addNotes(Scene& scene, bool startsAtRest) {
  if (!startsAtRest) noteStopsAtStart(scene);
  noteRounding(scene);
  noteWeakFriction(scene);
}

void boundRates(Scene& scene) {
  constexpr double mayCount = 1e-4, countsNot = 3e-4, nearRounding = 1e-12;
  IntegratorSettings& settings = scene.integrator;
  if (ode::hasFixedStep(settings.method) || settings.rateTolerance) return;
  double breakaway = std::numeric_limits<double>::infinity(), damping = 0;
  for (const Joint& joint : scene.chain.joints()) {
    // Without more breakaway than friction a joint that slides on sticks soon after.
    const double torque = joint.other("breakaway");
    if (torque > joint.other("friction")) breakaway = std::min(breakaway, torque);
    damping = std::max({damping, joint.damping, joint.stopDamping});
  }
  if (settings.tolerance * damping <= mayCount * breakaway) return;
  settings.rateTolerance =
      std::min(settings.tolerance, std::max(countsNot * breakaway / damping, nearRounding));
}

}  // namespace planar_chain
