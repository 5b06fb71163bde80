#pragma once

/// The Taylor series of several chains, one in each lane, and their steps. See motion_series.h for the
/// equations, ode/taylor.h for the error.

#include "lanes/series_links.h"

namespace planar_chain::simd {
namespace {

// ---- One body ----------------------------------------------------------------------------------------

/// J α = N − m R×a
class OneInEachLane {
 public:
  using Some = Real;
  OneInEachLane(const SeriesArrays& of, Vec2<Real> ground, const double* omega) : sums_(of.known) {
    const SeriesLink<Real> link = seriesLinkAt<Real>(of.links, 0);
    inverseJ_ = Real(1) / link.J;
    acrossA_ = link.mr.x * ground.y - link.mr.y * ground.x;
    alongA_ = link.mr.x * ground.x + link.mr.y * ground.y;
    beginTurning(of, width, 0, 0, read(omega, 0));
  }
  int bodies() const { return 1; }
  int stride() const { return width; }
  void know(const double* rows, int k) { known_ = knowPairs<2, 2>(rows, width, k, sums_); }

  template <bool isFirst>
  [[gnu::always_inline]] void find(const Order<Real>& order) {
    const Products<Real, isFirst> product(order, width, 0, known_);
    const Rotation<Real> z = turning(product, order.rate(0)), e = rotationAt<Real>(order.e, 0);
    const Real torque = order.moment(0) - mulAdd(e.c, acrossA_, -e.s * alongA_);
    goOn(order, width, 0, 0, z, inverseJ_ * torque);
  }

 private:
  static constexpr int width = 2;
  double *sums_, *known_ = nullptr;
  Real inverseJ_, acrossA_, alongA_;
};

// ---- Two bodies --------------------------------------------------------------------------------------

/// The equations of series_two.h, with fewer operations. For each body, with e_m = i g_m for m > 0:
///
///     w_k = Σ_{j≤k} ω_j g_{k+1−j}        g_{k+2} = (i w_k + ω_{k+1} e_0)/(k + 2)
///
/// Let q = p̄_1 s_2. Then ë_2 q = i v_2 and ë_1 q̄ = i v_1, with v_2 = (k+1) i w_2 q + α_2 e_2 q in order k,
/// and
///
///     M_11 α_1 + κ α_2 = N_1 − S_1×a − e_1·v_2          κ + i λ = ē_1 e_2 q
///        κ α_1 + J_2 α_2 = N_2 − S_2×a − e_2·v_1
///
/// In order k, −e·v is g_k.x (−v_0.y) + g_k.y v_0.x − e_0·v_k and the sums of the orders between.
class TwoInEachLane {
 public:
  using Some = Real;
  TwoInEachLane(const SeriesArrays& of, Vec2<Real> ground, const double* omega)
      : rows_(of.rows), sums_(of.known) {
    const auto first = seriesLinkAt<Real>(of.links, 0), second = seriesLinkAt<Real>(of.links, 1);
    const Vector s[] = {mulAdd(second.m, first.p, first.mr), second.mr};
    const Vector p = first.p;
    q_ = {dot(p, s[1]), cross(p, s[1])};
    begin(first_, 0, of, s[0], {q_.x, -q_.y}, ground, read(omega, 0));
    begin(second_, 1, of, s[1], q_, ground, read(omega, 1));
    const Vector both = Rotation<Real>{first_.e.c, -first_.e.s} * (second_.e * q_);
    const Real kappa = both.x, lambda = both.y, M11 = mulAdd(second.m, dot(p, p), first.J), J2 = second.J;
    const Real determinant = mulAdd(first.J, J2, mulAdd(second.m * dot(p, p), second.I, lambda * lambda));
    const Real inverse = Real(1) / determinant;
    first_.inverse = inverse * J2;
    second_.inverse = inverse * M11;
    minusInverseKappa_ = -(inverse * kappa);
  }
  int bodies() const { return 2; }
  int stride() const { return SeriesArrays::chunk; }

