#pragma once

/// The Taylor series of any number of bodies; see motion_series.h for the equations.

#include <cmath>

#include "lanes/series_kernel.h"
#include "lanes/series_known.h"
#include "lanes/series_one.h"
#include "lanes/series_two.h"

namespace planar_chain::simd {
namespace {

/// A body at the order in hand.
template <class Real>
struct BodyInSeries {
  // Order 0: U/D, 1/D, and the articulated mass at the outer pin.
  Vec2<Real> W;
  Real inverseD;
  Sym2<Real> A;
  // As if its α were 0: a of the inner pin, f on the next link; then b and u/D; z: see turning().
  Vec2<Real> a, f, b;
  Real v;
  Rotation<Real> z;
};
static_assert(sizeof(BodyInSeries<Lane>) == SeriesArrays::bodyNumbers * sizeof(double));

/// Link by link. Columns of each: how it turns, m R×a, P×f, with a of the inner pin and f on the next link.
///
/// A tip that is held takes the force φ_k that keeps its acceleration at zero, the last part of f. With c_j =
/// u_j for φ_0 = 1 along each axis, the tip accelerates by −Σ c_j u_j/D_j, so φ_k = G⁻¹ (a° − Σ c_j u_j/D_j),
/// where G = Σ c_j c_jᵀ/D_j and a° is its acceleration as if α_k were 0. Near a stretched pose, the rounding
/// of the state decides the coefficients, which do not show it: there is no series.
template <class Real, bool holdsTip = false>
class Links {
 public:
  using RealType = Real;
  /// The articulated masses at order 0.
  Links(const SeriesArrays& of, Vec2<Real> ground, const double* omega)
      : n_(of.n), width_(of.width), sums_(of.known), known_(of.known), links_(of.links), ground_(ground) {
    bodies_ = reinterpret_cast<BodyInSeries<Real>*>(of.bodies);
    tip_ = reinterpret_cast<UnderTip*>(of.tip);
    Sym2<Real> A, G;
    Vec2<Real> bx, by;
    for (int j = n_ - 1; j >= 0; --j) {
      beginTurning(of, width_, j, columns * j, read<Real>(omega, j));
      const SeriesLink<Real> link = seriesLinkAt<Real>(links_, j);
      const Rotation<Real> e = rotationAt<Real>(of.e, j);
      const Vec2<Real> P = e * link.p, AiP = A * perp(P);
      const Vec2<Real> U = perp(e * link.mr) + AiP;
      const Real m = link.m, inverse = Real(1) / (link.J + dot(perp(P), AiP));
      const Vec2<Real> W = inverse * U;
      bodies_[j].A = A;
      bodies_[j].W = W;
      bodies_[j].inverseD = inverse;
      if constexpr (holdsTip) {
        const Vec2<Real> u{-cross(P, Vec2<Real>{Real(1), Real(0)} + bx),
                           -cross(P, Vec2<Real>{Real(0), Real(1)} + by)};
        tip_[j] = {u, bx, by};
        bx = mulAdd(u.x, W, bx);
        by = mulAdd(u.y, W, by);
        const Vec2<Real> perD = inverse * u;
        G = {mulAdd(perD.x, u.x, G.xx), mulAdd(perD.x, u.y, G.xy), mulAdd(perD.y, u.y, G.yy)};
      }
      A = {m + A.xx - U.x * W.x, A.xy - U.x * W.y, m + A.yy - U.y * W.y};
    }
    if constexpr (holdsTip) {
      const double det = (G.xx * G.yy - G.xy * G.xy).v, sum = (G.xx + G.yy).v;
      const Real inverse = det > leastMargin * sum * sum ? 1 / det : NAN;
      inverseG_ = {inverse * G.yy, -inverse * G.xy, inverse * G.xx};
    }
  }
  int bodies() const { return n_; }
  int stride() const { return width_; }
  void know(const double* rows, int k) {
    if constexpr (doubles<Real> == 1) {
      constexpr int chunk = SeriesArrays::chunk;
      for (int at = 0; at < width_; at += chunk) {
        findKnown<chunk / laneCount>(rows + at, width_, k, known_ + at);
      }
    } else {
      known_ = knowPairs<columns, 2>(rows, width_, k, sums_);
    }
  }

