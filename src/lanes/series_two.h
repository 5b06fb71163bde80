#pragma once

/// The Taylor series of two bodies. See motion_series.h for the equations. Each order waits for the one
/// before. So both bodies are computed at once. It takes a third of the time of the series for any
/// number of bodies.

#include "lanes/series_kernel.h"

namespace planar_chain::simd {
namespace {

// ---- Two pairs of numbers ------------------------------------------------------------------------------

using Four = PackOf<4>;

/// Both numbers of a pair are the same.
Four pairsOf(double first, double second) {
  return {Four::Register{first, first, second, second}};
}
Four pairsOf(Vec2d first, Vec2d second) {
  return {Four::Register{first.x, first.y, second.x, second.y}};
}

/// Both numbers of each pair become its first, or its second.
Four firsts(Four a) {
  return shuffled(a, a, [](int s) { return s & ~1; });
}
Four seconds(Four a) {
  return shuffled(a, a, [](int s) { return s | 1; });
}
/// The numbers of each pair change places.
Four turned(Four a) {
  return shuffled(a, a, [](int s) { return s ^ 1; });
}
/// The pairs change places.
Four exchanged(Four a) {
  return shuffled(a, a, [](int s) { return s ^ 2; });
}
/// The first numbers of all pairs.
Four heads(Four a, Four b) {
  return shuffled(a, b, [](int s) { return 2 * s; });
}

// ---- Two bodies ----------------------------------------------------------------------------------------

/// With the first moments S_1 = m_1 R_1 + m_2 P_1 and S_2 = m_2 R_2, and κ = P_1·S_2 of order 0,
///
///     M_11 α_1 + κ α_2 = N_1 − S_1×a − P_1×(S̈_2 − F_2)            M_11 = J_1 + m_2 |p_1|²
///        κ α_1 + J_2 α_2 = N_2 − S_2×a − S_2×P̈_1
///
/// in order k, where P̈_1 and S̈_2 on the right are as if α_k were 0; det M as in short_kernel.h.
///
/// A pair for each body: e, (ω, ω), C = (P_1, S_2). Columns 0 … 3 are those of ω e, see turning(); columns 4
/// … 7 those of the cross products, (x, −y) of P_1 and S_2 times (y, x) of S̈_2 − F_2 and P̈_1.
class Two {
 public:
  using RealType = Lane;
  Two(const SeriesArrays& of, Vec2<Lane> at, const double* omega) {
    const auto* links = reinterpret_cast<const SeriesLink<double>*>(of.links);
    const SeriesLink<double>&first = links[0], &second = links[1];
    const Vec2d ground{at.x.v, at.y.v};
    const Rotation<double> e0{of.e[0], of.e[1]}, e1{of.e[2], of.e[3]};
    const Vec2d s1 = first.mr + second.m * first.p, s2 = second.mr;
    across_ = pairsOf({cross(s1, ground), -dot(s1, ground)}, {cross(s2, ground), -dot(s2, ground)});
    body_ = pairsOf(first.p, s2);
    turnedBody_ = i(body_);
    minusBody_ = Four(0) - body_;
    ie0_ = i(Four::load(of.e));

    e_ = Four::load(of.e);
    const Vec2d P1 = e0 * first.p, S2 = e1 * s2;
    iC0_ = i(pairsOf(P1, S2));
    const double mPP = second.m * dot(first.p, first.p), kappa = dot(P1, S2), lambda = cross(P1, S2);
    const double inverse = 1 / (first.J * second.J + mPP * second.I + lambda * lambda);
    minusInverse_ = pairsOf(-inverse * second.J, -inverse * (first.J + mPP));
    minusInverseAcross_ = Four(inverse * kappa);

    omega_ = pairsOf(omega[0], omega[1]);
    nextE_ = omega_ * ie0_;
    nextE_.store(of.e + 4);
  }
  int bodies() const { return 2; }
  int stride() const { return width; }

  void know(const double* rows, int k) {
    Four turns[2], crosses[2];
    forInnerOrders(k, [&](int first, int second, int part) {
      const double *x = rows + 2 * first * width, *y = rows + (2 * second + 1) * width;
      turns[part] = mulAdd(Four::load(x), Four::load(y), turns[part]);
      crosses[part] = mulAdd(Four::load(x + 4), Four::load(y + 4), crosses[part]);
    });
    knownTurn_ = turns[0] + turns[1];
    knownCross_ = crosses[0] + crosses[1];
  }

  template <bool isFirst>
  [[gnu::always_inline]] void find(const Order<Lane>& order) {
    const Four x = conjugate(rotated(e_, body_, turnedBody_));
    double* row = order.row;
    omega_.store(row);
    x.store(row + 4);
    nextE_.store(row + width);

    // z and, in two parts, what is left of the moments, less what comes late
    Four z, left = e_ * across_ - pairsOf(Vec2d{order.moment(0).v}, Vec2d{order.moment(1).v});
    if constexpr (!isFirst) {
      const double *x0 = order.rows, *y0 = x0 + width;
      z = mulAdd(omega_, Four::load(y0), knownTurn_);
      left = mulAdd(x, Four::load(y0 + 4), left + knownCross_);
    }
    z = mulAdd(Four::load(order.rows), nextE_, z);
    const Four orders(order.k + 1);
    Four Cdd = rotated(z, orders * turnedBody_, orders * minusBody_);
    if (order.F) Cdd = Cdd - pairsOf({}, {order.F[2], order.F[3]});
    left = mulAdd(Four::load(order.rows + 4), crossed(Cdd), left);
    const Four f = left + turned(left);
    const Four alpha = mulAdd(minusInverse_, f, minusInverseAcross_ * exchanged(f));

    // Order k + 1
    const Four nextOmega = alpha * order.perOrder;
    heads(omega_ * order.perOrder, nextOmega).store(order.next);
    crossed(mulAdd(alpha, iC0_, Cdd)).store(row + width + 4);
    omega_ = nextOmega;
    e_ = nextE_;
    nextE_ = mulAdd(nextOmega, ie0_, i(z)) * order.perNext;
    nextE_.store(order.nextE);
  }

 private:
  static constexpr int width = SeriesArrays::chunk;

  static Four conjugate(Four a) { return a * pairsOf(Vec2d{1, -1}, {1, -1}); }
  static Four i(Four a) { return turned(a) * pairsOf(Vec2d{-1, 1}, {-1, 1}); }
  /// e b
  static Four rotated(Four e, Four b, Four ib) { return mulAdd(firsts(e), b, seconds(e) * ib); }
  /// What a pair of (x, −y) times it gives, summed, is its cross product with the other pair.
  static Four crossed(Four a) { return turned(exchanged(a)); }

  Four across_, body_, turnedBody_, minusBody_, ie0_, iC0_, minusInverse_, minusInverseAcross_;
  Four e_, nextE_, omega_;  ///< of order k, k + 1 and k
  Four knownTurn_, knownCross_;
};

}  // namespace
}  // namespace planar_chain::simd