  void know(const double*, int k) {
    const int late = k % KnownPair::orders;
    if (late == 0) knowAll<0>(k);
    if (late == 1) knowAll<1>(k);
    if (late == 2) knowAll<2>(k);
    if (late == 3) knowAll<3>(k);
    known_ = sums_ + late * sums * laneCount;
  }

  template <bool isFirst>
  [[gnu::always_inline]] void find(const Order<Real>& order) {
    const Real b = Real(order.k + 1) * q_.y;
    const Real minusA = Real(-order.k - 1) * q_.x, minusB = Real(-order.k - 1) * q_.y;
    const Vector w1 = turning<isFirst>(first_, 0), w2 = turning<isFirst>(second_, 1);

    // The conjugates of v, as if α_k were 0.
    Vector v1{mulAdd(minusA, w1.y, b * w1.x), mulAdd(minusA, w1.x, minusB * w1.y)};
    Vector v2{mulAdd(minusA, w2.y, minusB * w2.x), mulAdd(minusA, w2.x, b * w2.y)};
    const Real left1 = leftOf<isFirst>(first_, 0, order, v2), left2 = leftOf<isFirst>(second_, 1, order, v1);
    const Real alpha1 = mulAdd(first_.inverse, left1, minusInverseKappa_ * left2);
    const Real alpha2 = mulAdd(second_.inverse, left2, minusInverseKappa_ * left1);
    v1 = mulAdd(alpha1, first_.eq, v1);
    v2 = mulAdd(alpha2, second_.eq, v2);

    step(first_, 0, order, w1, alpha1);
    step(second_, 1, order, w2, alpha2);
    storePair(at(order.k, vs), 0, Vector{v2.y, v2.x});
    storePair(at(order.k, vs + 2), 0, Vector{v1.y, v1.x});
    if constexpr (isFirst) {
      first_.pull = {first_.along.x + v2.y, first_.along.y + v2.x};
      second_.pull = {second_.along.x + v1.y, second_.along.y + v1.x};
    }
  }

 private:
  struct Body {
    Rotation<Real> e;      ///< of order 0
    Real minusC;           ///< −cos θ
    Vector eq;             ///< e_2 q or e_1 q̄
    Vector along, pull;    ///< factors of e_0 and g_k in the moment
    Real omega0, omega;    ///< orders 0 and k
    Vector g1, before, g;  ///< orders 1, k and k + 1
    Real inverse;          ///< of M
  };
  enum Columns { omegas = 0, gs = 2, vs = 6, columns = 2 * SeriesArrays::chunk, sums = 6 };

  void begin(Body& body, int j, const SeriesArrays& of, Vector s, Vector q, Vector ground, Real omega) {
    body.e = rotationAt<Real>(of.e, j);
    body.minusC = -body.e.c;
    const Vector eq = body.e * q;
    body.eq = {eq.x, -eq.y};
    body.along = {dot(s, ground), cross(s, ground)};
    body.omega0 = body.omega = omega;
    body.g = body.g1 = omega * Vector{body.e.c, body.e.s};
    omega.store(at(0, omegas + j));
    storePair(at(1, gs + 2 * j), 0, body.g);
  }

  template <bool isFirst>
  [[gnu::always_inline]] Vector turning(const Body& body, int j) const {
    if constexpr (isFirst) return body.omega0 * body.g;
    const Vector known = pairAt<Real>(known_, 2 * j);
    return mulAdd(body.omega0, body.g, mulAdd(body.omega, body.g1, known));
  }

  /// The moment that is left with the other body's v.
  template <bool isFirst>
  [[gnu::always_inline]] Real leftOf(const Body& body, int j, const Order<Real>& order, Vector v) const {
    Real own = order.moment(j);
    if constexpr (isFirst) {
      own += mulAdd(body.minusC, body.along.y, body.e.s * body.along.x);
    } else {
      const Vector g = body.before;
      own += mulAdd(g.x, body.pull.x, mulAdd(g.y, body.pull.y, read(known_, 4 + j)));
    }
    return mulAdd(body.minusC, v.x, mulAdd(body.e.s, v.y, own));
  }

