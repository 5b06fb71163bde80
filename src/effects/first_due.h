#pragma once

/// The first time at which a change is due in a stretch of a step at whose end it is (ode/switches.h).

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "ode/switches.h"

namespace planar_chain {

/// The times that differ by more than rounding within a stretch.
inline double narrowest(const ode::Stretch& of) {
  return 8 * std::numeric_limits<double>::epsilon() * std::max(std::abs(of.t), of.h);
}

/// The state at t within a stretch of a step whose course is known. Valid until the next call.
inline const Eigen::VectorXd& stateAt(double t, const ode::Stretch& of) {
  return t == of.t ? of.y : t == of.t + of.h ? of.next : of.course->at(t);
}

/// |x_i| + |x_{i−1}|, or |x_i|: what the rounding of a coordinate counts by.
inline double sumOfSizes(const double* x, const Coordinate& q) {
  return std::abs(x[q.joint]) + (q.inner >= 0 ? std::abs(x[q.inner]) : 0);
}

/// How far something may change within narrowest(), by its values at the begin, in the middle and at the end.
inline double changeWithinRounding(const ode::Stretch& of, double begin, double half, double end) {
  return narrowest(of) * (2 * std::max(std::abs(half - begin), std::abs(end - half)) / of.h);
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
    constexpr double exact = 1e-15;  // of the stretch: a few roundings; none is left to gain
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

/// The first time up to `last` at which due(t) is above 0, by no more than beyond(its values at the begin, in
/// the middle and at the end of the stretch); or one so near behind it that rounding hides which is first:
/// then `which` is not told. A polynomial through what is due at known times is refined by Newton's method.
template <class Due, class Beyond>
ode::Crossing firstDue(const ode::Stretch& of, double last, int which, const Due& due,
                       const Beyond& mostBeyond) {
  const double begin = due(of.t), half = due(of.t + of.h / 2), end = due(of.t + of.h);
  const double beyond = mostBeyond(begin, half, end);
  Interpolation curve;
  curve.add(0, begin - beyond / 2);
  curve.add(0.5, half - beyond / 2);
  curve.add(1, end - beyond / 2);
  ode::Crossing found;
  double low = of.t, high = last;
  while (high - low > narrowest(of)) {
    // Where rounding leaves the polynomial no zero, by halves.
    double t = of.t + of.h * curve.zero((low - of.t) / of.h, (high - of.t) / of.h);
    const bool isOfUse = !curve.isFull() && t > low && t < high;
    if (!isOfUse) t = low + (high - low) / 2;
    const double value = due(t), s = (t - of.t) / of.h;
    if (isOfUse) curve.add(s, value - beyond / 2);
    if (value > 0 && value <= beyond) {
      found.t = t;
      found.which = which;
      curve.value(s, found.slope);
      found.slope /= of.h;
      return found;
    }
    (value > 0 ? high : low) = t;
  }
  found.t = high;
  return found;
}

/// The first change of several parts of an effect, each by its dueOf(part, y), with noiseOf(part), its
/// rounding. Nothing if the course is unknown.
template <class Parts, class DueOf, class NoiseOf>
std::optional<ode::Crossing> firstDueOf(const Parts& parts, const ode::Stretch& of, const DueOf& dueOf,
                                        const NoiseOf& noiseOf) {
  if (!of.course) return {};
  ode::Crossing first;
  first.t = of.t + of.h;
  for (const auto& part : parts) {
    const auto due = [&](double t) { return dueOf(part, stateAt(t, of).data()); };
    if (due(first.t) <= 0) continue;
    first = firstDue(of, first.t, -1, due, [&](double begin, double half, double end) {
      return changeWithinRounding(of, begin, half, end) + noiseOf(part);
    });
  }
  return first;
}

}  // namespace planar_chain
