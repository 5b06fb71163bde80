#pragma once

/// The Taylor series of one body and of any number; see motion_series.h for the equations.

#include "lanes/series_kernel.h"
#include "lanes/series_two.h"

namespace planar_chain::simd {
namespace {

/// J α = N − m R×a
class One {
 public:
  static int widthFor(int /*n*/) { return width; }

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
    const Rotation<Number> z = turning(product, Number(order.omega[0])), e = numbersOf(order.e[0]);
    const Number torque = order.moment(0) - mulAdd(e.c, acrossA_, -e.s * alongA_);
    goOn(order, width, 0, 0, z, inverseJ_ * torque);
  }

 private:
  static constexpr int width = 8;
  double* known_;
  Number inverseJ_, acrossA_, alongA_;
};

/// Link by link. Columns of each: how it turns, m R×a, P×f, with a of the inner pin and f on the next link.
class Links {
 public:
  static int widthFor(int n) { return (columns * n + chunk - 1) / chunk * chunk; }

  /// The articulated masses at order 0.
  Links(const SeriesArrays& of, Vec2d ground, const double* omega)
      : n_(of.n), width_(of.width), known_(of.known), links_(of.links), ground_(vectorOf(ground)) {
    Sym2<Number> A;
    for (int j = n_ - 1; j >= 0; --j) {
      beginTurning(of, j, columns * j, omega[j]);
      SeriesLink& link = links_[j];
      const Rotation<Number> e = numbersOf(of.e[j]);
      const Vec2<Number> P = e * vectorOf(link.p), AiP = A * perp(P);
      const Vec2<Number> U = perp(e * vectorOf(link.mr)) + AiP;
      const Number inverse = Number(1) / (Number(link.J) + dot(perp(P), AiP));
      const Vec2<Number> W = inverse * U;
      link.A = {A.xx.v, A.xy.v, A.yy.v};
      link.W = valueOf(W);
      link.inverseD = inverse.v;
      const Number m(link.m);
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
      SeriesLink& link = links_[j];
      const auto product = productsOf(j);
      const Rotation<Number> e = numbersOf(order.e[j]), z = turning(product, Number(order.omega[j]));
      const Vec2<Number> mr = vectorOf(link.mr), p = vectorOf(link.p);
      product.setCrossX(mRa, e * mr);
      product.setCrossX(Pf, e * p);
      link.z = {z.c.v, z.s.v};
      link.a = valueOf(a);
      link.f = valueOf(mulAdd(Number(link.m), a, second(order, z, mr)));
      a += second(order, z, p);
    }

    // Forces, inwards, and what moment is left over; b of all that it makes move.
    Vec2<Number> f, b;
    for (int j = n_ - 1; j >= 0; --j) {
      SeriesLink& link = links_[j];
      const auto product = productsOf(j);
      const Number own = product.lessCross(order.moment(j), mRa, vectorOf(link.a));
      const Number left = product.lessCross(own, Pf, f);
      const Number u = left - cross(product.firstCrossX(Pf), b);
      const Vec2<Number> inertial = vectorOf(link.f);
      link.v = (Number(link.inverseD) * u).v;
      link.f = valueOf(f);
      link.b = valueOf(b);
      f += inertial;
      if (order.F) f -= vectorOf(order.F[j]);
      b = mulAdd(u, vectorOf(link.W), b);
    }

    // α_k, outwards, and what it does.
    Vec2<Number> da;
    for (int j = 0; j < n_; ++j) {
      const SeriesLink& link = links_[j];
      const auto product = productsOf(j);
      const Number alpha = Number(link.v) - dot(vectorOf(link.W), da);
      product.setCrossY(mRa, vectorOf(link.a) + da);
      da = mulAdd(alpha, perp(product.firstCrossX(Pf)), da);
      product.setCrossY(Pf, vectorOf(link.f) + numbersOf(link.A) * da + vectorOf(link.b));
      goOn(order, width_, columns * j, j, numbersOf(link.z), alpha);
    }
  }

 private:
  static constexpr int chunk = 8;
  enum { mRa = 2, Pf = 4, columns = 6 };
  int n_, width_;
  double* known_;
  SeriesLink* links_;
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

template <class Shape>
constexpr SeriesShape shapeOf() {
  return {seriesOf<Shape>, Shape::widthFor};
}

constexpr SeriesShape seriesShapes[] = {shapeOf<One>(), shapeOf<Two>(), shapeOf<Links>()};

}  // namespace
}  // namespace planar_chain::simd