  /// Order k + 1, and k + 2 of e.
  [[gnu::always_inline]] void step(Body& body, int j, const Order<Real>& order, Vector w, Real alpha) const {
    const double perNext = order.perNext.whole.v;
    const Real perOrder(order.perOrder.whole.v), part(perNext), minusPart(-perNext);
    (perOrder * body.omega).store(order.next + j * laneCount);
    body.omega = perOrder * alpha;
    body.omega.store(order.next + (2 + j) * laneCount);
    body.omega.store(at(order.k + 1, omegas + j));
    const Real turned = part * body.omega;
    body.before = body.g;
    body.g = {mulAdd(turned, body.e.c, minusPart * w.y), mulAdd(turned, body.e.s, part * w.x)};
    storePair(at(order.k + 2, gs + 2 * j), 0, body.g);
  }

  /// Column i of an order.
  double* at(int k, int i) const { return rows_ + (k * columns + i) * laneCount; }

  template <int late>
  [[gnu::always_inline]] void knowAll(int k) {
    constexpr int step = columns * laneCount, row = sums * laneCount;
    PLANAR_CHAIN_WRITTEN_OUT
    for (int j = 0; j < 2; ++j) {
      KnownPair(at(0, omegas + j), at(1, gs + 2 * j), step, sums_ + 2 * j * laneCount, row)
          .find<sharing, late>(k);
      KnownPair(at(0, gs + 2 * j), at(0, vs + 2 * j), step, sums_ + (4 + j) * laneCount, row)
          .find<summed, late>(k);
    }
  }

  double *rows_, *sums_, *known_ = nullptr;
  Vector q_;
  Real minusInverseKappa_;
  Body first_, second_;
};

// ---- Springs and dampers -----------------------------------------------------------------------------

/// Order k of N_j = τ_j − τ_{j+1}, τ_j = torque_j − k_j q_j − d_j q̇_j.
void findTorques(const SideBySide& of, int k, const double* theta, const double* omega) {
  Real outer;
  for (int j = of.arrays.n - 1; j >= 0; --j) {
    Real stiffness, damping, torque;
    Reader{of.joints + j * SideBySide::jointQuantities * laneCount}(stiffness, damping, torque);
    Real q = read(theta, j), qd = read(omega, j);
    if (j > 0) {
      q -= read(theta, j - 1);
      qd -= read(omega, j - 1);
    }
    const Real tau = mulAdd(-stiffness, q, mulAdd(-damping, qd, k == 0 ? torque : Real()));
    (tau - outer).store(of.N + j * laneCount);
    outer = tau;
  }
}

// ---- The step ----------------------------------------------------------------------------------------

/// x^y for x > 0, to 6 %, and to 0.4 % near 1: the bits of x, read as a number, are nearly its logarithm.
inline Real roughPower(Real x, double y) {
  typedef unsigned long long Bits __attribute__((vector_size(sizeof(Real))));
  const double scale = 1099511627776, shift = 4503599627370496;  // 2⁴⁰, 2⁵²
  const Bits shiftBits = reinterpret_cast<Bits>(Real(shift).v);
  const Real inRange = smaller(larger(x, Real(1e-300)), Real(1e300));
  const auto read = reinterpret_cast<Real::Register>((reinterpret_cast<Bits>(inRange.v) >> 12) | shiftBits);
  const Real log = Real(1 / scale) * (Real(read) - Real(shift)) - Real(1023);
  const Real power = smaller(larger(Real(y) * log, Real(-1000)), Real(1000)) + Real(1023);
  return Real(
      reinterpret_cast<Real::Register>(reinterpret_cast<Bits>((Real(scale) * power + Real(shift)).v) << 12));
}

/// The tail of the series as Taylor::findError() has it, as a function of h.
class Tail {
 public:
  Tail(const SideBySide& of, const StepControl& control)
      : control_(control), first_(of.order - kept + 1), turning_(Real::load(of.turning)) {
    const int n = of.arrays.n;
    for (int i = 0; i < n; ++i) add(of, i, smaller(absolute(read(of.c, i)), Real(control.ceiling)), angles_);
    for (int i = n; i < 2 * n; ++i) add(of, i, absolute(read(of.c, i)), rates_);
  }

