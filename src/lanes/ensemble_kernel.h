#pragma once

/// The Taylor series of several chains, one in each lane, and their steps. See motion_series.h for the
/// equations, ode/taylor.h for the error.

#include <algorithm>
#include <tuple>

#include "lanes/series_links.h"
#include "simd/power_iteration.h"

namespace planar_chain::simd {
namespace {

// ---- One body ----------------------------------------------------------------------------------------

/// J α = N − m R×a
class OneInEachLane {
 public:
  using RealType = Pack;
  OneInEachLane(const SeriesArrays& of, Vec2p ground, const double* omega) : sums_(of.known) {
    const SeriesLink<Pack> link = seriesLinkAt<Pack>(of.links, 0);
    inverseJ_ = Pack(1) / link.J;
    acrossA_ = link.mr.x * ground.y - link.mr.y * ground.x;
    alongA_ = link.mr.x * ground.x + link.mr.y * ground.y;
    beginTurning(of, width, 0, 0, read(omega, 0));
  }
  int bodies() const { return 1; }
  int stride() const { return width; }
  void know(const double* rows, int k) { known_ = knowPairs<2, 2>(rows, width, k, sums_); }

  template <bool isFirst>
  [[gnu::always_inline]] void find(const Order<Pack>& order) {
    const Products<Pack, isFirst> product(order, width, 0, known_);
    const Rotation<Pack> z = turning(product, order.rate(0)), e = rotationAt<Pack>(order.e, 0);
    const Pack torque = order.moment(0) - mulAdd(e.c, acrossA_, -e.s * alongA_);
    goOn(order, width, 0, 0, z, inverseJ_ * torque);
  }

