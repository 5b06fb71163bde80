#include "ode/projected_steps.h"

#include <utility>

namespace planar_chain::ode {

namespace {

class ProjectedSteps : public Integrator {
 public:
  ProjectedSteps(std::unique_ptr<Integrator> steps, System& f)
      : steps_(std::move(steps)), f_(f), before_(f.arrangedSize()) {}

  const char* name() const override { return steps_->name(); }
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
  int pieces() const override { return steps_->pieces(); }
  double errorNorm(const Vector& y, double h, const Vector& error) const override {
    return steps_->errorNorm(y, h, error);
  }
  void restartAfter(Change change) override { steps_->restartAfter(change); }
  void forgetSlope() override { steps_->forgetSlope(); }
  void setTolerance(const Tolerance& tolerance) override { steps_->setTolerance(tolerance); }
  StepCount count() const override { return steps_->count(); }

 private:
  std::unique_ptr<Integrator> steps_;
  System& f_;
  State before_;
};

}  // namespace

std::unique_ptr<Integrator> projectedSteps(std::unique_ptr<Integrator> steps, System& f) {
  return std::make_unique<ProjectedSteps>(std::move(steps), f);
}

}  // namespace planar_chain::ode
