#pragma once

/// Polynomials for the search of events: the cubic through values and slopes at the ends of an interval, and
/// the one through any points.

#include <array>
#include <cmath>
#include <cstddef>

namespace planar_chain::ode {

/// Returns the s of the local maximum of the cubic with these values and derivatives by s at 0 and 1. Outside
/// (0, 1), or NaN, if it has none between.
inline double topOfCubic(double g0, double slope0, double g1, double slope1) {
  // The derivative is 3 (d0 r² + 2 d1 r s + d2 s²), r = 1 − s: differences of Bézier coefficients.
  const double d0 = slope0 / 3, d2 = slope1 / 3, d1 = g1 - g0 - d0 - d2;
  return d0 / (d0 - d1 + std::sqrt(d1 * d1 - d0 * d2));
}

/// A zero of that cubic, which is above 0 at 1, to `exact`.
inline double zeroOfCubic(double g0, double slope0, double g1, double slope1, double exact = 0.01) {
  double low = 0, high = 1;
  while (high - low > exact) {
    const double s = (low + high) / 2, r = 1 - s;
    const double g = r * r * ((1 + 2 * s) * g0 + s * slope0) + s * s * ((3 - 2 * s) * g1 - r * slope1);
    (g > 0 ? high : low) = s;
  }
  return high;
}

/// The polynomial through some points (x, g), by Newton's divided differences.
class Interpolation {
 public:
  static constexpr std::size_t most = 10;

  bool isFull() const { return size_ == most; }
  void add(double x, double g) {
    for (std::size_t k = 0; k < size_; ++k) g = (g - c_[k]) / (x - x_[k]);
    x_[size_] = x;
    c_[size_++] = g;
  }
  double value(double x, double& slope) const {
    double value = slope = 0;
    for (std::size_t j = size_; j-- > 0;) {
      slope = value + slope * (x - x_[j]);
      value = c_[j] + value * (x - x_[j]);
    }
    return value;
  }
  /// A zero in (low, high), where the polynomial rises from below 0 to above, by Newton's method.
  double zero(double low, double high) const {
    constexpr double exact = 1e-15;  // of the interval: a few roundings; none is left to gain
    double x = (low + high) / 2;
    for (int k = 0; k < 50; ++k) {
      double slope;
      const double g = value(x, slope), before = x;
      (g > 0 ? high : low) = x;
      x -= g / slope;
      if (!(x > low && x < high)) x = (low + high) / 2;
      if (std::abs(x - before) < exact) break;
    }
    return x;
  }

 private:
  std::array<double, most> x_, c_;
  std::size_t size_ = 0;
};

}  // namespace planar_chain::ode