 private:
  static constexpr int width = 2;
  double *sums_, *known_ = nullptr;
  Pack inverseJ_, acrossA_, alongA_;
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
  using RealType = Pack;
  TwoInEachLane(const SeriesArrays& of, Vec2p ground, const double* omega) : rows_(of.rows), sums_(of.known) {
    const auto first = seriesLinkAt<Pack>(of.links, 0), second = seriesLinkAt<Pack>(of.links, 1);
    const Vec2p s[] = {mulAdd(second.m, first.p, first.mr), second.mr};
    const Vec2p p = first.p;
    q_ = {dot(p, s[1]), cross(p, s[1])};
    begin(first_, 0, of, s[0], {q_.x, -q_.y}, ground, read(omega, 0));
    begin(second_, 1, of, s[1], q_, ground, read(omega, 1));
    const Vec2p both = Rotation<Pack>{first_.e.c, -first_.e.s} * (second_.e * q_);
    const Pack kappa = both.x, lambda = both.y, M11 = mulAdd(second.m, dot(p, p), first.J), J2 = second.J;
    const Pack determinant = mulAdd(first.J, J2, mulAdd(second.m * dot(p, p), second.I, lambda * lambda));
    const Pack inverse = Pack(1) / determinant;
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
  [[gnu::always_inline]] void find(const Order<Pack>& order) {
    const Pack b = Pack(order.k + 1) * q_.y;
    const Pack minusA = Pack(-order.k - 1) * q_.x, minusB = Pack(-order.k - 1) * q_.y;
    const Vec2p w1 = turning<isFirst>(first_, 0), w2 = turning<isFirst>(second_, 1);

    // The conjugates of v, as if α_k were 0.
    Vec2p v1{mulAdd(minusA, w1.y, b * w1.x), mulAdd(minusA, w1.x, minusB * w1.y)};
    Vec2p v2{mulAdd(minusA, w2.y, minusB * w2.x), mulAdd(minusA, w2.x, b * w2.y)};
    const Pack left1 = leftOf<isFirst>(first_, 0, order, v2), left2 = leftOf<isFirst>(second_, 1, order, v1);
    const Pack alpha1 = mulAdd(first_.inverse, left1, minusInverseKappa_ * left2);
    const Pack alpha2 = mulAdd(second_.inverse, left2, minusInverseKappa_ * left1);
    v1 = mulAdd(alpha1, first_.eq, v1);
    v2 = mulAdd(alpha2, second_.eq, v2);

    step(first_, 0, order, w1, alpha1);
    step(second_, 1, order, w2, alpha2);
    storePair(at(order.k, vs), 0, Vec2p{v2.y, v2.x});
    storePair(at(order.k, vs + 2), 0, Vec2p{v1.y, v1.x});
    if constexpr (isFirst) {
      first_.pull = {first_.along.x + v2.y, first_.along.y + v2.x};
      second_.pull = {second_.along.x + v1.y, second_.along.y + v1.x};
    }
  }

 private:
  struct Body {
    Rotation<Pack> e;     ///< of order 0
    Pack minusC;          ///< −cos θ
    Vec2p eq;             ///< e_2 q or e_1 q̄
    Vec2p along, pull;    ///< factors of e_0 and g_k in the moment
    Pack omega0, omega;   ///< orders 0 and k
    Vec2p g1, before, g;  ///< orders 1, k and k + 1
    Pack inverse;         ///< of M
  };
  enum Columns { omegas = 0, gs = 2, vs = 6, columns = 2 * SeriesArrays::chunk, sums = 6 };

  void begin(Body& body, int j, const SeriesArrays& of, Vec2p s, Vec2p q, Vec2p ground, Pack omega) {
    body.e = rotationAt<Pack>(of.e, j);
    body.minusC = -body.e.c;
    const Vec2p eq = body.e * q;
    body.eq = {eq.x, -eq.y};
    body.along = {dot(s, ground), cross(s, ground)};
    body.omega0 = body.omega = omega;
    body.g = body.g1 = omega * Vec2p{body.e.c, body.e.s};
    omega.store(at(0, omegas + j));
    storePair(at(1, gs + 2 * j), 0, body.g);
  }

  template <bool isFirst>
  [[gnu::always_inline]] Vec2p turning(const Body& body, int j) const {
    if constexpr (isFirst) return body.omega0 * body.g;
    const Vec2p known = pairAt<Pack>(known_, 2 * j);
    return mulAdd(body.omega0, body.g, mulAdd(body.omega, body.g1, known));
  }

  /// The moment that is left with the other body's v.
  template <bool isFirst>
  [[gnu::always_inline]] Pack leftOf(const Body& body, int j, const Order<Pack>& order, Vec2p v) const {
    Pack own = order.moment(j);
    if constexpr (isFirst) {
      own += mulAdd(body.minusC, body.along.y, body.e.s * body.along.x);
    } else {
      const Vec2p g = body.before;
      own += mulAdd(g.x, body.pull.x, mulAdd(g.y, body.pull.y, read(known_, 4 + j)));
    }
    return mulAdd(body.minusC, v.x, mulAdd(body.e.s, v.y, own));
  }

  /// Order k + 1, and k + 2 of e.
  [[gnu::always_inline]] void step(Body& body, int j, const Order<Pack>& order, Vec2p w, Pack alpha) const {
    const double perNext = order.perNext.whole.v;
    const Pack perOrder(order.perOrder.whole.v), part(perNext), minusPart(-perNext);
    (perOrder * body.omega).store(order.next + j * laneCount);
    body.omega = perOrder * alpha;
    body.omega.store(order.next + (2 + j) * laneCount);
    body.omega.store(at(order.k + 1, omegas + j));
    const Pack turned = part * body.omega;
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
  Vec2p q_;
  Pack minusInverseKappa_;
  Body first_, second_;
};

// ---- Springs and dampers -----------------------------------------------------------------------------

/// Order k of N_j = τ_j − τ_{j+1}, τ_j = torque_j − k_j q_j − d_j q̇_j.
void findTorques(const EnsembleArrays& of, int k, const double* theta, const double* omega) {
  Pack outer;
  for (int j = of.arrays.n - 1; j >= 0; --j) {
    Pack stiffness, damping, torque;
    Reader{of.joints + j * EnsembleArrays::jointQuantities * laneCount}(stiffness, damping, torque);
    Pack q = read(theta, j), qd = read(omega, j);
    if (j > 0) {
      q -= read(theta, j - 1);
      qd -= read(omega, j - 1);
    }
    const Pack tau = mulAdd(-stiffness, q, mulAdd(-damping, qd, k == 0 ? torque : Pack()));
    (tau - outer).store(of.N + j * laneCount);
    outer = tau;
  }
}

// ---- The step ----------------------------------------------------------------------------------------

/// x^y for x > 0, to 6 %, and to 0.4 % near 1: the bits of x, read as a number, are nearly its logarithm.
inline Pack roughPower(Pack x, double y) {
  typedef unsigned long long Bits __attribute__((vector_size(sizeof(Pack))));
  const double scale = 1099511627776, shift = 4503599627370496;  // 2⁴⁰, 2⁵²
  const Bits shiftBits = reinterpret_cast<Bits>(Pack(shift).v);
  constexpr double finite = 1e300;  // beyond, and below 1/finite, the bits are no logarithm
  const Pack inRange = smaller(larger(x, Pack(1 / finite)), Pack(finite));
  const auto read = reinterpret_cast<Pack::Register>((reinterpret_cast<Bits>(inRange.v) >> 12) | shiftBits);
  const Pack log = Pack(1 / scale) * (Pack(read) - Pack(shift)) - Pack(1023);
  const Pack power = smaller(larger(Pack(y) * log, Pack(-1000)), Pack(1000)) + Pack(1023);
  return Pack(
      reinterpret_cast<Pack::Register>(reinterpret_cast<Bits>((Pack(scale) * power + Pack(shift)).v) << 12));
}

/// The tail of the series as Taylor::findError() has it, as a function of h.
class Tail {
 public:
  Tail(const EnsembleArrays& of, const StepControl& control)
      : control_(control), first_(of.order - kept + 1), turning_(Pack::load(of.turning)) {
    const int n = of.arrays.n;
    const Pack one(1), T = smaller(turning_, one);
    for (int i = 0; i < n; ++i) {
      add(of, i, one + smaller(absolute(read(of.c, i)), Pack(control.ceiling)), angles_);
    }
    for (int i = n; i < 2 * n; ++i) {
      const Pack rate = absolute(read(of.c, i));
      add(of, i, smaller(one + rate, mulAdd(T, rate, Pack(control.slowUnits))), rates_);
    }
  }

  /// In units of what is allowed.
  Pack error(Pack h) const {
    Pack power(1), square = h;
    for (int k = first_; k > 0; k /= 2, square = square * square) {
      if (k % 2 == 1) power = power * square;
    }
    const Pack allowed = allowedAt(control_.most, h), allowedRates = allowedAt(control_.mostOfRates, h);
    const Pack T = smaller(larger(Pack(0.5) * h, turning_), Pack(1));
    return larger(sizeAt(h, power, angles_) / allowed, T * sizeAt(h, power, rates_) / allowedRates) +
           isNumber_;
  }

 private:
  static constexpr int kept = std::tuple_size_v<decltype(StepControl::tail)>;

  void add(const EnsembleArrays& of, int i, Pack size, Pack* largest) {
    const int n = of.arrays.n;
    const Pack perSize = Pack(1) / size;
    for (int k = 0; k < kept; ++k) {
      const Pack term = absolute(read(of.c, (first_ + k) * 2 * n + i));
      largest[k] = larger(Pack(control_.tail[static_cast<std::size_t>(k)]) * (term * perSize), largest[k]);
    }
    isNumber_ = mulAdd(Pack(0), read(of.c, of.order * 2 * n + i), isNumber_);
  }
  static Pack sizeAt(Pack h, Pack power, const Pack* sizes) {
    Pack largest;
    for (int k = 0; k < kept - 2; ++k, power = power * h) largest = larger(sizes[k] * power, largest);
    return larger(mulAdd(sizes[kept - 1], h, sizes[kept - 2]) * power, largest);
  }
  Pack allowedAt(double most, Pack h) const {
    return larger(Pack(most) * smaller(larger(h, Pack(control_.shortest)), Pack(1)), Pack(control_.least));
  }

  const StepControl& control_;
  int first_;
  Pack turning_;
  Pack angles_[kept], rates_[kept];
  Pack isNumber_;  ///< 0, or NaN if the last order is not finite: larger() might drop that
};

/// Returns the step after one of h. The error grows as h^(k−1); the kept terms have k = order − 5 … order. A
/// step is taken if its error is between `least` and 1 of what is allowed. With `aimed` between, an inexact
/// power still hits that range, mostly in two rounds. After `most` rounds the search ends.
Pack nextStep(const Tail& tail, int order, Pack h) {
  constexpr double least = 0.5, aimed = 0.7;
  constexpr int most = 60;
  const Pack longest = Pack(10) * h;
  Integers isFound = h.v != h.v, isGood = isFound;
  for (int k = 0; k < most; ++k) {
    const Pack error = tail.error(h);
    isGood = error.v <= Pack(1).v;
    isFound = isFound | (isGood & ((error.v >= Pack(least).v) | (h.v >= longest.v))) | (error.v != error.v);
    if (all(isFound)) break;
    const Pack factor = roughPower(Pack(1 / aimed) * error, -1.0 / (order - 4));
    const Pack next = smaller(longest, h * smaller(larger(factor, Pack(0.1)), Pack(10)));
    h = Pack(isFound ? h.v : next.v);
  }
  return Pack(isFound & isGood ? h.v : Pack().v);
}

template <class Shape>
[[gnu::noinline]] void findOrders(const EnsembleArrays& of) {
  const int n = of.arrays.n;
  for (int j = 0; j < n; ++j) {
    const Rotation<Pack> e = rotationsOf(read(of.c, j));
    storePair<Pack>(of.arrays.e, 2 * j, {e.c, e.s});
  }
  const auto findLoads = [&of](int k, const double* theta, const double* omega) {
    if (of.joints) findTorques(of, k, theta, omega);
  };
  findLoads(0, of.c, of.c + n * laneCount);
  allOrders<Shape>(of.arrays, of.order, {of.joints ? of.N : nullptr, nullptr, of.ground}, findLoads, of.c);
}

/// As power_iteration.h has it for doubles: in each lane, and true if it is in any.
inline Integers areMeasured(Pack eigenvalue) {
  return (eigenvalue.v > Pack().v) & (eigenvalue.v < Pack(1e300).v);
}
inline bool isMeasured(Pack eigenvalue) {
  return !all(!areMeasured(eigenvalue));
}

/// |λ| as LocalStiffness has it. Order 1 is the slope.
template <class Shape>
void findTurning(const EnsembleArrays& of, const StepControl& control, const double* due) {
  EnsembleArrays first = of;
  first.order = 1;
  const int size = 2 * of.arrays.n, numbers = size * laneCount;
  double *y = of.scratch, *base = y + numbers, *direction = base + numbers;
  std::copy_n(of.direction, numbers, direction);
  findOrders<Shape>(first);
  std::copy_n(of.c, 2 * numbers, y);
  const Pack eigenvalue = largestEigenvalue<Pack>({size, y, base, of.c, of.c + numbers, direction},
                                                  [&first] { findOrders<Shape>(first); });
  std::copy_n(y, numbers, of.c);

  const Integers isDue = Pack::load(due).v > Pack().v;
  const Integers isFound = areMeasured(eigenvalue);
  const auto keep = [isDue](Pack next, double* to) { Pack(isDue ? next.v : Pack::load(to).v).store(to); };
  for (int i = 0; i < size; ++i) {
    keep(Pack(isFound ? read(direction, i).v : Pack(1).v), of.direction + i * laneCount);
  }
  const Pack found = Pack(isFound ? eigenvalue.v : Pack().v);
  keep(larger(Pack(1) / found, Pack(control.leastTurning)), of.turning);
}

template <class Shape>
void findSeries(const EnsembleArrays& of, const StepControl& control) {
  findOrders<Shape>(of);
  nextStep(Tail(of, control), of.order, Pack::load(of.h)).store(of.h);
}

/// Σ_{0<k} c_k h^k of components 2i and 2i + 1: one sum does not wait for the other.
inline Vec2p increments(const EnsembleArrays& of, Pack h, int i) {
  const int n = of.arrays.n;
  Vec2p sum = pairAt<Pack>(of.c, 2 * (of.order * n + i));
  for (int k = of.order - 1; k > 0; --k) sum = mulAdd(h, sum, pairAt<Pack>(of.c, 2 * (k * n + i)));
  return h * sum;
}

void evaluateSeries(const EnsembleArrays& of, const double* h, double* y) {
  for (int i = 0; i < of.arrays.n; ++i) {
    const Vec2p whole = increments(of, Pack::load(h), i) + pairAt<Pack>(of.carry, 2 * i);
    storePair(y, 2 * i, pairAt<Pack>(of.c, 2 * i) + whole);
  }
}

/// Σ d q̇². y: scratch.
void findDissipation(const EnsembleArrays& of, const double* h, double* y, double* power) {
  evaluateSeries(of, h, y);
  Pack sum, inner;
  for (int j = 0; j < of.arrays.n; ++j) {
    const Pack damping = read(of.joints + j * EnsembleArrays::jointQuantities * laneCount, 1);
    const Pack rate = read(y, of.arrays.n + j), qd = rate - inner;
    sum = mulAdd(damping * qd, qd, sum);
    inner = rate;
  }
  sum.store(power);
}

/// With Kahan's summation.
void takeStep(const EnsembleArrays& of, const double* h) {
  for (int i = 0; i < of.arrays.n; ++i) {
    const Vec2p old = pairAt<Pack>(of.c, 2 * i);
    const Vec2p whole = increments(of, Pack::load(h), i) + pairAt<Pack>(of.carry, 2 * i);
    const Vec2p next = old + whole;
    storePair(of.carry, 2 * i, whole - (next - old));
    storePair(of.c, 2 * i, next);
  }
}

template <class Shape>
constexpr EnsembleKernel ensembleOf{findTurning<Shape>, findSeries<Shape>, evaluateSeries, findDissipation,
                                    takeStep};

}  // namespace
}  // namespace planar_chain::simd
