#pragma once

/// The Taylor series of one body and of any number; see motion_series.h for the equations.

#include "lanes/series_kernel.h"
#include "lanes/series_two.h"

namespace planar_chain::simd {
namespace {

/// J α = N − m R×a
class One {
 public:
  One(const SeriesArrays& of, Vec2d ground, const double* omega)
      : known_(of.known),
        inverseJ_(1 / of.links[0].J),
        acrossA_(cross(of.links[0].mr, ground)),
        alongA_(dot(of.links[0].mr, ground)) {
    beginTurning(of, 0, 0, omega[0]);
  }
  int bodies() const { return 1; }
  int stride() const { return width; }
  void know(const double* rows, int k) { findKnown<width>(rows, width, k, known_); }

  template <bool isFirst>
  [[gnu::always_inline]] void find(const Order& order) {
    const Products<isFirst> product(order, width, 0, known_);
    const Rotation<Number> z = turning(product, order.omega[0]), e = numbersOf(order.e[0]);
    const Number torque = order.moment(0) - mulAdd(e.c, acrossA_, -e.s * alongA_);
    goOn(order, width, 0, 0, z, inverseJ_ * torque);
  }

 private:
  static constexpr int width = SeriesArrays::chunk;
  double* known_;
  Number inverseJ_, acrossA_, alongA_;
};

/// A body at the order in hand.
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
static_assert(sizeof(BodyInSeries) == SeriesArrays::bodyNumbers * sizeof(double));

/// Link by link. Columns of each: how it turns, m R×a, P×f, with a of the inner pin and f on the next link.
class Links {
 public:
  /// The articulated masses at order 0.
  Links(const SeriesArrays& of, Vec2d ground, const double* omega)
      : n_(of.n), width_(of.width), known_(of.known), links_(of.links), ground_(vectorOf(ground)) {
    bodies_ = reinterpret_cast<BodyInSeries*>(of.bodies);
    Sym2<Number> A;
    for (int j = n_ - 1; j >= 0; --j) {
      beginTurning(of, j, columns * j, omega[j]);
      const SeriesLink& link = links_[j];
      const Rotation<Number> e = numbersOf(of.e[j]);
      const Vec2<Number> P = e * vectorOf(link.p), AiP = A * perp(P);
      const Vec2<Number> U = perp(e * vectorOf(link.mr)) + AiP;
      const Number m = link.m, inverse = Number(1) / (Number(link.J) + dot(perp(P), AiP));
      const Vec2<Number> W = inverse * U;
      bodies_[j].A = A;
      bodies_[j].W = W;
      bodies_[j].inverseD = inverse;
      A = {m + A.xx - U.x * W.x, A.xy - U.x * W.y, m + A.yy - U.y * W.y};
    }
  }
  int bodies() const { return n_; }
  int stride() const { return width_; }
  void know(const double* rows, int k) {
    for (int at = 0; at < width_; at += chunk) findKnown<chunk>(rows + at, width_, k, known_ + at);
  }

  template <bool isFirst>
  void find(const Order& order) {
    const auto productsOf = [&](int j) { return Products<isFirst>(order, width_, columns * j, known_); };

    // As if α_k were 0: accelerations, outwards.
    Vec2<Number> a = isFirst ? ground_ : Vec2<Number>{};
    for (int j = 0; j < n_; ++j) {
      BodyInSeries& body = bodies_[j];
      const auto product = productsOf(j);
      const Rotation<Number> e = numbersOf(order.e[j]);
      const Vec2<Number> mr = vectorOf(links_[j].mr), p = vectorOf(links_[j].p);
      body.z = turning(product, order.omega[j]);
      product.setX(mRa, e * mr);
      product.setX(Pf, e * p);
      body.a = a;
      body.f = mulAdd(Number(links_[j].m), a, second(order, body.z, mr));
      a += second(order, body.z, p);
    }

    // Forces, inwards, and what moment is left over; b of all that it makes move.
    Vec2<Number> f, b;
    for (int j = n_ - 1; j >= 0; --j) {
      BodyInSeries& body = bodies_[j];
      const auto product = productsOf(j);
      const Number own = product.lessCross(order.moment(j), mRa, body.a);
      const Number left = product.lessCross(own, Pf, f);
      const Number u = left - cross(product.firstX(Pf), b);
      const Vec2<Number> inertial = body.f;
      body.v = body.inverseD * u;
      body.f = f;
      body.b = b;
      f += inertial;
      if (order.F) f -= vectorOf(order.F[j]);
      b = mulAdd(u, body.W, b);
    }

    // α_k, outwards, and what it does.
    Vec2<Number> da;
    for (int j = 0; j < n_; ++j) {
      const BodyInSeries& body = bodies_[j];
      const auto product = productsOf(j);
      const Number alpha = body.v - dot(body.W, da);
      product.setCrossY(mRa, body.a + da);
      da = mulAdd(alpha, perp(product.firstX(Pf)), da);
      product.setCrossY(Pf, body.f + body.A * da + body.b);
      goOn(order, width_, columns * j, j, body.z, alpha);
    }
  }

 private:
  static constexpr int columns = SeriesArrays::columns, chunk = SeriesArrays::chunk;
  enum { mRa = 2, Pf = 4 };
  int n_, width_;
  double* known_;
  const SeriesLink* links_;
  BodyInSeries* bodies_;
  Vec2<Number> ground_;
};

// ---- All orders --------------------------------------------------------------------------------------

template <class Shape, bool isFirst>
[[gnu::always_inline]] inline void orderOf(Shape& shape, const SeriesArrays& of, int k,
                                           const Outside& outside, SeriesLoads* loads, double* c) {
  const int n = shape.bodies();
  double* theta = c + k * 2 * n;
  double* omega = theta + n;
  const Order order{k,
                    of.rows,
                    of.rows + 2 * k * shape.stride(),
                    n,
                    outside.N,
                    omega,
                    outside.F,
                    omega + n,
                    of.e,
                    of.e + k * n,
                    of.e + (k + 2) * n,
                    1.0 / (k + 1),
                    1.0 / (k + 2)};
  if constexpr (!isFirst) {
    shape.know(of.rows, k);
    if (loads) loads->findOrder(k, theta, omega);
  }
  shape.template find<isFirst>(order);
}

template <class Shape>
void seriesOf(const SeriesArrays& of, int order, const Outside& outside, SeriesLoads* loads, double* c) {
  Shape shape(of, outside.ground, c + of.n);
  orderOf<Shape, true>(shape, of, 0, outside, loads, c);
  for (int k = 1; k < order; ++k) orderOf<Shape, false>(shape, of, k, outside, loads, c);
}

}  // namespace
}  // namespace planar_chain::simd
