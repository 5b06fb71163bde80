#include "planar_chain/ode/integrator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace planar_chain::ode {

namespace {

/// Adds the stepper's increment to the state, carrying what rounding takes away. False, and nothing has
/// changed, when the result is not finite.
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

  void restart() override { stepper_->forget(); }
  const StepCount& count() const override { return count_; }

 private:
  std::unique_ptr<Stepper> stepper_;
  double h_;
  StepCount count_;
};

class AdaptiveSteps : public Integrator {
 public:
  AdaptiveSteps(std::unique_ptr<Stepper> stepper, Tolerance tolerance)
      : stepper_(std::move(stepper)),
        tolerance_(std::move(tolerance)),
        trial_(stepper_->increment()),
        trialDerivative_(stepper_->increment()) {
    if (stepper_->errorOrder() == 0) {
      throw std::invalid_argument(std::string(stepper_->name()) + " has no error estimate to adapt to");
    }
    exponent_ = 1.0 / stepper_->errorOrder();
  }

  Outcome integrate(State& state, double end, double longestStep) override {
    bool finite = true;
    while (state.t < end) {
      if (h_ <= 0) h_ = std::min(firstStep(state, end - state.t), longestStep);
      const double next = landing(state.t, end, std::min(h_, longestStep));
      const double h = next - state.t;
      if (!(h > 4 * std::numeric_limits<double>::epsilon() * std::abs(state.t)) || h < tiny) {
        if (next < end) return finite ? Outcome::stepTooSmall : Outcome::notFinite;
      }

      stepper_->step(state.t, h, state.y);
      const double error = errorNorm(state.y, h);
      finite = std::isfinite(error) && stepper_->increment().allFinite();
      if (finite && error <= 1 && take(state, next, stepper_->increment())) {
        // The step that the error asks for grows from the one taken, but not past ten times the one proposed
        // before: a step cut short to land on a time says little about far longer ones.
        stepper_->accept();
        const double longer = h * factor(error) * std::pow(lastError_, beta);
        h_ = std::min(std::max(longer, h * smallestFactor), 10 * h_);
        if (justRejected_) h_ = std::min(h_, h);
        justRejected_ = false;
        lastError_ = std::max(error, 1e-4);
        count_.lastError = error;
        ++count_.accepted;
      } else {
        h_ = h *
             (finite ? std::max(smallestFactor, std::min(0.9, safety * std::pow(error, -exponent_))) : 0.1);
        justRejected_ = true;
        ++count_.rejected;
      }
    }
    return Outcome::arrived;
  }

  void restart() override {
    stepper_->forget();
    h_ = 0;
    lastError_ = 1e-4;
    justRejected_ = false;
  }
  const StepCount& count() const override { return count_; }

 private:
  static constexpr double safety = 0.9;
  static constexpr double beta = 0.04;
  static constexpr double smallestFactor = 0.2;
  static constexpr double shortestCounted = 1e-3;  // s
  static constexpr double tiny = 1e-300;

  double factor(double error) const {
    return safety * std::pow(std::max(error, 1e-30), -(exponent_ - 0.75 * beta));
  }

  /// The end of the next step of about h: two steps of equal length rather than a last one that is tiny.
  static double landing(double t, double end, double h) {
    const double left = end - t;
    if (h >= left * (1 - 1e-9)) return end;
    return h > left / 2 ? t + left / 2 : t + h;
  }

  /// What tolerance (1 + min(|y_i|, ceiling_i)) is made of, with the larger |y_i| of the step's two ends.
  double sizeOf(const Eigen::VectorXd& y, Eigen::Index i) const {
    return 1 + std::min(std::abs(y[i]), tolerance_.ceiling[i]);
  }

  /// The largest ratio of a component's error estimate to what a step of h may add; NaN when one is NaN.
  double errorNorm(const Eigen::VectorXd& y, double h) {
    const Eigen::VectorXd& error = stepper_->error();
    const double share = std::max(tolerance_.value * std::min(std::max(h, shortestCounted), 1.0),
                                  std::numeric_limits<double>::epsilon());
    trial_ = y + stepper_->increment();
    double worst = 0;
    for (Eigen::Index i = 0; i < tolerance_.ceiling.size(); ++i) {
      const double ratio = std::abs(error[i]) / (share * std::max(sizeOf(y, i), sizeOf(trial_, i)));
      if (std::isnan(ratio)) return ratio;
      worst = std::max(worst, ratio);
    }
    return worst;
  }

  /// A step whose explicit Euler error is small: h² |ÿ| about 1 % of the scale, then adapted to the order.
  double firstStep(const State& state, double left) {
    const Eigen::VectorXd& slope = stepper_->derivative(state.t, state.y);
    const auto norm = [&](auto component) {
      double worst = 0;
      for (Eigen::Index i = 0; i < tolerance_.ceiling.size(); ++i) {
        const double scale = tolerance_.value * sizeOf(state.y, i);
        worst = std::max(worst, std::abs(component(i)) / scale);
      }
      return worst;
    };
    const double d0 = norm([&](Eigen::Index i) { return sizeOf(state.y, i) - 1; });
    const double d1 = norm([&](Eigen::Index i) { return slope[i]; });
    const double h0 = std::min(left, d0 > 1e-5 && d1 > 1e-5 ? 0.01 * d0 / d1 : 1e-6);
    trial_ = state.y + h0 * slope;
    stepper_->system().derivative(state.t + h0, trial_.data(), trialDerivative_.data());
    const double d2 = norm([&](Eigen::Index i) { return (trialDerivative_[i] - slope[i]) / h0; });
    const double most = std::max(d1, d2);
    const double h1 = most > 1e-15 ? std::pow(0.01 / most, exponent_) : std::max(1e-6, 1e-3 * h0);
    return std::isfinite(h1) ? std::min({100 * h0, h1, left}) : h0;
  }

  std::unique_ptr<Stepper> stepper_;
  Tolerance tolerance_;
  double exponent_ = 0;
  double h_ = 0;  ///< the next step if nothing has to be landed on; 0: not known
  double lastError_ = 1e-4;
  bool justRejected_ = false;
  StepCount count_;
  Eigen::VectorXd trial_, trialDerivative_;
};

}  // namespace

std::unique_ptr<Integrator> fixedSteps(std::unique_ptr<Stepper> stepper, double h) {
  return std::make_unique<FixedSteps>(std::move(stepper), h);
}

std::unique_ptr<Integrator> adaptiveSteps(std::unique_ptr<Stepper> stepper, Tolerance tolerance) {
  return std::make_unique<AdaptiveSteps>(std::move(stepper), std::move(tolerance));
}

}  // namespace planar_chain::ode
