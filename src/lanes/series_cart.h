#pragma once

/// The Taylor series of a carriage and one body on it: a cart and its pole. See motion_series.h for the
/// rules.
///
/// In axes along that of the joint and across it, m R = σ (c, s), and the acceleration of the ground pin less
/// gravity is (g_∥, g_⊥). With M the mass of both, f the force along the axis, X the acceleration of the cart
/// + g_∥, and J of the body,
///
///     ṡ = v = ω c      ċ = −w = −ω s      M X = f + σ ẇ      J α = N + σ (s X − g_⊥ c)
///
/// An order takes the sums for w_{k+1}, v_{k+1} and (s X)_k, at once. W is w_{k+1} without its last term
/// ω_{k+1} s_0 = α_k s_0/(k+1). So
///
///     Δ α_k = M (N_k − σ g_⊥ c_k + σ Σ_{0<j≤k} s_j X_{k−j}) + σ s_0 (f_k + σ (k+1) W)      Δ = M J − σ² s_0²
///
/// Each order waits for the one before. So α_k is found without what ω_k = α_{k−1}/k adds to it, which is
/// κ (α_{k−1} + ω_k) with κ = 2 σ² s_0 c_0 ω_0/Δ. That comes last. So does what ω_k adds to c_{k+1} and
/// s_{k+1}: its factor is divided by k + 1 before. Sums are taken for two orders at once.

#include "lanes/series_one.h"

namespace planar_chain::simd {
namespace {

class CartAndPole {
 public:
  CartAndPole(const SeriesArrays& of, Vec2d ground, double* c)
      : cart_(*reinterpret_cast<const SeriesCart*>(of.links)),
        rows_(of.rows),
        e_(of.e),
        inverses_(of.inverses),
        c_(c),
        along_(dot(cart_.axis, ground)) {
    const Rotation<double> e = Rotation<double>{of.e[2], of.e[3]} * cart_.turn;
    const double sigma = cart_.moment, omega = c[3];
    const double inverse = 1 / (cart_.least + sigma * sigma * e.c * e.c), kappa = sigma * sigma * inverse;
    s0_ = Lane(e.s);
    ofX_ = Lane(cart_.perMass * sigma);
    s0X_ = s0_ * ofX_;
    ofN_ = Lane(cart_.mass * inverse);
    const double ofSum = sigma * ofN_.v, ofU = -kappa * e.s;
    ofSum_ = {Pair::Register{-ofSum, ofSum}};
    ofU_ = sumOfU_ = {Pair::Register{-ofU, ofU}};
    ofF_ = Lane(sigma * inverse);
    ofDirection_ = {Pair::Register{cross(cart_.axis, ground) * ofSum, 0}};
    ofTurning_ = {Pair::Register{0, -omega * ofU}};
    moreOfTurning_ = {Pair::Register{kappa * omega * e.c, 0}};
    late_ = Pair(2 * e.c * ofTurning_.v[1]);
    direction_ = {Pair::Register{e.c, e.s}};
    start_ = swapped(direction_);
    omega_ = omega0_ = {Pair::Register{-omega, omega}};
    turning_ = omega_ * start_;
    rates_ = Pair::load(c + 2);
  }

  /// N, F: of order 0 at first; `loads` may be nullptr.
  template <bool acts>
  [[gnu::always_inline]] void findAll(int order, const Loads& external, SeriesLoads* loads) {
    const auto find = [&](int k, auto isFirst, Four sum) {
      Acting acting;
      if constexpr (acts) {
        if (loads && !isFirst) findLoads(k, loads);
        acting = {Lane(external.N[1]), Lane(external.N[0])};
        if (external.F) acting.f += Lane(dot(cart_.axis, external.F[0] + external.F[1]));
      }
      findOrder<acts, isFirst>(k, acting, sum);
    };
    find(0, std::true_type(), {});
    const Pair X0 = X_;
    for (int k = 1; k < std::min(order, 3); ++k) {
      find(k, std::false_type(), {});
      if (k == 1) takeFirst(X0);
    }
    for (int k = 3; k < order; ++k) {
      Four sum, nextSum;
      sumFromMemory(k, sum, nextSum);
      find(k, std::false_type(), sum);
      if (++k < order) find(k, std::false_type(), mulAdd(last_, directionAt(2), nextSum));
    }
  }

 private:
  /// Row k has −ω_k, ω_k, X_{k−1}; then s_k, c_k, s_k.
  static constexpr int row = 8;
  struct Acting {
    Lane N, f;
  };

  void findLoads(int k, SeriesLoads* loads) const {
    const Rotation<double> e =
        Rotation<double>{direction_.v[0], direction_.v[1]} * Rotation<double>{cart_.turn.c, -cart_.turn.s};
    e_[4 * k + 2] = e.c;
    e_[4 * k + 3] = e.s;
    loads->findOrder(k);
  }

  /// s_k, c_k, s_k, c_k
  Four directionAt(int k) const { return Four::load(rows_ + row * k + 4); }

