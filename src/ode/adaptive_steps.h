#pragma once

/// Steps chosen so that the error estimate of each meets the tolerance: PI control (Hairer, Wanner, Solving
/// ODEs II, section IV.2), the first step as in Hairer, Nørsett, Wanner, Solving ODEs I, section II.4.

#include <cmath>
#include <optional>

#include "ode/integrator.h"
#include "ode/local_stiffness.h"

namespace planar_chain::ode {

class AdaptiveSteps : public Integrator {
 public:
  /// stiffness: that of the stepper's system. Integrators of the same state may share it.
  /// @throws std::invalid_argument for a stepper without error estimate.
  AdaptiveSteps(std::unique_ptr<Stepper> stepper, Tolerance tolerance,
                std::shared_ptr<LocalStiffness> stiffness);

  const char* name() const override { return facts().name; }
  Outcome advance(State& state, double end, double longestStep) override;
  bool stepTo(State& state, double t) override;
  void restartAfter(Change change) override;
  StepCount count() const override { return count_; }

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
  /// Computes a first step for this state, which becomes proposal(), and returns it.
  double propose(const State& state, double left);

 private:
  double growth(double log) const;
  double foreseen(double error) const;
  double errorNorm(const Vector& y, double h) const;

  std::unique_ptr<Stepper> stepper_;
  Tolerance tolerance_;
  std::shared_ptr<LocalStiffness> stiffness_;
  const simd::VectorKernel& vectors_ = simd::vectors();
  double exponent_, beta_, aimed_;
  double lastLog_;  ///< of the last step's error, to base 2
  double h_ = 0;
  bool justRejected_ = false;
  bool finite_ = true;
  int jumps_ = 0;  ///< made since the last restart
  StepCount count_;
  Vector trial_, trialDerivative_;
};

}  // namespace planar_chain::ode
