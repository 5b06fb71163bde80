#pragma once

/// The error that a step may add to each component; see Tolerance.

#include <algorithm>
#include <limits>

#include "ode/integrator.h"
#include "ode/local_stiffness.h"

namespace planar_chain::ode {

/// For steps of h. Refers to its arguments. Allocates nothing.
class Allowance {
 public:
  Allowance(const Tolerance& tolerance, const LocalStiffness& stiffness, double h)
      : stiffness_(stiffness),
        h_(h),
        most_(std::max(share * tolerance.value * std::min(std::max(h, shortestCounted), 1.0), epsilon)),
        everyDigit_(std::min(1.0, tolerance.value * perRounding)) {}

  /// For component i with that Tolerance::size(): most() × size, or perNoise() × noise_i if that is more.
  double of(Eigen::Index i, double size) const {
    return std::max(most_ * size, perNoise() * stiffness_.noise()[i]);
  }
  double most() const { return most_; }
  double perNoise() const { return everyDigit_ * clearly * stiffness_.timeOf(h_); }
  /// Error estimates of component i below this are noise.
  double rounding(Eigen::Index i) const { return stiffness_.roundingOver(h_, i); }

 private:
  static constexpr double shortestCounted = 1e-3;  // s
  static constexpr double share = 0.25;            // of the tolerance that a step's error may use
  static constexpr double perRounding = 1e10;  // 1 over the tolerance down to which rounding counts in full
  static constexpr double clearly = 4;         // above rounding, so that steps whose estimate is that grow
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();

  const LocalStiffness& stiffness_;
  double h_, most_, everyDigit_;
};

}  // namespace planar_chain::ode
