#include "ode/projected_steps.h"

#include <utility>

namespace planar_chain::ode {

namespace {

class ProjectedSteps : public StepsOf {
 public:
  ProjectedSteps(std::unique_ptr<Integrator> steps, System& f, double most)
      : StepsOf(std::move(steps)), f_(f), most_(most), before_(f.sizeInLaneOrder()), reached_(before_.y) {}

  Outcome advance(State& state, double end, double longestStep) override {
    before_ = state;
    const Outcome outcome = steps_->advance(state, end, longestStep);
    if (hasFailed(outcome)) return outcome;
    reached_ = state.y;
    const bool isClosed = f_.project(state, before_);
    steps_->forgetSlope();
    const bool isSmall =
        ((state.y - reached_).cwiseAbs().array() <= most_ * (1 + state.y.cwiseAbs().array())).all();
    if (isClosed && isSmall) return outcome;
    state = before_;
    return isClosed ? Outcome::undetermined : Outcome::notFinite;
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
  double most_;
  State before_;
  Vector reached_;
};

}  // namespace

std::unique_ptr<Integrator> projectedSteps(std::unique_ptr<Integrator> steps, System& f, double most) {
  return std::make_unique<ProjectedSteps>(std::move(steps), f, most);
}

}  // namespace planar_chain::ode
