#pragma once

/// The motion of a chain as a Taylor series around now: θ(t + h) = Σ θ_k h^k, and so on. Where nothing
/// happens in between, one such series reaches as far as several steps of a Runge–Kutta method.
///
/// With e_j = exp(i θ_j), R = e r, P = e p, a the acceleration of the inner pin (less gravity) and f the
/// force on the next link there,
///
///     ë = i d(ω e)/dt                       a ← a + P̈
///     f ← f + m (a + R̈) − F                 J α = N − m R×a − P×f                J = I + m |r|²
///
/// Order k of these: products as Cauchy's rule has them, of which only x_k y_0 + x_0 y_k is not known from
/// lower orders. α_k is in P̈_k, R̈_k, a_k and f_k, times what the bodies' places are now: so, whatever k, it
/// is what the moments that are left over with α_k = 0 do to the chain as it stands,
///
///     M(θ_0) α_k = N_k − (m R×a + P×f)_k at α_k = 0
///
/// and the articulated bodies of articulated.h, found once a series, solve that in one way in and one way
/// out. Six products a link and an order; two links take a closed form and eight in all.
///
/// Source: the rules for products, quotients and exponentials of series, E. Hairer, S. P. Nørsett, G. Wanner,
/// Solving Ordinary Differential Equations I (1993), section I.8; À. Jorba, M. Zou, A software package for
/// the numerical integration of ODEs by means of high-order Taylor methods, Exp. Math. 14 (2005).

#include <vector>

#include "planar_chain/chain.h"
#include "recursion/acting.h"
#include "simd/cache_lines.h"

namespace planar_chain {

namespace simd {
struct Kernel;
struct SeriesLink;
struct SeriesShape;
}  // namespace simd

/// What acts, order by order.
class SeriesLoads {
 public:
  virtual ~SeriesLoads() = default;
  /// Order k > 0 of N and F, to where they stand, from order k of θ and ω.
  virtual void findOrder(int k, const double* theta, const double* omega) = 0;
};

class MotionSeries {
 public:
  /// Of order 0 … orders − 1 of α. The best kernel of this CPU, or the one given.
  MotionSeries(const Chain& chain, int orders, const simd::Kernel* kernel = nullptr);
  ~MotionSeries();

  /// Whether a chain of n links is short enough for this to be ever faster than other methods.
  static bool areWorthwhile(int n);

  int orders() const { return orders_; }
  /// exp(i θ_j), j = 0 … n − 1, of order k at rotations() + k × rotationsPerOrder().
  const Rotation<double>* rotations() const { return e_.data(); }
  std::ptrdiff_t rotationsPerOrder() const { return n_; }
  /// What it takes, in evaluations of α.
  double cost(int order) const;

  /// c: rows of 2n numbers, order 0 … order of θ and ω; row 0 is read. outside: what acts now, N and F of
  /// order 0, or nullptr; e is not read. loads finds those of higher orders, or is nullptr where nothing
  /// acts. Allocates nothing.
  void find(int order, const Outside& outside, SeriesLoads* loads, double* c);

 private:
  int n_, orders_;
  const simd::Kernel& kernel_;
  const simd::SeriesShape& shape_;
  int width_;
  CacheLines factors_, known_;
  std::vector<Rotation<double>> e_;
  std::vector<simd::SeriesLink> links_;
};

}  // namespace planar_chain
