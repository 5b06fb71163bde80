#pragma once

/// Gragg's modified midpoint rule, extrapolated (Hairer, Nørsett, Wanner, Solving ODEs I, II.9), with step
/// control, for any number type.

#include <algorithm>
#include <cmath>
#include <vector>

template <class Real>
Real magnitude(Real x) {
  return x < 0 ? -x : x;
}

/// Order 2 columns; `tolerance` bounds the error estimate of a step, relative to max(1, |y|). What is
/// extrapolated is the step's change of y, so that y itself is rounded once a step; extrapolation would
/// multiply its rounding.
template <class Real, class System>
class Extrapolation {
 public:
  Extrapolation(System& f, int columns, double tolerance) : f_(f), columns_(columns), tolerance_(tolerance) {}

  void integrate(double from, double to, std::vector<Real>& y) {
    Real t = Real(from), left = Real(to) - Real(from);
    Real h = std::min(Real(1e-3), left);
    while (left > 0) {
      const bool last = h >= left;
      if (last) h = left;
      const double error = step(t, h, y);
      if (error <= 1) {
        for (std::size_t i = 0; i < y.size(); ++i) y[i] += table_.back()[i];
        t += h;
        left = last ? Real(0) : Real(to) - t;
      }
      const double growth = 0.8 * std::pow(std::max(error, 1e-12), -1.0 / (2 * columns_ - 1));
      h *= Real(std::min(4.0, std::max(0.1, growth)));
    }
  }

 private:
  double step(Real t, Real h, const std::vector<Real>& y) {
    slope_.resize(y.size());
    f_(t, y, slope_);
    const std::vector<Real> slope = slope_;
    table_.assign(columns_, {});
    for (int k = 0; k < columns_; ++k) {
      // Row k from the right: T_k1, then T_kj over the row before, whose entry j−1 it replaces.
      std::vector<Real> entry = midpoint(t, h, 2 * (k + 1), y, slope);
      for (int j = 0; j < k; ++j) {
        const Real ratio = Real(k + 1) / Real(k - j);
        std::vector<Real> next(y.size());
        for (std::size_t i = 0; i < y.size(); ++i) {
          next[i] = entry[i] + (entry[i] - table_[j][i]) / (ratio * ratio - 1);
        }
        table_[j] = entry;
        entry = next;
      }
      table_[k] = entry;
    }
    double worst = 0;
    for (std::size_t i = 0; i < y.size(); ++i) {
      const Real scale = std::max(Real(1), magnitude(y[i]));
      const Real error = magnitude(table_[columns_ - 1][i] - table_[columns_ - 2][i]) / scale;
      worst = std::max(worst, double(error) / tolerance_);
      if (!(double(error) >= 0)) return 1e12;
    }
    return worst;
  }

  /// The change of y by so many parts of the midpoint rule.
  std::vector<Real> midpoint(Real t, Real h, int steps, const std::vector<Real>& y,
                             const std::vector<Real>& slope) {
    const Real part = h / Real(steps);
    std::vector<Real> before(y.size(), Real(0)), now(y.size()), at(y.size());
    for (std::size_t i = 0; i < y.size(); ++i) now[i] = part * slope[i];
    const auto evaluate = [&](Real when) {
      for (std::size_t i = 0; i < y.size(); ++i) at[i] = y[i] + now[i];
      f_(when, at, slope_);
    };
    for (int k = 1; k < steps; ++k) {
      evaluate(t + Real(k) * part);
      for (std::size_t i = 0; i < y.size(); ++i) {
        const Real next = before[i] + 2 * part * slope_[i];
        before[i] = now[i];
        now[i] = next;
      }
    }
    evaluate(t + h);
    for (std::size_t i = 0; i < y.size(); ++i) {
      now[i] = (now[i] + before[i] + part * slope_[i]) / 2;
    }
    return now;
  }

  System& f_;
  int columns_;
  double tolerance_;
  std::vector<std::vector<Real>> table_;
  std::vector<Real> slope_;
};
