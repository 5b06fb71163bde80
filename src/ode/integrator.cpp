#include <algorithm>
#include <cmath>
#include <limits>

#include "ode/events.h"

namespace planar_chain::ode {

Tolerance Tolerance::arrangedBy(const System& f) const {
  Tolerance result = *this;
  const Eigen::Index others = f.size() - ceiling.size();
  Vector all(f.size()), arranged(f.arrangedSize());
  for (Eigen::ArrayXd* of : {&result.unit, &result.ceiling}) {
    all.head(of->size()) = *of;
    f.arrange(all.data(), arranged.data());
    *of = arranged.head(arranged.size() - others);
    *of = (*of > 0).select(*of, 1);  // f may fill gaps between components with 0
  }
  if (firstRate >= f.size()) return result;

  // Rates are arranged behind the angles.
  all.setZero();
  all.tail(f.size() - firstRate).setOnes();
  f.arrange(all.data(), arranged.data());
  result.firstRate = std::find(arranged.data(), arranged.data() + arranged.size(), 1.0) - arranged.data();
  return result;
}

const LocatedEvent& Integrator::event() const {
  static const LocatedEvent none;
  return none;
}

Outcome Integrator::integrate(State& state, double end, double longestStep, int mostSteps) {
  // At 0 s two times can be so close that 1/h overflows. Nothing moves meanwhile.
  constexpr double nothing = 1e-300;  // s
  if (end - state.t < nothing) state.t = std::max(state.t, end);
  Outcome outcome = state.t < end ? Outcome::underway : Outcome::arrived;
  for (int k = 0; outcome == Outcome::underway && k < mostSteps; ++k) {
    outcome = advance(state, end, longestStep);
  }
  return outcome;
}

namespace {

// ---- Equal steps -----------------------------------------------------------------------------

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
