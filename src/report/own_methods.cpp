#include "report/own_methods.h"

#include <algorithm>

#include "ode/local_stiffness.h"
#include "ode/methods.h"
#include "planar_chain/energy.h"
#include "run/fallbacks.h"

namespace planar_chain::tools {

namespace {

constexpr double toleranceOfSeries = 2e-5;  // for order 20

/// setting: the tolerance and the step.
Scene sceneWith(Scene scene, const std::string& method, double setting) {
  scene.integrator = {method, setting, setting};
  return scene;
}

ode::State startOf(const Scene& scene, const Dynamics& dynamics) {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(dynamics.size());
  readStart(scene, y.data(), y.data() + scene.chain.size());
  return {dynamics, y};
}

}  // namespace

std::vector<std::string> steppedMethods() {
  std::vector<std::string> methods;
  for (const std::string& name : ode::methodNames()) {
    const bool takesOthersSteps = name == "auto" || name == "ros34pw2_fixed";
    if (!takesOthersSteps) methods.push_back(name);
  }
  return methods;
}

MakeIntegrator equalSteps(const std::string& method, double h, double stagesTo) {
  return [=](const Scene& scene, Dynamics& f) {
    const double value = method == "taylor" ? toleranceOfSeries : stagesTo;
    const ode::Tolerance tolerance = toleranceOf(sceneWith(scene, method, value), 0, f).inLaneOrder(f);
    return ode::fixedSteps(
        ode::makeStepper(method, f, tolerance, std::make_shared<ode::LocalStiffness>(f, tolerance.works)), h);
  };
}

MakeIntegrator methodFor(const std::string& method, double setting) {
  return [=](const Scene& scene, Dynamics& f) { return methodOf(sceneWith(scene, method, setting), 0, f); };
}

void readStart(const Scene& scene, double* theta, double* omega) {
  scene.chain.coordinates().toAbsolute(scene.q.data(), theta);
  scene.chain.coordinates().toAbsolute(scene.qd.data(), omega);
}

OwnRun::OwnRun(const Scene& scene, double end, const MakeIntegrator& make)
    : chain_(scene.chain),
      end_(end),
      dynamics_(scene),
      integrator_(make(scene, dynamics_)),
      state_(startOf(scene, dynamics_)) {
  dynamics_.enter(0);
  integrator_->begin();
}

Progress OwnRun::step() {
  const Effects& effects = dynamics_.effects();
  const ode::Outcome outcome =
      integrator_->advance(state_, std::min(end_, effects.until()), effects.longestStep());
  if (outcome == ode::Outcome::notFinite) return Progress::diverged;
  if (outcome == ode::Outcome::stepTooSmall) return Progress::refused;
  if (state_.t >= end_) return Progress::arrived;
  if (state_.t >= effects.until()) {
    dynamics_.enter(state_.t);
    integrator_->restart();
  }
  return Progress::underway;
}

Counts OwnRun::counts() const {
  return {dynamics_.evaluations(), integrator_->count().accepted, integrator_->count().rejected};
}

void OwnRun::read(double* theta, double* omega) const {
  const Eigen::VectorXd y = state_.restoredBy(dynamics_);
  std::copy_n(y.data(), chain_.size(), theta);
  std::copy_n(y.data() + chain_.size(), chain_.size(), omega);
}

double OwnRun::energyOfMotion() const {
  const int n = chain_.size();
  Eigen::VectorXd theta(n), omega(n);
  read(theta.data(), omega.data());
  const Eigen::VectorXd down = Eigen::VectorXd::Constant(n, -pi / 2), still = Eigen::VectorXd::Zero(n);
  return energyOf(chain_, theta.data(), omega.data()).total() -
         energyOf(chain_, down.data(), still.data()).total();
}

std::vector<Contestant> ownContestants(bool withEqualSteps) {
  std::vector<Contestant> contestants;
  for (const std::string& method : withEqualSteps ? steppedMethods() : ode::methodNames()) {
    const auto make = [=](const Contest& contest, double setting) {
      return std::make_unique<OwnRun>(
          contest.scene, contest.end,
          withEqualSteps ? equalSteps(method, setting) : methodFor(method, setting));
    };
    contestants.push_back(
        {"planar_chain", method, withEqualSteps || ode::hasFixedStep(method),
         [=](const Scene& scene) { return method != "taylor" || Dynamics(scene).hasSeries(); }, make});
  }
  return contestants;
}

}  // namespace planar_chain::tools
