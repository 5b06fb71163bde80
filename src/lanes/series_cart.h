#pragma once

/// The Taylor series of a slide and one body on it, such as a cart and its pole. See motion_series.h for the
/// rules.
///
/// In axes along the rail and across it, m R = σ (c, s), and the acceleration of the ground pin less gravity
/// is (g_∥, g_⊥). With M the mass of both, f the force along the rail, X the acceleration of the slide + g_∥,
/// and J of the body,
///
///     ṡ = v = ω c      ċ = −w = −ω s      M X = f + σ ẇ      J α = N + σ (s X − g_⊥ c)
///
/// An order takes the sums for w_{k+1}, v_{k+1} and (s X)_k, side by side. W is w_{k+1} without its last term
/// ω_{k+1} s_0 = α_k s_0/(k+1). So
///
///     Δ α_k = M (N_k − σ g_⊥ c_k + σ Σ_{0<j≤k} s_j X_{k−j}) + σ s_0 (f_k + σ (k+1) W)      Δ = M J − σ² s_0²
///
/// Each order waits for the one before. So α_k is found without what ω_k = α_{k−1}/k adds to it, which is
/// κ (α_{k−1} + ω_k) with κ = 2 σ² s_0 c_0 ω_0/Δ. That comes last.

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
        along_(dot(cart_.rail, ground)) {
    const Rotation<double> e = Rotation<double>{of.e[2], of.e[3]} * cart_.turn;
    const double sigma = cart_.moment, omega = c[3];
    const double inverse = 1 / (cart_.least + sigma * sigma * e.c * e.c), kappa = sigma * sigma * inverse;
    s0_ = Lane(e.s);
    ofX_ = Lane(cart_.perMass * sigma);
    ofN_ = Lane(cart_.mass * inverse);
    const double ofSum = sigma * ofN_.v, ofU = -kappa * e.s;
    ofSum_ = {Pair::Register{-ofSum, ofSum}};
    ofU_ = sumOfU_ = {Pair::Register{-ofU, ofU}};
    ofF_ = Lane(sigma * inverse);
    ofPlace_ = {Pair::Register{-cross(cart_.rail, ground) * ofSum, 0}};
    ofTurning_ = {Pair::Register{0, -omega * ofU}};
    moreOfTurning_ = {Pair::Register{-kappa * omega * e.c, 0}};
    late_ = Pair(2 * e.c * ofTurning_.v[1]);
    place_ = {Pair::Register{e.c, e.s}};
    start_ = swapped(place_);
    omega_ = omega0_ = {Pair::Register{-omega, omega}};
    turning_ = omega_ * start_;
    rates_ = Pair::load(c + 2);
  }

  /// N, F: of order 0 at first; `loads` may be nullptr.
  template <bool acts>
  [[gnu::always_inline]] void findAll(int order, const Outside& outside, SeriesLoads* loads) {
    const auto find = [&](int k, auto isFirst) {
      Acting acting;
      if constexpr (acts) {
        if (loads && !isFirst) findLoads(k, loads);
        acting = {Lane(outside.N[1]), Lane(outside.N[0])};
        if (outside.F) acting.f += Lane(dot(cart_.rail, outside.F[0] + outside.F[1]));
      }
      findOrder<acts, isFirst>(k, acting);
    };
    find(0, std::true_type());
    for (int k = 1; k < order; ++k) find(k, std::false_type());
  }

 private:
  /// Row k has −ω_k, ω_k, X_{k−1}; then s_k, c_k, s_k.
  static constexpr int row = 8;
  struct Acting {
    Lane N, f;
  };

  void findLoads(int k, SeriesLoads* loads) const {
    const Rotation<double> e =
        Rotation<double>{place_.v[0], place_.v[1]} * Rotation<double>{cart_.turn.c, -cart_.turn.s};
    e_[4 * k + 2] = e.c;
    e_[4 * k + 3] = e.s;
    loads->findOrder(k, c_ + 4 * k, c_ + 4 * k + 2);
  }

  /// The products of rows i = 2 … k − 2 and k + 1 − i
  [[gnu::always_inline]] Four sumFromMemory(int k) const {
    Four sums[2];
    const double *x = rows_ + 2 * row, *y = rows_ + row * (k - 1) + 4;
    const auto add = [&](int i) {
      sums[i] = mulAdd(Four::load(x + row * i), Four::load(y - row * i), sums[i]);
    };
    for (; y > rows_ + 4 * row; x += 2 * row, y -= 2 * row) {
      add(0);
      add(1);
    }
    if (y > rows_ + 3 * row) add(0);
    return sums[0] + sums[1];
  }

  template <bool acts, bool isFirst>
  [[gnu::always_inline]] void findOrder(int k, Acting acting) {
    const Pair signs = {Pair::Register{-1, 1}};
    Pair parts = mulAdd(turning_, ofTurning_, place_ * ofPlace_);
    Four sum;
    Pair early, turns;
    if constexpr (!isFirst) {
      sum = mulAdd(last_, Four::load(rows_ + 2 * row + 4), sumFromMemory(k));
      sumOfU_ += ofU_;
      early = mulAdd(ofSum_, Pair(sum.v[2]), sumOfU_ * Pair(sum.v[0]));
    }
    if constexpr (acts) {
      Lane given = mulAdd(ofN_, acting.N, ofF_ * s0_ * acting.f);
      if constexpr (!isFirst) given = mulAdd(ofF_ * Lane(rows_[row + 4]), lastF_, given);
      early = mulAdd(signs, Pair(given.v), early);
    }
    if constexpr (!isFirst) {
      omega_ = over(inverses_, k, alpha_);
      alpha_ = mulAdd(signs, parts + swapped(parts), early) + mulAdd(late_, omega_, late_ * alpha_);
      const Four last = joined(omega_, X_);
      last.store(rows_ + row * k);
      turns = mulAdd(omega1_, swapped(place_), first(sum));
      turns = mulAdd(omega_, Pair::load(rows_ + row + 4), turns);
      turning_ = mulAdd(omega_, start_, turning_);
      if (k == 1) {
        omega1_ = omega_;
        moreOfPlace_ = {Pair::Register{0, -ofU_.v[1] * omega_.v[1]}};
        ofPlace_ += {Pair::Register{0, ofSum_.v[1] * X_.v[0] + 2 * moreOfPlace_.v[1]}};
      } else {
        last_ = last;
      }
    } else {
      alpha_ = mulAdd(signs, parts + swapped(parts), early);
    }
    ofPlace_ += moreOfPlace_;
    ofTurning_ += moreOfTurning_;

    // Order k + 1
    place_ = over(inverses_, k + 1, turning_);
    const Pair place = swapped(place_);
    joined(place, place).store(rows_ + row * (k + 1) + 4);
    turning_ = mulAdd(omega0_, place, turns);
    orders_ += Pair(1);

    Lane X = ofX_ * mulAdd(s0_, Lane(alpha_.v[1]), -(Lane(orders_.v[0]) * Lane(turning_.v[0])));
    if constexpr (acts) X = mulAdd(Lane(cart_.perMass), lastF_ = acting.f, X);
    X_ = Pair(X.v);
    if (isFirst) X -= Lane(along_);
    (rates_ / orders_).store(c_ + 4 * k + 4);
    rates_ = Pair(Pair::Register{X.v, alpha_.v[1]}) / orders_;
    rates_.store(c_ + 4 * k + 6);
  }

  const SeriesCart& cart_;
  double *rows_, *e_;
  const double* inverses_;
  double* c_;
  double along_;
  Lane s0_, ofN_, ofF_, ofX_;
  Pair ofSum_, ofU_, sumOfU_, ofPlace_, moreOfPlace_, ofTurning_, moreOfTurning_, late_, omega0_, omega1_,
      start_;
  Four last_;
  Pair orders_;
  Pair place_;          ///< c, s
  Pair turning_;        ///< −w, v without ω_k
  Pair omega_, alpha_;  ///< of opposite signs
  Pair X_, rates_;
  Lane lastF_;
};

void seriesOfCart(const SeriesArrays& of, int order, const Outside& outside, SeriesLoads* loads, double* c) {
  CartAndPole both(of, outside.ground, c);
  if (outside.N) return both.findAll<true>(order, outside, loads);
  both.findAll<false>(order, outside, nullptr);
}

}  // namespace
}  // namespace planar_chain::simd
