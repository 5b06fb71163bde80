#pragma once

/// The first time at which a switch is due, in a stretch at whose end it is.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "ode/switches.h"

namespace planar_chain::ode {

/// The times that differ by more than rounding within a stretch.
inline double narrowest(const Stretch& of) {
  return 8 * std::numeric_limits<double>::epsilon() * std::max(std::abs(of.t), of.h);
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
    double x = (low + high) / 2;
    for (int k = 0; k < 50; ++k) {
      double slope;
      const double g = value(x, slope), before = x;
      (g > 0 ? high : low) = x;
      x -= g / slope;
      if (!(x > low && x < high)) x = (low + high) / 2;
      if (std::abs(x - before) < 1e-15) break;
    }
    return x;
  }

 private:
  std::array<double, most> x_, c_;
  std::size_t size_ = 0;
};

/// due() of one switch, `which`, in a stretch.
struct Rise {
  int which;
  double begin, half, end;
  /// How far above 0 it may be where a step ends.
  double beyond = 0;

  /// What the rounding of t makes of it.
  double ofTime(const Stretch& of) const {
    return narrowest(of) * 2 * std::max(std::abs(half - begin), std::abs(end - half)) / of.h;
  }
};

/// The first time up to `last` at which due(t) is above 0, by no more than `beyond`; or one so near behind it
/// that rounding hides which is first: then `which` is not told. A polynomial through what is due at known
/// times is refined by Newton's method.
template <class Due>
Crossing crossingOf(const Rise& rise, const Stretch& of, double last, Due&& due) {
  Interpolation curve;
  curve.add(0, rise.begin - rise.beyond / 2);
  curve.add(0.5, rise.half - rise.beyond / 2);
  curve.add(1, rise.end - rise.beyond / 2);
  Crossing found;
  double low = of.t, high = last;
  while (high - low > narrowest(of)) {
    // Where rounding leaves the polynomial no zero, by halves.
    double t = of.t + of.h * curve.zero((low - of.t) / of.h, (high - of.t) / of.h);
    const bool isOfUse = !curve.isFull() && t > low && t < high;
    if (!isOfUse) t = low + (high - low) / 2;
    const double value = due(t), s = (t - of.t) / of.h;
    if (isOfUse) curve.add(s, value - rise.beyond / 2);
    if (value > 0 && value <= rise.beyond) {
      found = {t, nullptr, rise.which, 0};
      curve.value(s, found.slope);
      found.slope /= of.h;
      return found;
    }
    (value > 0 ? high : low) = t;
  }
  found.t = high;
  return found;
}

}  // namespace planar_chain::ode
