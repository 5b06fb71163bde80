#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "ode/integrator.h"

namespace planar_chain::ode {

namespace {

class FixedSteps : public Integrator {
 public:
  FixedSteps(std::unique_ptr<Stepper> stepper, double h) : stepper_(std::move(stepper)), h_(h) {}

  Outcome advance(State& state, double end, double /*longestStep*/) override {
    // The rest is a whole number of steps, if it is one up to the rounding of a quotient of some 1e9.
    constexpr double rounding = 1e-6;
    const double left = end - state.t;
    const double steps = std::max(1.0, std::ceil(left / h_ - rounding));
    const double next = steps > 1 ? state.t + left / steps : end;
    if (next <= state.t) return Outcome::stepTooSmall;
    stepper_->step(state.t, next - state.t, state.y);
    if (!stepper_->take(state, next)) return Outcome::notFinite;
    stepper_->accept();
    ++count_.accepted;
    return steps > 1 ? Outcome::underway : Outcome::arrived;
  }

  bool stepTo(State& state, double t) override { return stepper_->takeAgain(state, t); }
  bool lookTo(State& state, double t) override { return stepper_->lookAgain(state, t); }
  /// Nothing is known of the method's error, which this hardly changes.
  double errorNorm(const Vector& y, double /*h*/, const Vector& error) const override {
    constexpr double unseen = 1e-12;  // beside the error of equal steps
    return (error.cwiseAbs().array() / (unseen * (1 + y.cwiseAbs().array()))).maxCoeff();
  }

  const char* name() const override { return stepper_->facts().name; }
  void restartAfter(Change) override { stepper_->forget(); }
  void forgetSlope() override { stepper_->forgetSlope(); }
  StepCount count() const override { return count_; }
  void saveOrRestore(Snapshot& snapshot) override {
    stepper_->saveOrRestore(snapshot);
    snapshot(count_);
  }

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
