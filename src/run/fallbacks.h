#pragma once

/// The methods that a simulation uses in turn after failures: the scene's; the same with smaller
/// steps; a stiff one.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/dynamics.h"
#include "ode/events.h"
#include "ode/integrator.h"
#include "ode/leaping_steps.h"
#include "ode/methods.h"
#include "ode/projected_steps.h"
#include "planar_chain/scene.h"
#include "run/energy_guard.h"
#include "run/requirements.h"
#include "run/stiffest_parameter.h"

namespace planar_chain {

constexpr std::size_t fallbackCount = 3;  ///< with 0, the method of the scene
inline IntegratorSettings settingsOf(IntegratorSettings scene, std::size_t fallback) {
  if (fallback > 0) {
    // Finer tolerances do not stop a failing method sooner, but cost steps.
    static constexpr double exact = 1e-13;
    const auto finer = [](double tolerance) { return std::max(tolerance / 100, std::min(tolerance, exact)); };
    scene.step /= 8;
    scene.rateTolerance = finer(scene.rateTolerance.value_or(scene.tolerance));
    scene.tolerance = finer(scene.tolerance);
  }
  if (fallback > 1) scene.method = "rodas5p";
  return scene;
}

/// The mean step, s, below which rodas5p replaces the scene's method. 0: never.
inline double leastMeanStepOf(const IntegratorSettings& settings) {
  const std::string& method = settings.method;
  if (method == "auto" || method == "rodas5p" || method == "radau13") return 0;
  // A second in such steps takes minutes; a motion that needs it is stiff, and rodas5p is faster.
  constexpr double crawling = 1e-8;
  if (method == "ros34pw2")
    return crawling / 100;  // its order is low: it takes steps of 1e-9 s for its accuracy
  return ode::hasFixedStep(method) ? std::min(crawling, settings.step / 100) : crawling;
}

/// Measures the mean step, over EnergyCheck::period of them at least.
class MeanStep {
 public:
  /// least: s.
  explicit MeanStep(double least) : least_(least) {}
  void begin(const ode::StepCount& count, double t) {
    then_ = count.accepted;
    time_ = t;
  }
  /// True if it is below the least.
  bool isSlow(const ode::StepCount& count, double t) {
    const long long steps = count.accepted - then_;
    if (steps < EnergyCheck::period) return false;
    const bool isSlow = t - time_ < least_ * static_cast<double>(steps);
    begin(count, t);
    return isSlow;
  }
  void saveOrRestore(Snapshot& snapshot) { snapshot(then_, time_); }

