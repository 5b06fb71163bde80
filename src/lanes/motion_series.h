#pragma once

/// The motion of a chain as a Taylor series: θ(t + h) = Σ θ_k h^k, and so on. One series reaches as far as
/// several steps of a Runge–Kutta method.
///
/// With e_j = exp(i θ_j), R = e r, P = e p, a the acceleration of the inner pin (less gravity) and f the
/// force on the next link there,
///
///     ë = i d(ω e)/dt                       a ← a + P̈
///     f ← f + m (a + R̈) − F                 J α = N − m R×a − P×f                J = I + m |r|²
///
/// Order k of a product xy is Cauchy's sum, of which only x_k y_0 + x_0 y_k is not known from lower orders.
/// P̈_k, R̈_k, a_k and f_k are linear in α_k, and the factors depend on the present angles alone. So the same
/// equation gives α_k for every k, from the moments that are left with α_k = 0:
///
///     M(θ_0) α_k = N_k − (m R×a + P×f)_k at α_k = 0
///
/// The articulated bodies of articulated.h, computed once a series, solve it in one way in and one way out.
/// There are six products a link and an order. One link and two have kernels of their own, with one torque
/// and a closed form (src/README.md says what they gain). The lanes
/// of one link take orders of a sum: series_one.h says what that saves.
///
/// Carts and held tips: see series_cart.h and series_links.h. All other chains: recursion/general_series.h.
///
/// Source: the rules for products, quotients and exponentials of series, E. Hairer, S. P. Nørsett, G. Wanner,
/// Solving Ordinary Differential Equations I (1993), section I.8; À. Jorba, M. Zou, A software package for
/// the numerical integration of ODEs by means of high-order Taylor methods, Exp. Math. 14 (2005).

#include "lanes/kernel.h"
#include "planar_chain/chain.h"
#include "simd/cache_lines.h"

namespace planar_chain {

/// The arrays of a series, for one chain or for one in each SIMD lane. Every number stands there once a lane,
/// one chain after the other.
class SeriesStorage {
 public:
  /// For chains of n links each, and a series up to `order`. Allocates; the other functions do not.
  SeriesStorage(int n, int order, int lanes, bool holdsTip = false);
  /// Link j of the chain in a lane.
  void put(int j, std::size_t lane, const Link& link);
  /// A carriage and one body on it.
  void putCart(const Chain& chain);

  simd::SeriesArrays arrays() {
    return {n_,          width_,        rows_.data(),  known_.data(),   bodies_.data(),
            tip_.data(), &e_.data()->c, links_.data(), inverses_.data()};
  }
  /// Order k of exp(i θ_j) of one chain is number k n + j.
  const Rotation<double>* e() const { return e_.data(); }
  Rotation<double>* e() { return e_.data(); }

 private:
  int n_, width_;
  std::size_t lanes_;
  CacheLines rows_, known_, bodies_, tip_, links_, inverses_;
  AlignedArray<Rotation<double>> e_;
};

class MotionSeries {
 public:
  /// For orders 0 … orders − 1 of α. holdsTip: at a point that rests. Allocates.
  MotionSeries(const Chain& chain, int orders, const simd::Kernel& kernel, bool holdsTip = false);
  /// The best kernel for the series of such a chain.
  static const simd::Kernel& kernelFor(const Chain& chain, simd::KernelChoice choice);

  /// True if such a chain has a series here, as long as nothing else couples its joints: all of them are
  /// revolute, or there are a carriage and one body on it.
  static bool areFor(const Chain& chain);
  /// True if n links are so few that a series may be faster than other methods.
  static bool areWorthwhile(int n);

  int orders() const { return orders_; }
  /// Row k of n: order k of exp(i θ_j).
  const Rotation<double>* rotations() const { return storage_.e(); }
  /// The cost of a series of this order, in evaluations of α.
  double cost(int order) const;

  /// c has rows of 2n numbers, orders 0 … `order` of θ and ω. Row 0 is read, the others are written.
  /// `external` has order 0 of N and F, or nullptr for none; its e is not read. `loads` computes the
  /// higher orders; nullptr if nothing acts. carry: the rounding error of row 0, which the sines and
  /// cosines count. Allocates nothing.
  void find(int order, const Loads& external, SeriesLoads* loads, double* c, const double* carry = nullptr);

 private:
  int n_, leading_, orders_;
  bool holdsTip_;
  const simd::Kernel& kernel_;
  simd::SeriesRun run_;
  SeriesStorage storage_;
};

}  // namespace planar_chain
