#include "ode/adaptive_steps.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "simd/elementary.h"

namespace planar_chain::ode {

namespace {

/// A step that is at least this share of the rest ends with it. At 1, the rounding of h leaves last steps of
/// no length; far below, the error control's choice is exceeded.
constexpr double almostAll = 1 - 1e-9;
/// The present error acts with the exponent 1/order less this share of β, as in Hairer's codes. A larger
/// share answers growing errors too weakly, and more steps are rejected.
constexpr double takenBack = 0.75;
/// An error of 0 counts as this: its logarithm is finite, and the step grows by the largest factor anyway.
constexpr double tiny = 1e-30;
/// After a rejection the next attempt is at most this share of the last: an error just above 1 must fall.
constexpr double shorter = 0.9;
/// That share after a result that is not finite, which says nothing about the error.
constexpr double farShorter = 0.1;

// Error estimates that are rounding.
constexpr double finest = 1e-10;    ///< tolerance: from there on they are looked for
constexpr double suspect = 0.25;    ///< an error of so much keeps steps from growing, or nearly
constexpr double growing = 1.2;     ///< the factor by which steps grow whose error is rounding
constexpr double mostCounted = 16;  ///< times the noise: more is no rounding
/// Another length for the same step. The error of a method changes by a few per cent then, rounding by
/// itself.
constexpr double nearlyTheSame = 1 - 1. / 256;
constexpr double asMuch = 0.25;  ///< of the error: more than a few per cent, less than rounding mostly does

// The first step: numbers of Hairer, Nørsett, Wanner. A wrong one costs a run a few steps, or one rejection.
constexpr double fromRest = 1e-5;    ///< of the scale: sizes and slopes below give no time scale
constexpr double blind = 1e-6;       ///< s: Euler's step then
constexpr double ofScale = 0.01;     ///< the error of the first step, and the way of Euler's
constexpr double straight = 1e-15;   ///< slopes below say nothing of the error
constexpr double slowGrowth = 1e-3;  ///< of Euler's step, then
constexpr double mostOfEuler = 100;  ///< times Euler's step
constexpr double boldly = 1. / 4;    ///< of the proposal: a bold step of an explicit method

}  // namespace

// Inline: as calls they make a step of dopri5 with one link 1 % longer (test/performance/instructions.py).
inline double AdaptiveSteps::landing(double t, double end, double h) {
  const double left = end - t;
  if (h >= left * almostAll) return end;
  return h > left / 2 ? t + left / 2 : t + h;
}

inline double AdaptiveSteps::growth(double log) const {
  return safety * simd::exp2(beta_ * lastLog_ - (exponent_ - takenBack * beta_) * log);
}

inline double AdaptiveSteps::foreseen(double error) const {
  if (!std::isfinite(error)) return smallestFactor;
  const double factor = sure * simd::roughPower(error, -exponent_);
  return std::min(std::max(factor, smallestFactor), largestFactor);
}

inline double AdaptiveSteps::errorNorm(const Vector& y, double h, const Vector& error) const {
  const Allowance allowance(tolerance_, *stiffness_, h);
  return vectors_.largestRatio(
      {error.data(), y.data(), tolerance_.unit.data(), tolerance_.ceiling.data(), stiffness_->noise().data()},
      {allowance.most, allowance.mostOfRates, tolerance_.firstRate, allowance.perNoise, Allowance::slowUnits,
       allowance.turningTime},
      tolerance_.ceiling.size());
}

AdaptiveSteps::AdaptiveSteps(std::unique_ptr<Stepper> stepper, Tolerance tolerance,
                             std::shared_ptr<LocalStiffness> stiffness)
    : stepper_(std::move(stepper)), tolerance_(std::move(tolerance)), stiffness_(std::move(stiffness)) {
  if (facts().errorOrder == 0) {
    throw std::invalid_argument(std::string(facts().name) + " has no error estimate to adapt to");
  }
}

Outcome AdaptiveSteps::advance(State& state, double end, double longestStep) {
  for (;;) {
    if (const std::optional<Outcome> outcome = attempt(state, end, longestStep)) return *outcome;
  }
}

void AdaptiveSteps::restartAfter(Change change) {
  const double lastLog = lastLog_;
  const bool suits = change < Change::jump;
  resume(suits ? h_ : 0);
  if (suits) lastLog_ = lastLog;
  jumps_ = 0;
  if (change == Change::all) {
    stiffness_->begin();
  } else if (change == Change::stiffKink || change == Change::stiffness) {
    stiffness_->change();
  }
}

void AdaptiveSteps::setTolerance(const Tolerance& tolerance) {
  h_ *= simd::power(tolerance.value / tolerance_.value, exponent_);
  tolerance_ = tolerance;
  stepper_->setTolerance(tolerance);
}

std::optional<Outcome> AdaptiveSteps::attempt(State& state, double end, double longestStep) {
  // Choose the step.
  stiffness_->maybeUpdate(state.t, state.y, tolerance_);
  if (h_ <= 0) propose(state, end - state.t);
  const bool isForeseen = stepper_->foresees(state, h_);
  double lengthened = isForeseen ? foreseen(errorNorm(state.y, h_, stepper_->error())) : 1;
  if (!finite_)
    lengthened = std::min(lengthened, 1.0);  // what was not finite is in no error that is foreseen
  h_ *= lengthened;
  double next = landing(state.t, end, std::min(h_, longestStep));

  // A motion that settles within the spacing of the numbers at t, or at 1 s, is a jump. A method that damps
  // it and whose error does not see it may take up to ten steps without error control.
  const double shortest = 4 * epsilon * std::max(1.0, std::abs(state.t));
  bool isJump = false;
  if (!finite_ && !(next - state.t > shortest)) return Outcome::notFinite;
  if (next < end && !(next - state.t > shortest)) {
    if (isExplicit() || facts().errorSeesStiffModes || jumps_ == mostJumps) return Outcome::stepTooSmall;
    isJump = true;
    ++jumps_;
    next = std::min(state.t + 2 * shortest, end);
  }
  const double h = next - state.t;

  // Attempt it.
  const double most = aimed_ * std::max(lengthened, 1 / lengthened);
  const bool isAsForeseen = isForeseen && most <= 1 && h > nearlyWhole * h_;
  isAsForeseen ? stepper_->stepAsForeseen(state.t, h, state.y) : stepper_->step(state.t, h, state.y);
  double error = isAsForeseen ? most : errorNorm(state.y, h, stepper_->error());
  if (error > suspect && tolerance_.value <= finest && !isForeseen && !isJump) {
    const double other = (state.t + nearlyTheSame * h) - state.t;
    if (isRounding(state, h, other, error)) next = state.t + other;
  }
  const bool mayPass = error <= 1 || isJump;
  const bool taken = mayPass && std::isfinite(error) && stepper_->take(state, next);
  finite_ = std::isfinite(error) && (taken || !mayPass);
  if (taken) {
    // Choose the next step from this one, but at most ten times the one proposed before: a step that was
    // cut short does not predict far longer ones.
    stepper_->accept();
    if (!isForeseen) {
      const double log = simd::log2(std::max(error, tiny));
      const double wanted = h * std::max(growth(log), isJump ? 1 : smallestFactor);
      h_ = std::min(wanted, justRejected_ ? h : largestFactor * h_);
      lastLog_ = std::max(log, smallestLog);
    }
    justRejected_ = false;
    count_.lastError = error;
    ++count_.accepted;
    return state.t < end ? Outcome::underway : Outcome::arrived;
  }

  // Reject it and shorten the next one.
  const double factor = finite_ ? safety * simd::power(error, -exponent_) : farShorter;
  h_ = h * std::min(std::max(factor, finite_ ? smallestFactor : 0.0), shorter);
  justRejected_ = true;
  ++count_.rejected;
  return std::nullopt;
}

bool AdaptiveSteps::isRounding(const State& state, double h, double other, double& error) {
  const bool isAccepted = error <= 1;
  if (!std::isfinite(error) || (isAccepted && stiffness_->isCounted())) return false;
  double counted = stiffness_->share(tolerance_.value);
  const auto normIf = [&](double share, const Vector& of) {
    stiffness_->count(share);
    return errorNorm(state.y, h, of);
  };
  trial_ = stepper_->error();
  const bool mayBe = normIf(mostCounted, trial_) <= 1;
  stiffness_->count(counted);
  if (!mayBe) return false;

  // Attempt another length, and compare.
  ++count_.rejected;
  stepper_->step(state.t, other, state.y);
  trialDerivative_ = stepper_->error() - trial_;
  if (errorNorm(state.y, h, trialDerivative_) < asMuch * error) {
    if (isAccepted) stepper_->step(state.t, h, state.y);
    return false;
  }
  error = errorNorm(state.y, h, stepper_->error());
  const double least = simd::power(safety / growing, facts().errorOrder);
  while (error > least && counted < mostCounted) error = normIf(counted *= 2, stepper_->error());
  return true;
}

void AdaptiveSteps::resume(double h) {
  stepper_->forget();
  h_ = h;
  lastLog_ = smallestLog;
  justRejected_ = false;
  finite_ = true;
}

double AdaptiveSteps::propose(const State& state, double left, bool isBold) {
  const Vector& slope = stepper_->derivative(state.t, state.y);
  const auto norm = [&](auto component) {
    double worst = 0;
    for (Eigen::Index i = 0; i < tolerance_.ceiling.size(); ++i) {
      const double scale = tolerance_.value * tolerance_.size(state.y, i);
      worst = std::max(worst, std::abs(component(i)) / scale);
    }
    return worst;
  };
  const double d0 =
      norm([&](Eigen::Index i) { return std::min(std::abs(state.y[i]), tolerance_.ceiling[i]); });
  const double d1 = norm([&](Eigen::Index i) { return slope[i]; });
  const bool isFromRest = d0 <= fromRest || d1 <= fromRest;
  const double h0 = std::min(left, isFromRest ? blind : ofScale * d0 / d1);
  trial_ = state.y + h0 * slope;
  stepper_->system().slope(state.t + h0, trial_.data(), trialDerivative_.data());
  const double d2 = norm([&](Eigen::Index i) { return (trialDerivative_[i] - slope[i]) / h0; });
  const double most = std::max(d1, d2);
  const double h1 =
      most > straight ? simd::power(ofScale / most, exponent_) : std::max(blind, slowGrowth * h0);
  if (!std::isfinite(h1)) return h_ = h0;
  if (isBold && (isExplicit() || isFromRest)) return h_ = std::min(isExplicit() ? boldly * h1 : h1, left);
  return h_ = std::min({mostOfEuler * h0, h1, left});
}

double AdaptiveSteps::foreseenStep(const State& state) {
  if (!stepper_->foresees(state, h_)) return 0;
  return h_ * foreseen(errorNorm(state.y, h_, stepper_->error()));
}

std::unique_ptr<Integrator> adaptiveSteps(std::unique_ptr<Stepper> stepper, Tolerance tolerance,
                                          std::shared_ptr<LocalStiffness> stiffness) {
  return std::make_unique<AdaptiveSteps>(std::move(stepper), std::move(tolerance), std::move(stiffness));
}

}  // namespace planar_chain::ode
