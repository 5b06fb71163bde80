#include "report/report_own.h"

#include <algorithm>

#include "ode/methods.h"
#include "report/stability_measure.h"

namespace planar_chain::tools {

OwnRun::OwnRun(const Scene& scene, double end, const Make& make)
    : end_(end),
      n_(scene.chain.size()),
      dynamics_(scene),
      integrator_(make(dynamics_)),
      state_(startOf(scene, dynamics_)) {
  dynamics_.enter(0);
  integrator_->begin();
}

Progress OwnRun::step() {
  const ode::Outcome outcome = integrator_->advance(state_, std::min(end_, dynamics_.effects().until()),
                                                    dynamics_.effects().longestStep());
  if (outcome == ode::Outcome::notFinite) return Progress::diverged;
  if (outcome == ode::Outcome::stepTooSmall) return Progress::refused;
  if (state_.t >= end_) return Progress::arrived;
  if (state_.t >= dynamics_.effects().until()) {
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
  std::copy_n(y.data(), n_, theta);
  std::copy_n(y.data() + n_, n_, omega);
}

OwnRun::Make methodFor(const std::string& method, double setting) {
  return [=](Dynamics& dynamics) {
    return ode::makeMethod(method, dynamics, setting,
                           toleranceOf(setting, dynamics.size() - dynamics.works()));
  };
}

std::vector<Contestant> ownContestants() {
  std::vector<Contestant> contestants;
  for (const std::string& method : ode::methodNames()) {
    contestants.push_back(
        {"planar_chain", method, ode::hasFixedStep(method), [](const Scene&) { return true; },
         [method](const Contest& contest, double setting) -> std::unique_ptr<Run> {
           return std::make_unique<OwnRun>(contest.scene, contest.end, methodFor(method, setting));
         }});
  }
  return contestants;
}

}  // namespace planar_chain::tools
