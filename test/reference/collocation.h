#pragma once

/// Radau's collocation method IIA (Hairer and Wanner, Solving ODEs II, IV.5) of any number of stages, in
/// quadruple precision, for autonomous systems that no explicit method can follow.
///
/// The stages' increments Z solve Z_i = h Σ_j a_ij f(y + Z_j), by Newton's method with J and the factors of
/// 1 − h A ⊗ J in 80 bits: each iteration gains some 15 digits all the same. Each step is made once in one
/// and once in two halves; the difference is the error estimate, the halves are kept.

#include <quadmath.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

/// A x = b by Gaussian elimination with pivoting.
template <class Real>
class Elimination {
 public:
  using Matrix = std::vector<std::vector<Real>>;

  explicit Elimination(Matrix a) : a_(std::move(a)), row_(a_.size()) {
    const int n = int(a_.size());
    for (int k = 0; k < n; ++k) {
      int pivot = k;
      for (int i = k; i < n; ++i) {
        if (size(a_[i][k]) > size(a_[pivot][k])) pivot = i;
      }
      row_[k] = pivot;
      std::swap(a_[k], a_[pivot]);
      for (int i = k + 1; i < n; ++i) {
        const Real factor = a_[i][k] /= a_[k][k];
        if (factor == 0) continue;
        for (int j = k + 1; j < n; ++j) a_[i][j] -= factor * a_[k][j];
      }
    }
  }

  void solve(std::vector<Real>& b) const {
    const int n = int(a_.size());
    for (int k = 0; k < n; ++k) std::swap(b[k], b[row_[k]]);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < i; ++j) b[i] -= a_[i][j] * b[j];
    }
    for (int i = n - 1; i >= 0; --i) {
      for (int j = i + 1; j < n; ++j) b[i] -= a_[i][j] * b[j];
      b[i] /= a_[i][i];
    }
  }

 private:
  static Real size(Real x) { return x < 0 ? -x : x; }
  Matrix a_;
  std::vector<int> row_;  // exchanged with row k before step k
};

template <class System>
class Radau {
 public:
  using Quad = __float128;
  using State = std::vector<Quad>;

  /// `tolerance` bounds the error estimate of a step, relative to max(1, |y|).
  Radau(System& f, int stages, double tolerance) : f_(f), s_(stages), tolerance_(tolerance) { setTable(); }

  void integrate(Quad duration, State& y) {
    Quad left = duration;
    double h = 1e-3;
    while (left > 0) {
      const bool last = h >= double(left);
      const Quad step = last ? left : Quad(h);
      linearize(y);
      State whole = y, halves = y;
      double error = 1e12;
      if (advance(step, whole) && advance(step / 2, halves)) {
        linearize(halves);
        if (advance(step / 2, halves)) error = difference(whole, halves) / tolerance_;
      }
      if (error <= 1) {
        y = halves;
        left = last ? Quad(0) : left - step;
      }
      h = double(step) *
          std::min(4.0, std::max(0.1, 0.8 * std::pow(std::max(error, 1e-12), -1.0 / (s_ + 1))));
      if (h < 1e-25) throw std::runtime_error("no step is short enough");
    }
  }

 private:
  /// Nodes: the zeros in (0, 1] of P_s − P_{s−1}, Legendre's polynomials of 2 c − 1. Weights:
  /// Σ_j a_ij c_j^(q−1) = c_i^q / q, q = 1 … s.
  void setTable() {
    const auto polynomial = [this](Quad c) {
      const Quad x = 2 * c - 1;
      Quad before = 1, now = x;
      for (int k = 2; k <= s_; ++k)
        before = std::exchange(now, ((2 * k - 1) * x * now - (k - 1) * before) / k);
      return now - before;
    };
    const int pieces = 1000;
    for (int i = 0; i < pieces - 1; ++i) {
      Quad low = Quad(i) / pieces, high = Quad(i + 1) / pieces;
      if (polynomial(low) * polynomial(high) > 0) continue;
      for (int k = 0; k < 120; ++k) {
        const Quad middle = (low + high) / 2;
        (polynomial(low) * polynomial(middle) > 0 ? low : high) = middle;
      }
      c_.push_back(low);
    }
    c_.push_back(1);
    if (int(c_.size()) != s_) throw std::logic_error("nodes are missing");
    typename Elimination<Quad>::Matrix powers(s_, State(s_));
    for (int q = 0; q < s_; ++q) {
      for (int j = 0; j < s_; ++j) powers[q][j] = powq(c_[j], q);
    }
    const Elimination<Quad> equations(powers);
    for (int i = 0; i < s_; ++i) {
      State weights(s_);
      for (int q = 1; q <= s_; ++q) weights[q - 1] = powq(c_[i], q) / q;
      equations.solve(weights);
      a_.push_back(weights);
    }
  }

  void linearize(const State& y) {
    const std::size_t n = y.size();
    J_.assign(n, std::vector<long double>(n));
    State slope(n), moved(n), at = y;
    f_(y, slope);
    for (std::size_t j = 0; j < n; ++j) {
      const Quad step = 1e-15Q;
      at[j] += step;
      f_(at, moved);
      at[j] = y[j];
      for (std::size_t i = 0; i < n; ++i) J_[i][j] = (long double)((moved[i] - slope[i]) / step);
    }
  }

  /// False when Newton's method does not converge.
  bool advance(Quad h, State& y) {
    const int n = int(y.size()), size = n * s_;
    typename Elimination<long double>::Matrix matrix(size, std::vector<long double>(size));
    for (int i = 0; i < size; ++i) {
      for (int j = 0; j < size; ++j) {
        matrix[i][j] = (i == j ? 1.0L : 0.0L) - (long double)(h * a_[i / n][j / n]) * J_[i % n][j % n];
      }
    }
    const Elimination<long double> newton(matrix);
    std::vector<State> Z(s_, State(n, Quad(0))), F(s_, State(n));
    State at(n);
    std::vector<long double> correction(size);
    for (int iteration = 0; iteration < 40; ++iteration) {
      for (int i = 0; i < s_; ++i) {
        for (int k = 0; k < n; ++k) at[k] = y[k] + Z[i][k];
        f_(at, F[i]);
      }
      for (int i = 0; i < size; ++i) {
        Quad sum = 0;
        for (int j = 0; j < s_; ++j) sum += a_[i / n][j] * F[j][i % n];
        correction[i] = (long double)(h * sum - Z[i / n][i % n]);
      }
      newton.solve(correction);
      double largest = 0;
      for (int i = 0; i < size; ++i) {
        Z[i / n][i % n] += correction[i];
        const double relative = double(fabsq(correction[i]) / std::max(Quad(1), fabsq(y[i % n])));
        if (!std::isfinite(relative)) return false;
        largest = std::max(largest, relative);
      }
      if (largest > 1e6) return false;
      if (largest < 1e-26) {
        for (int k = 0; k < n; ++k) y[k] += Z[s_ - 1][k];
        return true;
      }
    }
    return false;
  }

  static double difference(const State& a, const State& b) {
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      worst = std::max(worst, double(fabsq(a[i] - b[i]) / std::max(Quad(1), fabsq(b[i]))));
    }
    return worst;
  }

  System& f_;
  int s_;
  double tolerance_;
  State c_;
  std::vector<State> a_;
  std::vector<std::vector<long double>> J_;
};