  template <bool isFirst>
  void find(const Order<Real>& order) {
    const auto productsOf = [&](int j) {
      return Products<Real, isFirst>(order, width_, columns * j, known_);
    };

    // As if α_k were 0: accelerations, outwards.
    Vec2<Real> a = isFirst ? ground_ : Vec2<Real>{};
    for (int j = 0; j < n_; ++j) {
      BodyInSeries<Real>& body = bodies_[j];
      const auto product = productsOf(j);
      const Rotation<Real> e = rotationAt<Real>(order.e, j);
      const SeriesLink<Real> link = seriesLinkAt<Real>(links_, j);
      body.z = turning(product, order.rate(j));
      product.setX(mRa, e * link.mr);
      product.setX(Pf, e * link.p);
      body.a = a;
      body.f = mulAdd(link.m, a, second(order, body.z, link.mr));
      a += second(order, body.z, link.p);
    }

    if (isFirst) a -= ground_;

    // Forces, inwards, and what moment is left over; b of all that it makes move.
    Vec2<Real> f, b;
    for (int j = n_ - 1; j >= 0; --j) {
      BodyInSeries<Real>& body = bodies_[j];
      const auto product = productsOf(j);
      const Real own = product.lessCross(order.moment(j), mRa, body.a);
      const Real left = product.lessCross(own, Pf, f);
      const Real u = left - cross(product.firstX(Pf), b);
      const Vec2<Real> inertial = body.f;
      body.v = body.inverseD * u;
      if constexpr (holdsTip) a -= body.v * tip_[j].u;
      body.f = f;
      body.b = b;
      f += inertial;
      if (order.F) f -= pairAt<Real>(order.F, 2 * j);
      b = mulAdd(u, body.W, b);
    }

    // α_k, outwards, and what it does.
    [[maybe_unused]] const Vec2<Real> held = holdsTip ? inverseG_ * a : Vec2<Real>{};
    Vec2<Real> da;
    for (int j = 0; j < n_; ++j) {
      BodyInSeries<Real>& body = bodies_[j];
      if constexpr (holdsTip) {
        body.v = mulAdd(body.inverseD, dot(tip_[j].u, held), body.v);
        body.f += held;
        body.b += held.x * tip_[j].bx + held.y * tip_[j].by;
      }
      const auto product = productsOf(j);
      const Real alpha = body.v - dot(body.W, da);
      product.setCrossY(mRa, body.a + da);
      da = mulAdd(alpha, perp(product.firstX(Pf)), da);
      product.setCrossY(Pf, body.f + body.A * da + body.b);
      goOn(order, width_, columns * j, j, body.z, alpha);
    }
  }

 private:
  /// The least ratio of the eigenvalues of G. At 0, a parallelogram leaves its branch at a change point.
  static constexpr double leastMargin = 1e-6;
  static constexpr int columns = SeriesArrays::columns;
  enum { mRa = 2, Pf = 4 };
  /// u and b for φ = 1 along each axis
  struct UnderTip {
    Vec2<Real> u, bx, by;
  };
  static_assert(sizeof(UnderTip) == SeriesArrays::tipNumbers * sizeof(Real));
  int n_, width_;
  double *sums_, *known_;
  const double* links_;
  BodyInSeries<Real>* bodies_;
  UnderTip* tip_;  ///< of a held one
  Sym2<Real> inverseG_;
  Vec2<Real> ground_;
};

// ---- All orders --------------------------------------------------------------------------------------

/// Order 0 of what acts, as in Order; and the acceleration of the ground pin less gravity.
struct ActingInSeries {
  const double *N, *F, *ground;
};

template <bool isFirst, class Shape, class FindLoads>
[[gnu::always_inline]] inline void orderOf(Shape& shape, const SeriesArrays& of, int k,
                                           const ActingInSeries& acting, Inverse perOrder, Inverse perNext,
                                           FindLoads findLoads, double* c) {
  constexpr int d = doubles<typename Shape::RealType>;
  const int n = shape.bodies();
  double* theta = c + k * 2 * n * d;
  double* omega = theta + n * d;
  const Order<typename Shape::RealType> order{k,
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
template <class Shape, class FindLoads>
[[gnu::always_inline]] inline void allOrders(const SeriesArrays& of, int order, const ActingInSeries& acting,
                                             FindLoads findLoads, double* c) {
  using Real = typename Shape::RealType;
  Shape shape(of, pairAt<Real>(acting.ground, 0), c + of.n * doubles<Real>);
  Inverse perOrder(2);
  orderOf<true>(shape, of, 0, acting, Inverse(1), perOrder, findLoads, c);
  for (int k = 1; k < order; ++k) {
    const Inverse perNext(k + 2);
    orderOf<false>(shape, of, k, acting, perOrder, perNext, findLoads, c);
    perOrder = perNext;
  }
}

template <class Shape>
void seriesOf(const SeriesArrays& of, int order, const Loads& external, SeriesLoads* loads, double* c) {
  const ActingInSeries acting{external.N, external.F ? &external.F->x : nullptr, &external.ground.x};
  const auto findLoads = [loads](int k, const double* /*theta*/, const double* /*omega*/) {
    if (loads) loads->findOrder(k);
  };
  allOrders<Shape>(of, order, acting, findLoads, c);
}

}  // namespace
}  // namespace planar_chain::simd