 private:
  double least_;
  long long then_ = 0;
  double time_ = 0;
};

/// True if the laws of a held tip leave the reach of the chain soon.
inline bool leavesReach(const Scene& scene, double t) {
  if (!scene.tip || scene.tip->line || scene.chain.coordinates().anyIsPrismatic()) return false;
  if (!scene.tip->x.moves() && !scene.tip->y.moves()) return false;
  double reach = 0, longest = 0;
  for (const Link& link : scene.chain.links()) {
    reach += length(link.pin);
    longest = std::max(longest, length(link.pin));
  }
  bool leaves = false;
  for (const double soon : {1e-6, 1e-5, 1e-4, 1e-3, 1e-2}) {  // s: laws may leave it for a moment alone
    const double distance = std::hypot(scene.tip->x.at(t + soon).value, scene.tip->y.at(t + soon).value);
    leaves = leaves || distance > reach || distance < 2 * longest - reach;
  }
  return leaves;
}

/// Why the motion stops at t in a pose that is stretched between the ends, and the cure.
inline const char* whyStretched(const Scene& scene, double t, bool isAtRest) {
  if (leavesReach(scene, t))
    return "the laws of the held tip leave the reach of the chain (longer links, or laws that move the tip "
           "less, keep it within)";
  return isAtRest
             ? "the chain to its held tip has come to rest straight or folded: nothing determines its way "
               "on (other lengths, drives, or another place of the tip avoid this pose)"
             : "the chain to its held tip is straight or folded: there is no way on, or more than one "
               "(other lengths, drives, or another place of the tip avoid this pose)";
}

/// Writes why the last method failed at t, y. gap: of the energy balance, J.
inline void describeFailure(std::string& to, const Scene& scene, double t, const double* y,
                            ode::Outcome outcome, double gap, Dynamics& dynamics,
                            const Coordinates& coordinates) {
  constexpr double fastest = 1e20;  // rad/s², m/s²: 2e4 rad/s within the rounding of t at 1 s
  // Steps that approach a stretched pose become too small at margins below 2e-7.
  constexpr double stretched = 1e-6;
  std::vector<double> qdd(scene.q.size());
  dynamics.accelerations(t, y, qdd.data());
  coordinates.toRelative(qdd.data(), qdd.data());
  const auto isLess = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const auto most = std::max_element(qdd.begin(), qdd.end(), isLess);
  const Joint& joint = scene.chain.joints()[static_cast<std::size_t>(most - qdd.begin())];
  char why[200] = "the motion leaves the finite numbers";
  if (outcome == ode::Outcome::stepTooSmall) {
    std::snprintf(why, sizeof why, "the tolerance asks for steps below the resolution of time");
  } else if (outcome == ode::Outcome::endless) {
    std::snprintf(why, sizeof why, "joints stick and slide, or stops are hit, by turns without end");
  } else if (outcome != ode::Outcome::notFinite) {
    std::snprintf(why, sizeof why, "the energy balance does not close, by %.3g J", gap);
  }
  if (std::abs(*most) > fastest) {
    std::snprintf(why, sizeof why, "time cannot resolve %.3g %s in %.50s", *most,
                  joint.isPrismatic ? "m/s²" : "rad/s²", joint.name.c_str());
  }
  const bool isLast = outcome == ode::Outcome::stepTooSmall && leavesReach(scene, t);
  if (outcome == ode::Outcome::undetermined || isLast || dynamics.closureMargin(t, y) < stretched) {
    constexpr double still = 1e-5;  // rad/s, m/s
    const Eigen::Map<const Eigen::VectorXd> rates(y + scene.q.size(), coordinates.size());
    std::snprintf(why, sizeof why, "%s", whyStretched(scene, t, rates.cwiseAbs().maxCoeff() < still));
  }
  char text[300];
  std::snprintf(text, sizeof text, "%s gave up at t = %.9g s: %s; ", scene.integrator.method.c_str(), t, why);
  to = text + stiffestParameter(scene, t, 0) +
       "smaller steps and rodas5p fail too; the last good state is kept";
}

/// The error control counts angles up to half a turn.
constexpr double largestCounted = pi;

/// Rates count as they are. A displacement counts as its share of the reach, R: its size is at most R. Of
/// a short chain the rate counts as R + |ṡ|, as its error moves the link. Works are controlled only where a
/// drive or the base may do work on a chain that does not move. Their unit is the energy of the chain at 1
/// rad/s, M R²/s², if that is more than 1 J: so a motion in g and mm takes the steps of the same one in kg
/// and m.
inline ode::Tolerance toleranceOf(const Scene& scene, std::size_t fallback, const Dynamics& dynamics) {
  const IntegratorSettings settings = settingsOf(scene.integrator, fallback);
  const int n = scene.chain.size(),
            works = scene.base || scene.tip || !scene.drives.empty() ? dynamics.works() : 0;
  const double none = std::numeric_limits<double>::infinity();
  ode::Tolerance tolerance{settings.tolerance, Eigen::ArrayXd::Constant(2 * n + works, none), n,
                           settings.rateTolerance};
  tolerance.ceiling.head(n) = 1 + largestCounted;
  const double reach = scene.chain.reach();
  for (int i = 0; i < n; ++i) {
    if (!scene.chain.coordinates().isPrismatic(i)) continue;
    tolerance.unit[i] = tolerance.unit[n + i] = std::min(reach, 1.0);
    tolerance.ceiling[i] = reach;
  }
  double mass = 0;
  for (const Link& link : scene.chain.links()) mass += link.mass;
  tolerance.works = works;
  tolerance.unitOfWork = std::max(1.0, mass * reach * reach);
  tolerance.unit.tail(works) = tolerance.unitOfWork;
  return tolerance;
}

/// The dynamics must outlive the method.
inline std::unique_ptr<ode::Integrator> methodOf(const Scene& scene, std::size_t fallback,
                                                 Dynamics& dynamics) {
  const IntegratorSettings settings = settingsOf(scene.integrator, fallback);
  require(settings.method != "taylor" || dynamics.hasSeries(),
          "method taylor needs a Taylor series of all that acts");
  auto method =
      ode::makeMethod(settings.method, dynamics, settings.step, toleranceOf(scene, fallback, dynamics));
  if (dynamics.keepsConditions()) {
    // A regular motion is moved by one tolerance at most, one through a change point by 1e2 to 1e7 of them.
    // Equal steps have no tolerance, and may err by a tenth, as in the energy balance. The momenta of
    // a free chain leave nothing undetermined.
    const double most = ode::hasFixedStep(settings.method) ? 0.1 : 100 * settings.tolerance;
    constexpr double any = std::numeric_limits<double>::infinity();
    method = ode::projectedSteps(std::move(method), dynamics, scene.tip ? most : any);
    if (scene.tip && !ode::hasFixedStep(settings.method))
      method = ode::leapingSteps(std::move(method), dynamics, most);
  }
  const ode::EventList& events = dynamics.effects().events();
  return events.empty() ? std::move(method) : ode::stepsToEvents(std::move(method), events, dynamics);
}

}  // namespace planar_chain
