#pragma once

/// The largest eigenvalue of a Jacobian by power iteration: of one system of equations, with doubles, or of
/// one in each lane, with registers.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "planar_chain/planar.h"

namespace planar_chain::simd {

/// Arrays of n numbers, each stored once per lane.
struct JacobianAt {
  std::ptrdiff_t n;
  const double *y, *base;  ///< the state, and f there
  double *moved, *slope;   ///< another state, and f there
  double* direction;       ///< the dominant one, as far as it is known
};

// For one number. pack.h and ensemble_kernel.h have these functions for registers.
inline double larger(double a, double b) {
  return std::max(a, b);
}
inline double absolute(double a) {
  return std::abs(a);
}
inline double root(double a) {
  return std::sqrt(a);
}
/// True if the power iteration has measured an eigenvalue, or one in any lane.
inline bool isMeasured(double eigenvalue) {
  return eigenvalue > 0 && std::isfinite(eigenvalue);
}

/// |λ|² is the factor by which J J stretches its dominant direction. findSlope() computes f at `moved`, four
/// times. An eigenvalue that is 0 or not finite is not measured, and its direction is of no use.
template <class Real, class FindSlope>
Real largestEigenvalue(const JacobianAt& of, FindSlope findSlope) {
  constexpr std::ptrdiff_t lanes = sizeof(Real) / sizeof(double);
  const auto load = [](const double* numbers, std::ptrdiff_t i) {
    if constexpr (std::is_same_v<Real, double>)
      return numbers[i];
    else
      return Real::load(numbers + i * lanes);
  };
  const auto store = [](double* numbers, std::ptrdiff_t i, Real a) {
    if constexpr (std::is_same_v<Real, double>)
      numbers[i] = a;
    else
      a.store(numbers + i * lanes);
  };
  // One by one, so that zeros at the end do not change the rounding.
  const auto length = [&] {
    Real square(0);
    for (std::ptrdiff_t i = 0; i < of.n; ++i) {
      const Real d = load(of.direction, i);
      square = mulAdd(d, d, square);
    }
    return root(square);
  };
  // The step of the difference that replaces J d. Longer, f is not linear; shorter, rounding of f dominates.
  // λ needs one digit.
  constexpr double reach = 1e-6;
  const auto applyJacobian = [&] {
    Real most(0);
    for (std::ptrdiff_t i = 0; i < of.n; ++i) most = larger(absolute(load(of.direction, i)), most);
    const Real size = Real(reach) / most;
    for (std::ptrdiff_t i = 0; i < of.n; ++i)
      store(of.moved, i, mulAdd(size, load(of.direction, i), load(of.y, i)));
    findSlope();
    for (std::ptrdiff_t i = 0; i < of.n; ++i)
      store(of.direction, i, (load(of.slope, i) - load(of.base, i)) / size);
  };

  Real eigenvalue(0);
  for (int k = 0; k < 2; ++k) {
    const Real before = length();
    applyJacobian();
    applyJacobian();
    const Real after = length();
    eigenvalue = root(after / before);
    if (!isMeasured(eigenvalue)) break;
    for (std::ptrdiff_t i = 0; i < of.n; ++i) store(of.direction, i, load(of.direction, i) / after);
  }
  return eigenvalue;
}

}  // namespace planar_chain::simd