  /// Computes the terms of ω_1 and X_0 in each further order.
  void takeFirst(Pair X0) {
    omega1_ = omega_;
    moreOfDirection_ = {Pair::Register{0, -ofU_.v[1] * omega_.v[1]}};
    ofDirection_ += {Pair::Register{0, ofSum_.v[1] * X0.v[0] + 3 * moreOfDirection_.v[1]}};
  }

  /// For an odd k, the products of rows i = 2 … k − 1 and k + 1 − i; and of rows i and k + 2 − i. It begins
  /// in the middle, as in series_kernel.h.
  [[gnu::always_inline]] void sumFromMemory(int k, Four& sum, Four& nextSum) const {
    Four sums[2], nextSums[2];
    const double *low = rows_ + row * (k - 1) / 2, *high = low + row;
    for (; low > rows_ + row; low -= row, high += row) {
      const Four first = Four::load(low), second = Four::load(high);
      sums[0] = mulAdd(first, Four::load(high + row + 4), sums[0]);
      nextSums[0] = mulAdd(first, Four::load(high + 2 * row + 4), nextSums[0]);
      sums[1] = mulAdd(second, Four::load(low + row + 4), sums[1]);
      nextSums[1] = mulAdd(second, Four::load(low + 2 * row + 4), nextSums[1]);
    }
    sum = mulAdd(last_, directionAt(2), sums[0] + sums[1]);
    nextSum = mulAdd(last_, directionAt(3), nextSums[0] + nextSums[1]);
  }

  template <bool acts, bool isFirst>
  [[gnu::always_inline]] void findOrder(int k, Acting acting, [[maybe_unused]] Four sum) {
    const Pair half = mulAdd(turning_, ofTurning_, direction_ * ofDirection_);
    const Pair parts = half - swapped(half);
    Pair early, turns;
    if constexpr (!isFirst) {
      sumOfU_ += ofU_;
      early = mulAdd(ofSum_, Pair(sum.v[2]), sumOfU_ * Pair(sum.v[0]));
    }
    if constexpr (acts) {
      Lane given = mulAdd(ofN_, acting.N, ofF_ * s0_ * acting.f);
      if constexpr (!isFirst) given = mulAdd(ofF_ * Lane(rows_[row + 4]), lastF_, given);
      early += Pair(Pair::Register{-given.v, given.v});
    }
    if constexpr (!isFirst) {
      omega_ = over(inverses_, k, alpha_);
      alpha_ = parts + mulAdd(late_, omega_, mulAdd(late_, alpha_, early));
      last_ = joined(omega_, X_);
      last_.store(rows_ + row * k);
      turns = mulAdd(omega1_, swapped(direction_), first(sum));
      turns = mulAdd(omega_, Pair::load(rows_ + row + 4), turns);
    } else {
      alpha_ = parts + early;
    }
    ofDirection_ += moreOfDirection_;
    ofTurning_ += moreOfTurning_;

    // Order k + 1
    direction_ = over(inverses_, k + 1, turning_);
    if constexpr (!isFirst) direction_ = mulAdd(omega_, over(inverses_, k + 1, start_), direction_);
    const Pair direction = swapped(direction_);
    joined(direction, direction).store(rows_ + row * (k + 1) + 4);
    turning_ = mulAdd(omega0_, direction, turns);

    sumOfX_ += ofX_;
    Lane X = mulAdd(s0X_, Lane(alpha_.v[1]), -(sumOfX_ * Lane(turning_.v[0])));
    if constexpr (acts) X = mulAdd(Lane(cart_.perMass), lastF_ = acting.f, X);
    X_ = Pair(X.v);
    if (isFirst) X -= Lane(along_);
    const Pair positions = over(inverses_, k + 1, rates_);
    rates_ = over(inverses_, k + 1, Pair(Pair::Register{X.v, alpha_.v[1]}));
    joined(positions, rates_).store(c_ + 4 * k + 4);
  }

  const SeriesCart& cart_;
  double *rows_, *e_;
  const double* inverses_;
  double* c_;
  double along_;
  Lane s0_, ofN_, ofF_, ofX_, sumOfX_, s0X_;
  Pair ofSum_, ofU_, sumOfU_, ofDirection_, moreOfDirection_, ofTurning_, moreOfTurning_, late_, omega0_,
      omega1_, start_;
  Four last_;
  Pair direction_;      ///< c, s
  Pair turning_;        ///< −w, v without ω_k
  Pair omega_, alpha_;  ///< of opposite signs
  Pair X_, rates_;
  Lane lastF_;
};

void seriesOfCart(const SeriesArrays& of, int order, const Loads& external, SeriesLoads* loads, double* c) {
  CartAndPole both(of, external.ground, c);
  if (external.N) return both.findAll<true>(order, external, loads);
  both.findAll<false>(order, external, nullptr);
}

}  // namespace
}  // namespace planar_chain::simd
