#pragma once

/// The steps of one method, each chosen so that its error estimate meets the tolerance.

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "ode/integrator.h"
#include "ode/local_stiffness.h"
#include "simd/elementary.h"

namespace planar_chain::ode {

/// Steps chosen so that the error estimate of each meets the tolerance: PI control (Hairer, Wanner, Solving
/// ODEs II, section IV.2), the first step as in Hairer, Nørsett, Wanner, Solving ODEs I, section II.4.
class AdaptiveSteps : public Integrator {
 public:
  /// @throws std::invalid_argument for a stepper without error estimate
  AdaptiveSteps(std::unique_ptr<Stepper> stepper, Tolerance tolerance,
                std::shared_ptr<LocalStiffness> stiffness);

  const char* name() const override { return facts().name; }
  Outcome advance(State& state, double end, double longestStep) override;
  bool stepTo(State& state, double t) override { return stepper_->takeAgain(state, t); }
  bool lookTo(State& state, double t) override { return stepper_->lookAgain(state, t); }
  int pieces() const override { return facts().pieces; }
  /// By Allowance. NaN if a component is not finite.
  double errorNorm(const Vector& y, double h, const Vector& error) const override;
  void restartAfter(Change change) override;
  void forgetSlope() override { stepper_->forgetSlope(); }
  void setTolerance(const Tolerance& tolerance) override;
  const Tolerance& tolerance() const { return tolerance_; }
  StepCount count() const override { return count_; }
  void saveOrRestore(Snapshot& snapshot) override {
    stepper_->saveOrRestore(snapshot);
    snapshot(*stiffness_, lastLog_, h_, justRejected_, finite_, jumps_, count_);
  }

  /// One attempt of a step towards `end`. Returns nothing if it is rejected, which shortens the next.
  std::optional<Outcome> attempt(State& state, double end, double longestStep);
  /// Call this when another integrator has moved the state. The next step is about h long.
  void resume(double h);
  /// The length of the next step, unless `end` comes before. 0: unknown.
  double proposal() const { return h_; }
  /// The cost of an attempt, in evaluations of f.
  double cost() const { return stepper_->cost(); }
  const MethodFacts& facts() const { return stepper_->facts(); }
  bool isExplicit() const { return std::isfinite(facts().stabilityLimit); }
  /// Computes a first step, which becomes proposal(), and returns it: a step with a small error of the
  /// explicit Euler method, h² |ÿ| about 1 % of the scale, then adapted to the order. It is at most 100
  /// times that of Euler's; a bold one of an explicit method is not, nor one from rest.
  double propose(const State& state, double left, bool isBold = false);
  /// The step whose error would just be allowed, at most ten times the proposal; 0 unless the method foresees
  /// it.
  double foreseenStep(const State& state);

 private:
  /// The next step is this share of the one whose error would just be allowed, as in Hairer's codes. Nearer
  /// to 1 more steps are rejected, farther from it all are shorter.
  static constexpr double safety = 0.9;
  /// That share if the error is known before the attempt. Then only rounding can reject a step.
  static constexpr double sure = 0.98;
  /// The error of at least this share of a step is taken for that of the whole one.
  static constexpr double nearlyWhole = 0.9;
  /// The weight of the last error in the PI control, by Hairer and Wanner. 0: steps near the limit of
  /// stability alternate between long and rejected ones. Orders above 7 take less.
  static constexpr double mostBeta = 0.04;
  /// The factors by which a step may change at most: the estimate does not predict very different lengths.
  static constexpr double smallestFactor = 0.2, largestFactor = 10;
  /// log2 of 1e-4, the smallest error that the PI control remembers, as in Hairer's codes. An error may be 0.
  static constexpr double smallestLog = -13.287712;
  /// Steps without error control after a restart. A jump settles in a few; more would hide a failure.
  static constexpr int mostJumps = 10;
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();

  /// The end of the next step of about h. Makes two equal steps rather than a tiny last one.
  static double landing(double t, double end, double h);

  /// safety × error^−(exponent − ¾ β) × lastError^β, from log2 of the error.
  double growth(double log) const;

  /// The factor by which a step may grow whose error is known before the attempt.
  double foreseen(double error) const;

  /// Call this if the error of an attempt of h is near the allowed one. Returns true if it is rounding: a
  /// step of the other length then has another error. So much of LocalStiffness::noise() counts from now on
  /// that the steps pass, the other length is attempted, and `error` is its norm.
  bool isRounding(const State& state, double h, double other, double& error);

  std::unique_ptr<Stepper> stepper_;
  Tolerance tolerance_;
  std::shared_ptr<LocalStiffness> stiffness_;
  const simd::VectorKernel& vectors_ = stepper_->system().vectors();
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
