#pragma once

/// The Taylor series of any number of bodies; see motion_series.h for the equations.

#include "lanes/series_kernel.h"
#include "lanes/series_known.h"
#include "lanes/series_one.h"
#include "lanes/series_two.h"

namespace planar_chain::simd {
namespace {

/// A body at the order in hand.
template <class Number>
struct BodyInSeries {
  // Of order 0: U/D, 1/D, and the articulated mass at the outer pin.
  Vec2<Number> W;
  Number inverseD;
  Sym2<Number> A;
  // As if its α were 0: a of the inner pin, f on the next link; then b and u/D; z: see turning().
  Vec2<Number> a, f, b;
  Number v;
  Rotation<Number> z;
};
static_assert(sizeof(BodyInSeries<Number>) == SeriesArrays::bodyNumbers * sizeof(double));

/// Link by link. Columns of each: how it turns, m R×a, P×f, with a of the inner pin and f on the next link.
template <class Number>
class Links {
 public:
  using Some = Number;
  /// The articulated masses at order 0.
  Links(const SeriesArrays& of, Vec2<Some> ground, const double* omega)
      : n_(of.n), width_(of.width), sums_(of.known), known_(of.known), links_(of.links), ground_(ground) {
    bodies_ = reinterpret_cast<BodyInSeries<Some>*>(of.bodies);
    Sym2<Some> A;
    for (int j = n_ - 1; j >= 0; --j) {
      beginTurning(of, width_, j, columns * j, read<Some>(omega, j));
      const SeriesLink<Some> link = seriesLinkAt<Some>(links_, j);
      const Rotation<Some> e = rotationAt<Some>(of.e, j);
      const Vec2<Some> P = e * link.p, AiP = A * perp(P);
      const Vec2<Some> U = perp(e * link.mr) + AiP;
      const Some m = link.m, inverse = Some(1) / (link.J + dot(perp(P), AiP));
      const Vec2<Some> W = inverse * U;
      bodies_[j].A = A;
      bodies_[j].W = W;
      bodies_[j].inverseD = inverse;
      A = {m + A.xx - U.x * W.x, A.xy - U.x * W.y, m + A.yy - U.y * W.y};
    }
  }
  int bodies() const { return n_; }
  int stride() const { return width_; }
  void know(const double* rows, int k) {
    if constexpr (doubles<Some> == 1) {
      constexpr int chunk = SeriesArrays::chunk;
      for (int at = 0; at < width_; at += chunk) {
        findKnown<chunk / laneCount>(rows + at, width_, k, known_ + at);
      }
    } else {
      known_ = knowPairs<columns, 2>(rows, width_, k, sums_);
    }
  }

  template <bool isFirst>
  void find(const Order<Some>& order) {
    const auto productsOf = [&](int j) {
      return Products<Some, isFirst>(order, width_, columns * j, known_);
    };

    // As if α_k were 0: accelerations, outwards.
    Vec2<Some> a = isFirst ? ground_ : Vec2<Some>{};
    for (int j = 0; j < n_; ++j) {
      BodyInSeries<Some>& body = bodies_[j];
      const auto product = productsOf(j);
      const Rotation<Some> e = rotationAt<Some>(order.e, j);
      const SeriesLink<Some> link = seriesLinkAt<Some>(links_, j);
      body.z = turning(product, order.rate(j));
      product.setX(mRa, e * link.mr);
      product.setX(Pf, e * link.p);
      body.a = a;
      body.f = mulAdd(link.m, a, second(order, body.z, link.mr));
      a += second(order, body.z, link.p);
    }

    // Forces, inwards, and what moment is left over; b of all that it makes move.
    Vec2<Some> f, b;
    for (int j = n_ - 1; j >= 0; --j) {
      BodyInSeries<Some>& body = bodies_[j];
      const auto product = productsOf(j);
      const Some own = product.lessCross(order.moment(j), mRa, body.a);
      const Some left = product.lessCross(own, Pf, f);
      const Some u = left - cross(product.firstX(Pf), b);
      const Vec2<Some> inertial = body.f;
      body.v = body.inverseD * u;
      body.f = f;
      body.b = b;
      f += inertial;
      if (order.F) f -= pairAt<Some>(order.F, 2 * j);
      b = mulAdd(u, body.W, b);
    }

    // α_k, outwards, and what it does.
    Vec2<Some> da;
    for (int j = 0; j < n_; ++j) {
      const BodyInSeries<Some>& body = bodies_[j];
      const auto product = productsOf(j);
      const Some alpha = body.v - dot(body.W, da);
      product.setCrossY(mRa, body.a + da);
      da = mulAdd(alpha, perp(product.firstX(Pf)), da);
      product.setCrossY(Pf, body.f + body.A * da + body.b);
      goOn(order, width_, columns * j, j, body.z, alpha);
    }
  }

 private:
  static constexpr int columns = SeriesArrays::columns;
  enum { mRa = 2, Pf = 4 };
  int n_, width_;
  double *sums_, *known_;
  const double* links_;
  BodyInSeries<Some>* bodies_;
  Vec2<Some> ground_;
};

// ---- All orders --------------------------------------------------------------------------------------

/// Order 0 of what acts, as in Order; and the acceleration of the ground pin less gravity.
struct ActingInSeries {
  const double *N, *F, *ground;
};

template <bool isFirst, class Shape, class Loads>
[[gnu::always_inline]] inline void orderOf(Shape& shape, const SeriesArrays& of, int k,
                                           const ActingInSeries& acting, Inverse perOrder, Inverse perNext,
                                           Loads findLoads, double* c) {
  constexpr int d = doubles<typename Shape::Some>;
  const int n = shape.bodies();
  double* theta = c + k * 2 * n * d;
  double* omega = theta + n * d;
  const Order<typename Shape::Some> order{k,
                                          of.rows,
                                          of.rows + 2 * k * shape.stride() * d,
                                          n,
                                          acting.N,
                                          acting.F,
                                          omega,
                                          omega + n * d,
                                          of.e,
                                          of.e + 2 * k * n * d,
                                          of.e + 2 * (k + 2) * n * d,
                                          perOrder,
                                          perNext};
  if constexpr (!isFirst) {
    shape.know(of.rows, k);
    findLoads(k, theta, omega);
  }
  shape.template find<isFirst>(order);
}

/// findLoads(k, theta, omega) writes order k > 0 of N and F.
template <class Shape, class Loads>
[[gnu::always_inline]] inline void allOrders(const SeriesArrays& of, int order, const ActingInSeries& acting,
                                             Loads findLoads, double* c) {
  using Some = typename Shape::Some;
  Shape shape(of, pairAt<Some>(acting.ground, 0), c + of.n * doubles<Some>);
  Inverse perOrder(2);
  orderOf<true>(shape, of, 0, acting, Inverse(1), perOrder, findLoads, c);
  for (int k = 1; k < order; ++k) {
    const Inverse perNext(k + 2);
    orderOf<false>(shape, of, k, acting, perOrder, perNext, findLoads, c);
    perOrder = perNext;
  }
}

template <class Shape>
void seriesOf(const SeriesArrays& of, int order, const Outside& outside, SeriesLoads* loads, double* c) {
  const ActingInSeries acting{outside.N, outside.F ? &outside.F->x : nullptr, &outside.ground.x};
  const auto findLoads = [loads](int k, const double* theta, const double* omega) {
    if (loads) loads->findOrder(k, theta, omega);
  };
  allOrders<Shape>(of, order, acting, findLoads, c);
}

}  // namespace
}  // namespace planar_chain::simd