  /// In units of what is allowed.
  Real error(Real h) const {
    Real power(1), square = h;
    for (int k = first_; k > 0; k /= 2, square = square * square) {
      if (k % 2 == 1) power = power * square;
    }
    const Real allowed = allowedAt(control_.most, h), allowedRates = allowedAt(control_.mostOfRates, h);
    const Real T = smaller(larger(Real(0.5) * h, turning_), Real(1));
    return larger(sizeAt(h, power, angles_) / allowed, T * sizeAt(h, power, rates_) / allowedRates) +
           isNumber_;
  }

 private:
  static constexpr int kept = 6;

  void add(const SideBySide& of, int i, Real size, Real* largest) {
    const int n = of.arrays.n;
    const Real perSize = Real(1) / (Real(1) + size);
    double weight = control_.caution / 1024;
    for (int k = 0; k < kept; ++k, weight *= 4) {
      const Real term = absolute(read(of.c, (first_ + k) * 2 * n + i));
      largest[k] = larger(Real(weight) * (term * perSize), largest[k]);
    }
    isNumber_ = mulAdd(Real(0), read(of.c, of.order * 2 * n + i), isNumber_);
  }
  static Real sizeAt(Real h, Real power, const Real* sizes) {
    Real largest;
    for (int k = 0; k < kept - 2; ++k, power = power * h) largest = larger(sizes[k] * power, largest);
    return larger(mulAdd(sizes[kept - 1], h, sizes[kept - 2]) * power, largest);
  }
  Real allowedAt(double most, Real h) const {
    return larger(Real(most) * smaller(larger(h, Real(control_.shortest)), Real(1)), Real(control_.least));
  }

