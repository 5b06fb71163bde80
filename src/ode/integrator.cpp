#include "ode/integrator.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace planar_chain::ode {

Tolerance Tolerance::arrangedBy(const System& f) const {
  const Eigen::Index others = f.size() - ceiling.size();
  Vector all(f.size()), arranged(f.arrangedSize());
  all.head(ceiling.size()) = ceiling;
  f.arrange(all.data(), arranged.data());
  return {value, arranged.head(arranged.size() - others)};
}

Outcome Integrator::integrate(State& state, double end, double longestStep, int mostSteps) {
  Outcome outcome = state.t < end ? Outcome::underway : Outcome::arrived;
  for (int k = 0; outcome == Outcome::underway && k < mostSteps; ++k) {
    outcome = advance(state, end, longestStep);
  }
  return outcome;
}

namespace {

class FixedSteps : public Integrator {
 public:
  FixedSteps(std::unique_ptr<Stepper> stepper, double h) : stepper_(std::move(stepper)), h_(h) {}

  Outcome advance(State& state, double end, double /*longestStep*/) override {
    // What is left is a whole number of steps, if it is one but for rounding.
    const double left = end - state.t;
    const double steps = std::max(1.0, std::ceil(left / h_ - 1e-6));
    const double next = steps > 1 ? state.t + left / steps : end;
    if (next <= state.t) return Outcome::stepTooSmall;
    stepper_->step(state.t, next - state.t, state.y);
    if (!stepper_->take(state, next)) return Outcome::notFinite;
    stepper_->accept();
    ++count_.accepted;
    return steps > 1 ? Outcome::underway : Outcome::arrived;
  }

  bool stepTo(State& state, double t) override {
    stepper_->stepAgain(state.t, t - state.t, state.y);
    return stepper_->take(state, t);
  }

  const char* name() const override { return stepper_->facts().name; }
  void restartAfter(Change) override { stepper_->forget(); }
  StepCount count() const override { return count_; }

 private:
  std::unique_ptr<Stepper> stepper_;
  double h_;
  StepCount count_;
};

}  // namespace

std::unique_ptr<Integrator> fixedSteps(std::unique_ptr<Stepper> stepper, double h) {
  return std::make_unique<FixedSteps>(std::move(stepper), h);
}

}  // namespace planar_chain::ode
