#pragma once

/// Taylor coefficients of a chain's motion, order by order. See motion_series.h for the equations.
///
/// The coefficient of a product is a sum over those of its factors (Cauchy),
///
///     (xy)_k = x_k y_0 + x_0 y_k + Σ_{0<j<k} x_j y_{k−j}
///
/// All but its first two terms are known before order k: they are computed for all products together, in
/// lanes. `Some` is Number for one chain, Real for one in each lane.

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
  Lanes sums[2][registers];
  forInnerOrders(k, [&](int first, int second, int part) {
    const double *x = rows + 2 * first * width, *y = rows + (2 * second + 1) * width;
    PLANAR_CHAIN_WRITTEN_OUT
    for (int r = 0; r < registers; ++r) {
      Lanes& sum = sums[part][r];
      sum = mulAdd(Lanes::load(x + r * laneCount), Lanes::load(y + r * laneCount), sum);
    }
  });
  PLANAR_CHAIN_WRITTEN_OUT
  for (int r = 0; r < registers; ++r) (sums[0][r] + sums[1][r]).store(known + r * laneCount);
}

// ---- Numbers and pairs in memory ---------------------------------------------------------------------

/// Numbers i and i + 1.
template <class Some>
[[gnu::always_inline]] inline Vec2<Some> pairAt(const double* numbers, int i) {
  return {read<Some>(numbers, i), read<Some>(numbers, i + 1)};
}
template <class Some>
[[gnu::always_inline]] inline void storePair(double* numbers, int i, Vec2<Some> a) {
  a.x.store(numbers + i * doubles<Some>);
  a.y.store(numbers + (i + 1) * doubles<Some>);
}
/// exp(i θ_j)
template <class Some>
[[gnu::always_inline]] inline Rotation<Some> rotationAt(const double* e, int j) {
  return {read<Some>(e, 2 * j), read<Some>(e, 2 * j + 1)};
}
template <class Some>
[[gnu::always_inline]] inline SeriesLink<Some> seriesLinkAt(const double* links, int j) {
  SeriesLink<Some> link;
  Reader{links + j * doubles<SeriesLink<Some>>}(link.m, link.I, link.J, link.mr, link.p);
  return link;
}

/// 1/k in two parts. The rounding of 1/3, the same in every step, would make each add energy.
struct Inverse {
  explicit Inverse(int k) : whole(1.0 / k), rest(mulAdd(Number(-k), whole, Number(1)) * whole) {}
  Number whole, rest;
};
/// a/k
template <int count>
[[gnu::always_inline]] inline LanesOf<count> operator*(LanesOf<count> a, Inverse perK) {
  using Some = LanesOf<count>;
  return mulAdd(a, Some(perK.whole.v), a * Some(perK.rest.v));
}

/// Input of order k, and the places of order k + 1.
template <class Some>
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

  Some rate(int j) const { return read<Some>(omega, j); }
  Some moment(int j) const { return N ? read<Some>(N, j) : Some(0); }
};

/// Order k of the products from a column on. They come in pairs, in columns i and i + 1.
template <class Some, bool isFirst>
class Products {
 public:
  Products(const Order<Some>& order, int width, int column, const double* known)
      : x0_(order.rows + column * doubles<Some>),
        y0_(x0_ + width * doubles<Some>),
        x_(order.row + column * doubles<Some>),
        y_(x_ + width * doubles<Some>),
        known_(known + column * doubles<Some>) {}

  void setX(int i, Vec2<Some> x) const { storePair(x_, i, x); }
  Vec2<Some> firstX(int i) const { return pairAt<Some>(x0_, i); }
  Vec2<Some> operator()(int i) const {
    const Vec2<Some> x = firstX(i), y = pairAt<Some>(y_, i);
    if constexpr (isFirst) return {x.x * y.x, x.y * y.y};
    const Vec2<Some> rest = withoutLast(i);
    return {mulAdd(x.x, y.x, rest.x), mulAdd(x.y, y.y, rest.y)};
  }

  /// A cross product has the components of its second factor exchanged.
  void setCrossY(int i, Vec2<Some> y) const { storePair<Some>(y_, i, {y.y, y.x}); }
  /// number − product, y coming last
  Some lessCross(Some number, int i, Vec2<Some> y) const {
    if constexpr (!isFirst) {
      const Vec2<Some> rest = withoutLast(i);
      number -= rest.x - rest.y;
    }
    const Vec2<Some> x = firstX(i);
    return mulAdd(x.y, y.x, mulAdd(-x.x, y.y, number));
  }

 private:
  Vec2<Some> withoutLast(int i) const {
    const Vec2<Some> x = pairAt<Some>(x_, i), y = pairAt<Some>(y0_, i), known = pairAt<Some>(known_, i);
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
template <class Some, bool isFirst>
[[gnu::always_inline]] inline Rotation<Some> turning(const Products<Some, isFirst>& product, Some omega) {
  product.setX(0, {omega, omega});
  const Vec2<Some> z = product(0);
  return {z.x, z.y};
}

/// ë_k b as if α_k were 0.
template <class Some>
[[gnu::always_inline]] inline Vec2<Some> second(const Order<Some>& order, Rotation<Some> z, Vec2<Some> b) {
  return Rotation<Some>{-z.s, z.c} * (Some(order.k + 1) * b);
}

/// Writes order k + 1 of the angle, rate and e of body j, and e to `column` of the second factors.
template <class Some>
[[gnu::always_inline]] inline void goOn(const Order<Some>& order, int width, int column, int j,
                                        Rotation<Some> z, Some alpha) {
  const double perOrder = order.perOrder.whole.v, perNext = order.perNext.whole.v;
  const Some part(perNext), turn = Some(perOrder * perNext) * alpha;
  const Rotation<Some> start = rotationAt<Some>(order.start, j);
  const Vec2<Some> e{mulAdd(-turn, start.s, -part * z.s), mulAdd(turn, start.c, part * z.c)};
  (Some(perOrder) * order.rate(j)).store(order.next + j * doubles<Some>);
  (Some(perOrder) * alpha).store(order.next + (order.n + j) * doubles<Some>);
  storePair(order.nextE, 2 * j, e);
  storePair(order.row, 3 * width + column, e);
}

/// e_1 = i ω_0 e_0
template <class Some>
inline void beginTurning(const SeriesArrays& of, int width, int j, int column, Some omega) {
  const Rotation<Some> start = rotationAt<Some>(of.e, j);
  const Vec2<Some> e{-omega * start.s, omega * start.c};
  storePair(of.e, 2 * (of.n + j), e);
  storePair(of.rows, width + column, e);
}

}  // namespace
}  // namespace planar_chain::simd