  const StepControl& control_;
  int first_;
  Real turning_;
  Real angles_[kept], rates_[kept];
  Real isNumber_;  ///< 0, or NaN if the last order is not finite: larger() might drop that
};

/// Of a step h before. The error grows as h^(k−1), where the kept terms have k = order − 5 … order.
Real nextStep(const Tail& tail, int order, Real h) {
  constexpr double least = 0.5, aimed = 0.7;
  const Real longest = Real(10) * h;
  Integers isFound = h.v != h.v, isGood = isFound;
  for (int k = 0; k < 60; ++k) {
    const Real error = tail.error(h);
    isGood = error.v <= Real(1).v;
    isFound = isFound | (isGood & ((error.v >= Real(least).v) | (h.v >= longest.v))) | (error.v != error.v);
    if (all(isFound)) break;
    const Real factor = roughPower(Real(1 / aimed) * error, -1.0 / (order - 4));
    const Real next = smaller(longest, h * smaller(larger(factor, Real(0.1)), Real(10)));
    h = Real(isFound ? h.v : next.v);
  }
  return Real(isFound & isGood ? h.v : Real().v);
}

template <class Shape>
[[gnu::noinline]] void findOrders(const SideBySide& of) {
  const int n = of.arrays.n;
  for (int j = 0; j < n; ++j) {
    const Rotation<Real> e = rotationsOf(read(of.c, j));
    storePair<Real>(of.arrays.e, 2 * j, {e.c, e.s});
  }
  const auto findLoads = [&of](int k, const double* theta, const double* omega) {
    if (of.joints) findTorques(of, k, theta, omega);
  };
  findLoads(0, of.c, of.c + n * laneCount);
  allOrders<Shape>(of.arrays, of.order, {of.joints ? of.N : nullptr, nullptr, of.ground}, findLoads, of.c);
}

/// |λ| by power iteration, as LocalStiffness has it. Order 1 is the slope.
template <class Shape>
void findTurning(const SideBySide& of, const StepControl& control, const double* due) {
  SideBySide first = of;
  first.order = 1;
  const int size = 2 * of.arrays.n;
  double *y = of.slopes, *base = y + size * laneCount, *slope = of.c + size * laneCount;
  const Integers isDue = Real::load(due).v > Real().v;
  const auto choose = [&](Real a, Real b) { return Real(isDue ? a.v : b.v); };
  const auto sum = [&](auto term) {
    Real all;
    for (int i = 0; i < size; ++i) all = term(read(of.direction, i), all);
    return all;
  };
  const auto squareOf = [](Real d, Real all) { return mulAdd(d, d, all); };
  const auto sizeOf = [](Real d, Real all) { return larger(absolute(d), all); };

  findOrders<Shape>(first);
  std::copy_n(of.c, 2 * size * laneCount, y);
  Real eigenvalue;
  for (int k = 0; k < 2; ++k) {
    const Real before = sum(squareOf);
    for (int twice = 0; twice < 2; ++twice) {
      const Real step = Real(1e-6) / sum(sizeOf);
      for (int i = 0; i < size; ++i)
        mulAdd(step, read(of.direction, i), read(y, i)).store(of.c + i * laneCount);
      findOrders<Shape>(first);
      for (int i = 0; i < size; ++i) {
        const Real d = read(of.direction, i);
        choose((read(slope, i) - read(base, i)) / step, d).store(of.direction + i * laneCount);
      }
    }
    const Real after = sum(squareOf), length = root(after);
    const Integers isMeasured = (after.v > Real().v) & (after.v < Real(1e300).v);
    eigenvalue = Real(isMeasured ? root(root(after / before)).v : Real().v);
    for (int i = 0; i < size; ++i) {
      const Real d = read(of.direction, i), next(isMeasured ? (d / length).v : Real(1).v);
      choose(next, d).store(of.direction + i * laneCount);
    }
  }
  std::copy_n(y, size * laneCount, of.c);
  choose(larger(Real(1) / eigenvalue, Real(control.leastTurning)), Real::load(of.turning)).store(of.turning);
}

template <class Shape>
void findSeries(const SideBySide& of, const StepControl& control) {
  findOrders<Shape>(of);
  nextStep(Tail(of, control), of.order, Real::load(of.h)).store(of.h);
}

/// Σ_{0<k} c_k h^k of components 2i and 2i + 1: one sum does not wait for the other.
inline Vector increments(const SideBySide& of, Real h, int i) {
  const int n = of.arrays.n;
  Vector sum = pairAt<Real>(of.c, 2 * (of.order * n + i));
  for (int k = of.order - 1; k > 0; --k) sum = mulAdd(h, sum, pairAt<Real>(of.c, 2 * (k * n + i)));
  return h * sum;
}

void evaluateSeries(const SideBySide& of, const double* h, double* y) {
  for (int i = 0; i < of.arrays.n; ++i) {
    const Vector whole = increments(of, Real::load(h), i) + pairAt<Real>(of.carry, 2 * i);
    storePair(y, 2 * i, pairAt<Real>(of.c, 2 * i) + whole);
  }
}

/// Σ d q̇². y: scratch.
void findDissipation(const SideBySide& of, const double* h, double* y, double* power) {
  evaluateSeries(of, h, y);
  Real sum, inner;
  for (int j = 0; j < of.arrays.n; ++j) {
    const Real damping = read(of.joints + j * SideBySide::jointQuantities * laneCount, 1);
    const Real rate = read(y, of.arrays.n + j), qd = rate - inner;
    sum = mulAdd(damping * qd, qd, sum);
    inner = rate;
  }
  sum.store(power);
}

/// With Kahan's summation.
void takeStep(const SideBySide& of, const double* h) {
  for (int i = 0; i < of.arrays.n; ++i) {
    const Vector old = pairAt<Real>(of.c, 2 * i);
    const Vector whole = increments(of, Real::load(h), i) + pairAt<Real>(of.carry, 2 * i);
    const Vector next = old + whole;
    storePair(of.carry, 2 * i, whole - (next - old));
    storePair(of.c, 2 * i, next);
  }
}

template <class Shape>
constexpr SideBySideKernel sideBySideOf{findTurning<Shape>, findSeries<Shape>, evaluateSeries,
                                        findDissipation, takeStep};

}  // namespace
}  // namespace planar_chain::simd
