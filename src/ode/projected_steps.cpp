#include "ode/projected_steps.h"

#include <utility>

namespace planar_chain::ode {

namespace {

class ProjectedSteps : public StepsOf {
 public:
  ProjectedSteps(std::unique_ptr<Integrator> steps, System& f)
      : StepsOf(std::move(steps)), f_(f), before_(f.arrangedSize()) {}

  Outcome advance(State& state, double end, double longestStep) override {
    before_ = state;
    const Outcome outcome = steps_->advance(state, end, longestStep);
    if (hasFailed(outcome)) return outcome;
    const bool isClosed = f_.project(state, before_);
    steps_->forgetSlope();
    if (isClosed) return outcome;
    state = before_;
    return Outcome::notFinite;
  }
  bool stepTo(State& state, double t) override {
    return steps_->stepTo(state, t) && f_.project(state, before_);
  }
  void endAt(State& state) override {
    f_.project(state, before_);
    steps_->endAt(state);
  }

 private:
  System& f_;
  State before_;
};

}  // namespace

std::unique_ptr<Integrator> projectedSteps(std::unique_ptr<Integrator> steps, System& f) {
  return std::make_unique<ProjectedSteps>(std::move(steps), f);
}

}  // namespace planar_chain::ode
