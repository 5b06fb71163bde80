#pragma once

/// Taylor coefficients of a chain's motion, order by order. See motion_series.h for the equations.
///
/// The coefficient of a product is a sum over those of its factors (Cauchy),
///
///     (xy)_k = x_k y_0 + x_0 y_k + Σ_{0<j<k} x_j y_{k−j}
///
/// All but its first two terms are known before order k: they are computed for all products together, in
/// lanes. `Real` is Lane for one chain, Pack for one in each lane.

#include "lanes/kernel.h"
#include "lanes/lane_kernel.h"

namespace planar_chain::simd {
namespace {

/// Calls add(i, j, part) for all i + j = k, both at least 1. It begins in the middle, as the last
/// orders have hardly been stored. Parts 0 and 1 take turns, so that no sum waits for every term.
template <class Add>
[[gnu::always_inline]] inline void forInnerOrders(int k, Add add) {
  int low = k / 2, high = k - low;
  if (low == high) add(low--, high++, 0);
  for (; low >= 1; --low, ++high) {
    add(low, high, 0);
    add(high, low, 1);
  }
}

/// Σ_{0<j<k} of so many registers of products. Each order has a row of `width` first factors and one of
/// second factors.
template <int registers>
[[gnu::always_inline]] inline void findKnown(const double* rows, int width, int k, double* known) {
  Pack sums[2][registers];
  forInnerOrders(k, [&](int first, int second, int part) {
    const double *x = rows + 2 * first * width, *y = rows + (2 * second + 1) * width;
    PLANAR_CHAIN_WRITTEN_OUT
    for (int r = 0; r < registers; ++r) {
      Pack& sum = sums[part][r];
      sum = mulAdd(Pack::load(x + r * laneCount), Pack::load(y + r * laneCount), sum);
    }
  });
  PLANAR_CHAIN_WRITTEN_OUT
  for (int r = 0; r < registers; ++r) (sums[0][r] + sums[1][r]).store(known + r * laneCount);
}

// ---- Numbers and pairs in memory ---------------------------------------------------------------------

/// Numbers i and i + 1.
template <class Real>
[[gnu::always_inline]] inline Vec2<Real> pairAt(const double* numbers, int i) {
  return {read<Real>(numbers, i), read<Real>(numbers, i + 1)};
}
template <class Real>
[[gnu::always_inline]] inline void storePair(double* numbers, int i, Vec2<Real> a) {
  a.x.store(numbers + i * doubles<Real>);
  a.y.store(numbers + (i + 1) * doubles<Real>);
}
/// exp(i θ_j)
template <class Real>
[[gnu::always_inline]] inline Rotation<Real> rotationAt(const double* e, int j) {
  return {read<Real>(e, 2 * j), read<Real>(e, 2 * j + 1)};
}
template <class Real>
[[gnu::always_inline]] inline SeriesLink<Real> seriesLinkAt(const double* links, int j) {
  SeriesLink<Real> link;
  Reader{links + j * doubles<SeriesLink<Real>>}(link.m, link.I, link.J, link.mr, link.p);
  return link;
}

/// a/k, where 1/k has two parts. The rounding of 1/3, the same in every step, would make each add energy.
/// Only a fused multiplication sees the second part.
template <class Real>
[[gnu::always_inline]] inline Real quotient(Real a, [[maybe_unused]] int k, [[maybe_unused]] Real whole,
                                            [[maybe_unused]] Real rest) {
#ifdef PLANAR_CHAIN_FUSES
  return mulAdd(a, whole, a * rest);
#else
  return a / Real(k);
#endif
}

struct Inverse {
  explicit Inverse(int k_) : k(k_), whole(1.0 / k), rest(mulAdd(Lane(-k), whole, Lane(1)) * whole) {}
  int k;
  Lane whole, rest;
};
/// a/k
template <int count>
[[gnu::always_inline]] inline PackOf<count> operator*(PackOf<count> a, Inverse perK) {
  using Real = PackOf<count>;
  return quotient(a, perK.k, Real(perK.whole.v), Real(perK.rest.v));
}

/// Input of order k, and the positions of order k + 1.
template <class Real>
struct Order {
  int k;
  double *rows, *row;  ///< of the products: order 0, and k
  int n;
  const double *N, *F;  ///< moments, and pairs of forces; nullptr: none
  const double* omega;
  double* next;             ///< θ and then ω
  const double *start, *e;  ///< exp(i θ_j): order 0, and k
  double* nextE;
  Inverse perOrder, perNext;  ///< 1/(k + 1), 1/(k + 2)

