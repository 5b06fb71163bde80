#pragma once

/// The steps of one method, chosen so that its error estimates meet the tolerance.

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "ode/integrator.h"
#include "ode/local_stiffness.h"
#include "simd/elementary.h"

namespace planar_chain::ode {

/// Steps chosen so that the error estimate of each meets the tolerance: PI control (Hairer, Wanner, Solving
/// ODEs II, section IV.2), the first step as in Hairer, Nørsett, Wanner, Solving ODEs I, section II.4.
class AdaptiveSteps : public Integrator {
 public:
  AdaptiveSteps(std::unique_ptr<Stepper> stepper, Tolerance tolerance,
                std::shared_ptr<LocalStiffness> stiffness)
      : stepper_(std::move(stepper)), tolerance_(std::move(tolerance)), stiffness_(std::move(stiffness)) {
    if (facts().errorOrder == 0) {
      throw std::invalid_argument(std::string(facts().name) + " has no error estimate to adapt to");
    }
  }

  const char* name() const override { return facts().name; }
  Outcome advance(State& state, double end, double longestStep) override {
    for (;;) {
      if (const std::optional<Outcome> outcome = attempt(state, end, longestStep)) return *outcome;
    }
  }
  bool stepTo(State& state, double t) override { return stepper_->takeAgain(state, t); }
  int pieces() const override { return facts().pieces; }
  /// By Allowance. NaN if a component is not finite.
  double errorNorm(const Vector& y, double h, const Vector& error) const override {
    const Allowance allowance(tolerance_, *stiffness_, h);
    const Eigen::Index all = tolerance_.ceiling.size(), angles = std::min(tolerance_.firstRate, all);
    const auto largest = [&](double most, Eigen::Index from, Eigen::Index to) {
      return vectors_.largestRatio({error.data() + from, y.data() + from, tolerance_.ceiling.data() + from,
                                    stiffness_->noise().data() + from},
                                   most, allowance.perNoise, to - from);
    };
    const double ofAngles = largest(allowance.most, 0, angles);
    const double ofRates = largest(allowance.mostOfRates, angles, all);
    return ofAngles > ofRates || std::isnan(ofAngles) ? ofAngles : ofRates;
  }
  void restartAfter(Change change) override {
    const double lastLog = lastLog_;
    resume(change == Change::bend ? h_ : 0);
    if (change == Change::bend) lastLog_ = lastLog;
    jumps_ = 0;
    if (change > Change::jump) stiffness_->forget();
  }
  void setTolerance(const Tolerance& tolerance) override {
    h_ *= simd::power(tolerance.value / tolerance_.value, exponent_);
    tolerance_ = tolerance;
    stepper_->setTolerance(tolerance);
  }
  StepCount count() const override { return count_; }

