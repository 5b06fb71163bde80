#include "planar_chain/ode/integrator.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace planar_chain::ode {

bool take(State& state, double t, const Eigen::VectorXd& increment) {
  if (!(state.y + increment).allFinite()) return false;
  for (Eigen::Index i = 0; i < state.y.size(); ++i) {
    const double whole = increment[i] + state.carry[i];
    const double next = state.y[i] + whole;
    state.carry[i] = whole - (next - state.y[i]);
    state.y[i] = next;
  }
  state.t = t;
  return true;
}

namespace {

class FixedSteps : public Integrator {
 public:
  FixedSteps(std::unique_ptr<Stepper> stepper, double h) : stepper_(std::move(stepper)), h_(h) {}

  Outcome integrate(State& state, double end, double /*longestStep*/) override {
    // Time from the index: t = start + k span/steps. A span that is a whole number of steps but for rounding
    // is that number.
    const double start = state.t;
    const double span = end - start;
    const double steps = std::max(1.0, std::ceil(span / h_ - 1e-6));
    for (double k = 1; state.t < end; ++k) {
      const double next = k < steps ? start + span * (k / steps) : end;
      if (next <= state.t) return Outcome::stepTooSmall;
      stepper_->step(state.t, next - state.t, state.y);
      if (!take(state, next, stepper_->increment())) return Outcome::notFinite;
      stepper_->accept();
      ++count_.accepted;
    }
    return Outcome::arrived;
  }

  const char* name() const override { return stepper_->name(); }
  void restart() override { stepper_->forget(); }
  const StepCount& count() const override { return count_; }

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