  Real rate(int j) const { return read<Real>(omega, j); }
  Real moment(int j) const { return N ? read<Real>(N, j) : Real(0); }
};

/// Order k of the products from a column on. They come in pairs, in columns i and i + 1.
template <class Real, bool isFirst>
class Products {
 public:
  Products(const Order<Real>& order, int width, int column, const double* known)
      : x0_(order.rows + column * doubles<Real>),
        y0_(x0_ + width * doubles<Real>),
        x_(order.row + column * doubles<Real>),
        y_(x_ + width * doubles<Real>),
        known_(known + column * doubles<Real>) {}

  void setX(int i, Vec2<Real> x) const { storePair(x_, i, x); }
  Vec2<Real> firstX(int i) const { return pairAt<Real>(x0_, i); }
  Vec2<Real> operator()(int i) const {
    const Vec2<Real> x = firstX(i), y = pairAt<Real>(y_, i);
    if constexpr (isFirst) return {x.x * y.x, x.y * y.y};
    const Vec2<Real> rest = withoutLast(i);
    return {mulAdd(x.x, y.x, rest.x), mulAdd(x.y, y.y, rest.y)};
  }

  /// A cross product has the components of its second factor exchanged.
  void setCrossY(int i, Vec2<Real> y) const { storePair<Real>(y_, i, {y.y, y.x}); }
  /// number − product, y coming last
  Real lessCross(Real number, int i, Vec2<Real> y) const {
    if constexpr (!isFirst) {
      const Vec2<Real> rest = withoutLast(i);
      number -= rest.x - rest.y;
    }
    const Vec2<Real> x = firstX(i);
    return mulAdd(x.y, y.x, mulAdd(-x.x, y.y, number));
  }

 private:
  Vec2<Real> withoutLast(int i) const {
    const Vec2<Real> x = pairAt<Real>(x_, i), y = pairAt<Real>(y0_, i), known = pairAt<Real>(known_, i);
    return {mulAdd(x.x, y.x, known.x), mulAdd(x.y, y.y, known.y)};
  }

  const double *x0_, *y0_;
  double *x_, *y_;
  const double* known_;
};

// ---- How a body turns --------------------------------------------------------------------------------

/// Columns i and i + 1 are ω c and ω s, the second factor one order ahead. With z = Σ_{j≤k} ω_j e_{k+1−j},
///
///     ë_k = i (α_k e_0 + (k+1) z)        e_{k+2} = i (ω_{k+1} e_0 + z)/(k+2)        (k+1) ω_{k+1} = α_k
template <class Real, bool isFirst>
[[gnu::always_inline]] inline Rotation<Real> turning(const Products<Real, isFirst>& product, Real omega) {
  product.setX(0, {omega, omega});
  const Vec2<Real> z = product(0);
  return {z.x, z.y};
}

/// ë_k b as if α_k were 0.
template <class Real>
[[gnu::always_inline]] inline Vec2<Real> second(const Order<Real>& order, Rotation<Real> z, Vec2<Real> b) {
  return Rotation<Real>{-z.s, z.c} * (Real(order.k + 1) * b);
}

/// Writes order k + 1 of the angle, rate and e of body j, and e to `column` of the second factors.
template <class Real>
[[gnu::always_inline]] inline void goOn(const Order<Real>& order, int width, int column, int j,
                                        Rotation<Real> z, Real alpha) {
  const double perOrder = order.perOrder.whole.v, perNext = order.perNext.whole.v;
  const Real part(perNext), turn = Real(perOrder * perNext) * alpha;
  const Rotation<Real> start = rotationAt<Real>(order.start, j);
  const Vec2<Real> e{mulAdd(-turn, start.s, -part * z.s), mulAdd(turn, start.c, part * z.c)};
  (Real(perOrder) * order.rate(j)).store(order.next + j * doubles<Real>);
  (Real(perOrder) * alpha).store(order.next + (order.n + j) * doubles<Real>);
  storePair(order.nextE, 2 * j, e);
  storePair(order.row, 3 * width + column, e);
}

/// e_1 = i ω_0 e_0
template <class Real>
inline void beginTurning(const SeriesArrays& of, int width, int j, int column, Real omega) {
  const Rotation<Real> start = rotationAt<Real>(of.e, j);
  const Vec2<Real> e{-omega * start.s, omega * start.c};
  storePair(of.e, 2 * (of.n + j), e);
  storePair(of.rows, width + column, e);
}

}  // namespace
}  // namespace planar_chain::simd