  /// One attempt of a step towards `end`. Returns nothing if it is rejected, which shortens the next.
  std::optional<Outcome> attempt(State& state, double end, double longestStep) {
    // Choose the step.
    stiffness_->maybeUpdate(state.t, state.y);
    if (h_ <= 0) propose(state, end - state.t);
    const bool isForeseen = stepper_->foresees(state, h_);
    const double lengthened = isForeseen ? foreseen(errorNorm(state.y, h_, stepper_->error())) : 1;
    h_ *= lengthened;
    double next = landing(state.t, end, std::min(h_, longestStep));

    // A motion that settles within the spacing of the numbers at t, or at 1 s, is a jump. A method that damps
    // it and whose error does not see it may take up to ten steps without error control.
    const double shortest = 4 * epsilon * std::max(1.0, std::abs(state.t));
    bool isJump = false;
    if (next < end && !(next - state.t > shortest)) {
      if (!finite_) return Outcome::notFinite;
      if (isExplicit() || facts().errorSeesStiffModes || jumps_ == mostJumps) return Outcome::stepTooSmall;
      isJump = true;
      ++jumps_;
      next = std::min(state.t + 2 * shortest, end);
    }
    const double h = next - state.t;

    // Attempt it.
    stepper_->step(state.t, h, state.y);
    const double most = aimed_ * std::max(lengthened, 1 / lengthened);
    const bool isAsForeseen = isForeseen && most <= 1 && h > nearlyWhole * h_;
    const double error = isAsForeseen ? most : errorNorm(state.y, h, stepper_->error());
    const bool mayPass = error <= 1 || isJump;
    const bool taken = mayPass && std::isfinite(error) && stepper_->take(state, next);
    finite_ = std::isfinite(error) && (taken || !mayPass);
    if (taken) {
      // Choose the next step from this one, but at most ten times the one proposed before: a step that was
      // cut short says little about far longer ones.
      stepper_->accept();
      if (!isForeseen) {
        const double log = simd::log2(std::max(error, 1e-30));
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
    const double factor = finite_ ? safety * simd::power(error, -exponent_) : 0.1;
    h_ = h * std::min(std::max(factor, finite_ ? smallestFactor : 0.0), 0.9);
    justRejected_ = true;
    ++count_.rejected;
    return std::nullopt;
  }
  /// Call this when another integrator has moved the state. The next step is about h long.
  void resume(double h) {
    stepper_->forget();
    h_ = h;
    lastLog_ = smallestLog;
    justRejected_ = false;
    finite_ = true;
  }
  /// The length of the next step, unless `end` comes before. 0: unknown.
  double proposal() const { return h_; }
  /// The cost of an attempt, in evaluations of f.
  double cost() const { return stepper_->cost(); }
  const MethodFacts& facts() const { return stepper_->facts(); }
  bool isExplicit() const { return std::isfinite(facts().stabilityLimit); }
  /// Computes a first step, which becomes proposal(), and returns it: a step with a small error of the
  /// explicit Euler method, h² |ÿ| about 1 % of the scale, then adapted to the order. It is at most 100
  /// times that of Euler's; a bold one of an explicit method is not, nor one from rest.
  double propose(const State& state, double left, bool isBold = false) {
    const Vector& slope = stepper_->derivative(state.t, state.y);
    const auto norm = [&](auto component) {
      double worst = 0;
      for (Eigen::Index i = 0; i < tolerance_.ceiling.size(); ++i) {
        const double scale = tolerance_.value * tolerance_.size(state.y, i);
        worst = std::max(worst, std::abs(component(i)) / scale);
      }
      return worst;
    };
    const double d0 = norm([&](Eigen::Index i) { return tolerance_.size(state.y, i) - 1; });
    const double d1 = norm([&](Eigen::Index i) { return slope[i]; });
    const bool isFromRest = d0 <= 1e-5 || d1 <= 1e-5;
    const double h0 = std::min(left, isFromRest ? 1e-6 : 0.01 * d0 / d1);
    trial_ = state.y + h0 * slope;
    stepper_->system().slope(state.t + h0, trial_.data(), trialDerivative_.data());
    const double d2 = norm([&](Eigen::Index i) { return (trialDerivative_[i] - slope[i]) / h0; });
    const double most = std::max(d1, d2);
    const double h1 = most > 1e-15 ? simd::power(0.01 / most, exponent_) : std::max(1e-6, 1e-3 * h0);
    if (!std::isfinite(h1)) return h_ = h0;
    if (isBold && (isExplicit() || isFromRest)) return h_ = std::min(isExplicit() ? h1 / 4 : h1, left);
    return h_ = std::min({100 * h0, h1, left});
  }

 private:
  static constexpr double safety = 0.9;
  static constexpr double sure = 0.98;        // safety if the error is foreseen
  static constexpr double nearlyWhole = 0.9;  // of a step: its error is nearly that of the whole one
  static constexpr double mostBeta = 0.04;    // weight of the last error in the PI control
  static constexpr double smallestFactor = 0.2;
  static constexpr double largestFactor = 10;
  static constexpr double smallestLog = -13.287712;  // log2 of 1e-4, the smallest error that PI remembers
  static constexpr int mostJumps = 10;
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();

  /// The end of the next step of about h. Makes two equal steps rather than a tiny last one.
  static double landing(double t, double end, double h) {
    const double left = end - t;
    if (h >= left * (1 - 1e-9)) return end;
    return h > left / 2 ? t + left / 2 : t + h;
  }

  /// safety × error^−(exponent − ¾ β) × lastError^β, from log2 of the error.
  double growth(double log) const {
    return safety * simd::exp2(beta_ * lastLog_ - (exponent_ - 0.75 * beta_) * log);
  }

  /// The factor by which a step may grow whose error is known before the attempt.
  double foreseen(double error) const {
    if (!std::isfinite(error)) return smallestFactor;
    const double factor = sure * simd::power(error, -exponent_);
    return std::min(std::max(factor, smallestFactor), largestFactor);
  }

  std::unique_ptr<Stepper> stepper_;
  Tolerance tolerance_;
  std::shared_ptr<LocalStiffness> stiffness_;
  const simd::VectorKernel& vectors_ = simd::vectors();
  const double exponent_ = 1.0 / facts().errorOrder, beta_ = std::min(mostBeta, 7 * mostBeta * exponent_);
  const double aimed_ = simd::power(sure, facts().errorOrder);
  double lastLog_ = smallestLog;  ///< of the last step's error, to base 2
  double h_ = 0;
  bool justRejected_ = false;
  bool finite_ = true;
  int jumps_ = 0;  ///< made since the last restart
  StepCount count_;
  Vector trial_ = stepper_->increment(), trialDerivative_ = trial_;
};

}  // namespace planar_chain::ode
