#pragma once

/// The motion of a slide and one body on it, such as a cart and its pole, as a Taylor series; see
/// motion_series.h for the rules.
///
/// With e = exp(i θ), S = m R, d the direction of the rail, x = s̈, h = S×d and M the whole mass,
///
///     ë = i d(ω e)/dt           M x = f − M d·g₋ − d·S̈           J α = N − h x − S×g₋         J = I + m |r|²
///
/// where g₋ is the acceleration of the ground pin less gravity, and f the force along the rail. Order k of
/// both equations is linear in x_k and α_k, with the same matrix for all orders:
///
///     M x_k + h_0 α_k = f_k − (k+1) h(z) − …          z = Σ_{j≤k} ω_j e_{k+1−j}
///     h_0 x_k + J α_k = N_k − Σ_{j<k} x_j h_{k−j} − …
///
/// as ë_k = i (α_k e_0 + (k+1) z). So an order takes three sums, side by side.

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "lanes/kernel.h"
#include "planar_chain/chain.h"

namespace planar_chain {

class CartSeries {
 public:
  static bool isFor(const Chain& chain) { return chain.size() == 2 && chain.slides() == 1; }

  /// For series up to `orders`. Allocates.
  CartSeries(const Chain& chain, int orders);

  int orders() const { return orders_; }
  /// The number of orders that were found.
  long long found() const { return found_; }
  /// Order k of exp(i θ) of the body is number 2 k + 1.
  const Rotation<double>* rotations() const { return e_.data(); }

  /// c has rows of (s, θ, ṡ, ω), orders 0 … `order`. Row 0 is read, the others are written. e: of the body.
  /// N: the force along the rail and the moment, F: forces, order 0 of what acts, or nullptr; `loads` writes
  /// the higher orders there. Allocates nothing.
  void find(int order, Rotation<double> e, Vec2d ground, const double* N, const Vec2d* F, SeriesLoads* loads,
            double* c);

 private:
  Vec2d rail_, mr_;
  double cart_, whole_, inertia_, J_;
  int orders_;
  long long found_ = 0;
  std::vector<Eigen::Array4d> first_, second_;  ///< (ω_j, ω_j, x_j, 0); (e_j, h_{j−1}, 0)
  std::vector<Rotation<double>> e_;
  std::vector<std::pair<double, double>> inverses_;  ///< 1/k, and the rest of it that rounding cuts off
};

}  // namespace planar_chain
