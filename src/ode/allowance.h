#pragma once

/// What a step may add to each component: the tolerance as the error control reads it.

#include <algorithm>
#include <limits>

#include "ode/integrator.h"
#include "ode/surroundings.h"

namespace planar_chain::ode {

/// For steps of h; see Tolerance. Refers to what it is made from.
class Allowance {
 public:
  Allowance(const Tolerance& tolerance, const Surroundings& surroundings, double h)
      : surroundings_(surroundings),
        h_(h),
        most_(std::max(share * tolerance.value * std::min(std::max(h, shortestCounted), 1.0), epsilon)),
        everyDigit_(std::min(1.0, tolerance.value * perRounding)) {}

  /// For component i, where its size() is size: most() × size, or if that is more perNoise() × that of its f.
  double of(Eigen::Index i, double size) const {
    return std::max(most_ * size, perNoise() * surroundings_.noise()[i]);
  }
  double most() const { return most_; }
  double perNoise() const { return everyDigit_ * clearly * surroundings_.timeOf(h_); }
  /// No estimate of component i can be relied on below.
  double rounding(Eigen::Index i) const { return surroundings_.roundingOver(h_, i); }

 private:
  static constexpr double shortestCounted = 1e-3;  // s
  static constexpr double share = 0.25;            // of the tolerance that a step's error may use
  static constexpr double perRounding = 1e10;  // 1 over the tolerance down to which rounding counts in full
  static constexpr double clearly = 4;         // above rounding, so that steps whose estimate is that grow
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();

  const Surroundings& surroundings_;
  double h_, most_, everyDigit_;
};

}  // namespace planar_chain::ode
