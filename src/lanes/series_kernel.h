#pragma once

/// Taylor coefficients of a chain's motion, order by order. See motion_series.h for the equations.
///
/// The coefficient of a product is a sum over those of its factors (Cauchy),
///
///     (xy)_k = x_k y_0 + x_0 y_k + Σ_{0<j<k} x_j y_{k−j}
///
/// All but its first two terms are known before order k: they are computed for all products together, in
/// lanes.

#include "lanes/kernel.h"
#include "simd/lanes.h"

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

/// Σ_{0<j<k} of `columns` products. Each order has a row of `width` first factors and one of second factors.
template <int columns>
[[gnu::always_inline]] inline void findKnown(const double* rows, int width, int k, double* known) {
  constexpr int registers = columns / laneCount;
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

/// Input of order k, and the places of order k + 1.
struct Order {
  int k;
  double *rows, *row;  ///< of the products: order 0, and k
  int n;
  const double *N, *omega;
  const Vec2d* F;
  double* next;                      ///< θ and then ω
  const Rotation<double>*start, *e;  ///< exp(i θ_j): order 0, and k
  Rotation<double>* nextE;
  double perOrder, perNext;  ///< 1/(k + 1), 1/(k + 2)

  Number moment(int j) const { return N ? N[j] : 0; }
};

inline Vec2<Number> pairAt(const double* from) {
  return {from[0], from[1]};
}
inline void storePair(double* to, Vec2<Number> a) {
  to[0] = a.x.v;
  to[1] = a.y.v;
}

/// Order k of the products from a column on. They come in pairs, in columns i and i + 1.
template <bool isFirst>
class Products {
 public:
  Products(const Order& order, int width, int column, const double* known)
      : x0_(order.rows + column),
        y0_(x0_ + width),
        x_(order.row + column),
        y_(x_ + width),
        known_(known + column) {}

  void setX(int i, Vec2<Number> x) const { storePair(x_ + i, x); }
  Vec2<Number> firstX(int i) const { return pairAt(x0_ + i); }
  Vec2<Number> operator()(int i) const {
    const Vec2<Number> x = firstX(i), y = pairAt(y_ + i);
    if constexpr (isFirst) return {x.x * y.x, x.y * y.y};
    const Vec2<Number> rest = withoutLast(i);
    return {mulAdd(x.x, y.x, rest.x), mulAdd(x.y, y.y, rest.y)};
  }

  /// A cross product has the components of its second factor exchanged.
  void setCrossY(int i, Vec2<Number> y) const { storePair(y_ + i, {y.y, y.x}); }
  /// number − product, y coming last
  Number lessCross(Number number, int i, Vec2<Number> y) const {
    if constexpr (!isFirst) {
      const Vec2<Number> rest = withoutLast(i);
      number -= rest.x - rest.y;
    }
    const Vec2<Number> x = firstX(i);
    return mulAdd(x.y, y.x, mulAdd(-x.x, y.y, number));
  }

 private:
  Vec2<Number> withoutLast(int i) const {
    const Vec2<Number> x = pairAt(x_ + i), y = pairAt(y0_ + i), known = pairAt(known_ + i);
    return {mulAdd(x.x, y.x, known.x), mulAdd(x.y, y.y, known.y)};
  }

  const double *x0_, *y0_;
  double *x_, *y_;
  const double* known_;
};

inline Rotation<Number> numbersOf(const Rotation<double>& e) {
  return {e.c, e.s};
}

// ---- How a body turns --------------------------------------------------------------------------------

/// Columns i and i + 1 are ω c and ω s, the second factor one order ahead. With z = Σ_{j≤k} ω_j e_{k+1−j},
///
///     ë_k = i (α_k e_0 + (k+1) z)        e_{k+2} = i (ω_{k+1} e_0 + z)/(k+2)        (k+1) ω_{k+1} = α_k
template <bool isFirst>
[[gnu::always_inline]] inline Rotation<Number> turning(const Products<isFirst>& product, Number omega) {
  product.setX(0, {omega, omega});
  const Vec2<Number> z = product(0);
  return {z.x, z.y};
}

/// ë_k b as if α_k were 0.
[[gnu::always_inline]] inline Vec2<Number> second(const Order& order, Rotation<Number> z, Vec2<Number> b) {
  return Rotation<Number>{-z.s, z.c} * (Number(order.k + 1) * b);
}

/// Writes order k + 1 of the angle, rate and e of body j, and e to `column` of the second factors.
[[gnu::always_inline]] inline void goOn(const Order& order, int width, int column, int j, Rotation<Number> z,
                                        Number alpha) {
  const Number part(order.perNext), turn = Number(order.perOrder * order.perNext) * alpha;
  const Rotation<Number> start = numbersOf(order.start[j]);
  const Rotation<Number> e{mulAdd(-turn, start.s, -part * z.s), mulAdd(turn, start.c, part * z.c)};
  order.next[j] = order.perOrder * order.omega[j];
  order.next[order.n + j] = (Number(order.perOrder) * alpha).v;
  order.nextE[j] = {e.c.v, e.s.v};
  storePair(order.row + 3 * width + column, {e.c, e.s});
}

/// e_1 = i ω_0 e_0
inline void beginTurning(const SeriesArrays& of, int j, int column, Number omega) {
  const Rotation<Number> start = numbersOf(of.e[j]), e{-omega * start.s, omega * start.c};
  of.e[of.n + j] = {e.c.v, e.s.v};
  storePair(of.rows + of.width + column, {e.c, e.s});
}

}  // namespace
}  // namespace planar_chain::simd
