#pragma once

/// Sines, cosines and the recursion in segments, for `laneCount` lanes. The compiler options of the including
/// file choose the CPU. See segments.h for the equations.

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "lanes/join_kernel.h"
#include "lanes/kernel.h"
#include "recursion/articulated.h"
#include "simd/pack.h"

namespace planar_chain::simd {
namespace {

// ---- Sines and cosines -----------------------------------------------------------------------

[[gnu::always_inline]] inline Rotation<Pack> loadRotations(const double* e) {
  const Vec2p pairs = loadPairs(e);
  return {pairs.x, pairs.y};
}

/// exp(i θ) by the machine's library.
[[gnu::cold, gnu::noinline]] void rotate(const double* theta, double* e, int n) {
  for (int j = 0; j < n; ++j) {
    e[2 * j] = std::cos(theta[j]);
    e[2 * j + 1] = std::sin(theta[j]);
  }
}

/// π/2 in parts, such that the first difference θ − k π/2 is exact: by fused multiplication, or as k has 20
/// bits and the first parts 33.
#ifdef PLANAR_CHAIN_FUSES
constexpr double largestReducible = 1e9;
constexpr double halfPi[] = {1.57079632679489655800e+00, 6.12323399573676603587e-17,
                             -1.49738490485916983294e-33};
#else
constexpr double largestReducible = 1.6e6;
constexpr double halfPi[] = {1.57079632673412561417e+00, 6.07710050630396597660e-11,
                             2.02226624879595063154e-21};
#endif

/// θ = k π/2 + r, |r| ≤ π/4, with π/2 in three parts (W. Cody, W. Waite, Software Manual for the Elementary
/// Functions, 1980; the parts are fdlibm's). Then sin r and cos r by the polynomials of Sun's fdlibm
/// (k_sin.c, k_cos.c).
[[gnu::always_inline]] inline Rotation<Pack> rotationsOf(Pack theta) {
  // Adding 1.5·2⁵² rounds to an integer, whose last bits are then k's.
  const Pack shift(6755399441055744.0);
  const Pack shifted = mulAdd(theta, Pack(6.36619772367581382433e-01), shift);
  const Pack k = shifted - shift;
#ifdef PLANAR_CHAIN_FUSES
  Pack r = mulAdd(k, Pack(-halfPi[0]), theta);
  r = mulAdd(k, Pack(-halfPi[1]), r);
  r = mulAdd(k, Pack(-halfPi[2]), r);
#else
  const Pack first = theta - k * Pack(halfPi[0]), second = k * Pack(halfPi[1]), rounded = first - second;
  const Pack r = rounded + (((first - rounded) - second) - k * Pack(halfPi[2]));
#endif

  const Pack z = r * r;
  Pack p = mulAdd(z, Pack(1.58969099521155010221e-10), Pack(-2.50507602534068634195e-08));
  p = mulAdd(z, p, Pack(2.75573137070700676789e-06));
  p = mulAdd(z, p, Pack(-1.98412698298579493134e-04));
  p = mulAdd(z, p, Pack(8.33333333332248946124e-03));
  p = mulAdd(z, p, Pack(-1.66666666666666324348e-01));
  const Pack sine = mulAdd(z * r, p, r);

  Pack q = mulAdd(z, Pack(-1.13596475577881948265e-11), Pack(2.08757232129817482790e-09));
  q = mulAdd(z, q, Pack(-2.75573143513906633035e-07));
  q = mulAdd(z, q, Pack(2.48015872894767294178e-05));
  q = mulAdd(z, q, Pack(-1.38888888888741095749e-03));
  q = mulAdd(z, q, Pack(4.16666666666666019037e-02));
  const Pack half = Pack(0.5) * z;
  const Pack w = Pack(1) - half;
  const Pack cosine = w + mulAdd(z * z, q, (Pack(1) - w) - half);

  // Quadrant k mod 4: odd ones exchange sine and cosine; the signs follow. Casts keep the bits.
  using Register = Pack::Register;
  const auto bits = reinterpret_cast<Integers>(shifted.v);
  const Integers odd = (bits & 1) != 0;
  const Integers sineSign = (bits & 2) << 62;
  const Integers cosineSign = ((bits + 1) & 2) << 62;
  const Register s = odd ? cosine.v : sine.v;
  const Register c = odd ? sine.v : cosine.v;
  return {Pack(reinterpret_cast<Register>(reinterpret_cast<Integers>(c) ^ cosineSign)),
          Pack(reinterpret_cast<Register>(reinterpret_cast<Integers>(s) ^ sineSign))};
}

/// The library computes angles for which k π/2 is not exact enough, and those that are not finite.
bool areReducible(Pack theta) {
  return all((theta.v < Pack(largestReducible).v) & (theta.v > Pack(-largestReducible).v));
}

/// Computes each by itself, so that no angle changes the result for another.
[[gnu::cold, gnu::noinline]] void rotateIrreducible(const double* theta, double* e, int count) {
  for (int j = 0; j < count; ++j) {
    if (!(std::abs(theta[j]) < largestReducible)) rotate(theta + j, e + 2 * j, 1);
  }
}

/// exp(i θ) of `count` angles, in lanes and in e, which has room for laneCount of them.
[[gnu::always_inline]] inline Rotation<Pack> rotationsOfSome(const double* theta, int count, double* e) {
  const Pack angles = loadSome(theta, count);
  Rotation<Pack> turns = rotationsOf(angles);
  storePairs(e, {turns.c, turns.s});
  if (__builtin_expect(!areReducible(angles), false)) {
    rotateIrreducible(theta, e, count < laneCount ? count : laneCount);
    turns = loadRotations(e);
  }
  return turns;
}

void rotations(const double* theta, double* e, int n) {
  int j = 0;
  for (; j + laneCount <= n; j += laneCount) rotationsOfSome(theta + j, laneCount, e + 2 * j);
  if (j == n) return;
  double last[2 * laneCount];
  rotationsOfSome(theta + j, n - j, last);
  std::copy(last, last + 2 * (n - j), e + 2 * j);
}

// ---- Segments --------------------------------------------------------------------------------

/// A number of each body of step i.
template <class Real = Pack>
[[gnu::always_inline]] inline Real read(const double* values, int i) {
  return Real::load(values + static_cast<std::ptrdiff_t>(i) * doubles<Real>);
}

/// A pair of each body of step i.
template <class Real = Pack>
[[gnu::always_inline]] inline Vec2<Real> readVector(const double* pairs, int i) {
  const double* from = pairs + 2 * static_cast<std::ptrdiff_t>(i) * doubles<Real>;
  if constexpr (doubles<Real> == 1)
    return {from[0], from[1]};
  else
    return loadPairs(from);
}

template <class Real = Pack>
[[gnu::always_inline]] inline Rotation<Real> readRotation(const double* e, int i) {
  const Vec2<Real> pairs = readVector<Real>(e, i);
  return {pairs.x, pairs.y};
}

/// The links of step i. Each step has so many quantities in a row.
template <class Real = Pack>
[[gnu::always_inline]] inline Body<Real> linkAt(const double* links, int i) {
  Body<Real> link;
  Reader{links + static_cast<std::ptrdiff_t>(i) * doubles<Body<Real>>}(link.m, link.I, link.r, link.p);
  return link;
}

/// P/|P|, or the first axis if P = 0.
Vec2p unit(Vec2p P) {
  const Pack length = root(mulAdd(P.x, P.x, P.y * P.y));
  const Integers has = length.v > 0;
  return {Pack(has ? (P.x / length).v : Pack(1).v), Pack(has ? (P.y / length).v : Pack().v)};
}

/// The directions of the segments' last links.
Vec2p outerFrames(const double* links, const double* e, int steps) {
  return unit(readRotation(e, steps - 1) * linkAt(links, steps - 1).p);
}

inline double* handlesAt(const SegmentArrays& arrays, int i) {
  return arrays.handles + static_cast<std::ptrdiff_t>(i) * SegmentArrays::handleQuantities * laneCount;
}

template <bool hasMoments, bool hasForces>
inline Handles inwardsOver(const SegmentArrays& arrays, const double* e, const double* omega, const double* N,
                           const double* F) {
  Sym2<Pack> A, C;
  Vec2p b, c;
  const Vec2p d = outerFrames(arrays.links, e, arrays.steps);
  Vec2p Gx{d.x, -d.y}, Gy{d.y, d.x};  // rows of G
  for (int i = arrays.steps - 1; i >= 0; --i) {
    const Turned<Pack> body = turned(linkAt(arrays.links, i), readRotation(e, i), read(omega, i));
    const Vec2p P = body.P;
    Pack moment;
    if constexpr (hasMoments) moment = read(N, i);
    const Handle<Pack> handle = inwards<false>(body, moment, A, b);
    if constexpr (hasForces) {
      b -= readVector(F, i);
    }

    const Vec2p g = mulAdd(P.x, Gy, -P.y * Gx);  // Gᵀ iP
    const Vec2p GP = mulAdd(P.x, Gx, P.y * Gy);  // Gᵀ P
    const Vec2p gD = handle.inverseD * g;
    C = {mulAdd(g.x, gD.x, C.xx), mulAdd(g.x, gD.y, C.xy), mulAdd(g.y, gD.y, C.yy)};
    c = mulAdd(handle.u, gD, mulAdd(-body.ww, GP, c));
    Gx = mulAdd(-handle.U.x, gD, Gx);
    Gy = mulAdd(-handle.U.y, gD, Gy);
    if (i % stepsPerFlush == 0) {
      Gx = mapped(Gx, flush);
      Gy = mapped(Gy, flush);
    }

    const Reply<Pack> reply = replyOf(handle, body);
    Writer{handlesAt(arrays, i)}(reply.UD, reply.uD, reply.ww, P, gD);
  }
  return {d, A, C, b, c, {Gx, Gy}};
}

inline void outwardsOver(const SegmentArrays& arrays, Vec2p a, Vec2p force, double* alpha) {
  for (int i = 0; i < arrays.steps; ++i) {
    Reply<Pack> reply;
    Vec2p gD;
    Reader{handlesAt(arrays, i)}(reply.UD, reply.uD, reply.ww, reply.P, gD);
    reply.uD -= dot(gD, force);
    outwards(reply, a).store(alpha + static_cast<std::ptrdiff_t>(i) * laneCount);
  }
}

template <bool hasMoments, bool hasForces>
PLANAR_CHAIN_IN_ONE_PIECE void runSegments(const SegmentArrays& arrays, const double* e, const double* omega,
                                           const double* N, const double* F, Vec2d ground, double* alpha) {
  const JoinedPair<1> joined(inwardsOver<hasMoments, hasForces>(arrays, e, omega, N, F));
  Vec2p a{Pack(ground.x), Pack(ground.y)}, force;
  joined.passOutwards(a, force);
  outwardsOver(arrays, a, force, alpha);
}

void segmentsAll(const SegmentArrays& arrays, const double* e, const double* omega, const double* N,
                 const double* F, Vec2d ground, double* alpha) {
  const auto run = F ? runSegments<true, true> : N ? runSegments<true, false> : runSegments<false, false>;
  run(arrays, e, omega, N, F, ground, alpha);
}

/// Adds to the vectors of each lane the sum of those of the lanes before, or behind.
[[gnu::always_inline]] inline Vec2p sumOfOthers(Vec2p own, Vec2d start, bool before) {
  Vec2p others;
  for (int k = 0; k < laneCount; ++k) {
    const int lane = before ? k : laneCount - 1 - k;
    others.x.v[lane] = start.x;
    others.y.v[lane] = start.y;
    start += Vec2d{own.x.v[lane], own.y.v[lane]};
  }
  return others;
}

PLANAR_CHAIN_IN_ONE_PIECE Vec2d pinsOfSegments(const SegmentArrays& arrays, const double* e,
                                               const double* omega, const double* alpha, Vec2d ground,
                                               double* pins) {
  const auto turning = [&](int i) {
    const Rotation<Pack> turn = readRotation(e, i);
    const Pack rate = read(omega, i), ww = rate * rate, slope = read(alpha, i);
    return Rotation<Pack>{-(ww * turn.c) - slope * turn.s, slope * turn.c - ww * turn.s};
  };
  const auto pinsAt = [&](int i) {
    return pins + static_cast<std::ptrdiff_t>(i) * SegmentArrays::pinQuantities * laneCount;
  };
  Vec2p a, force;
  for (int i = 0; i < arrays.steps; ++i) {
    Writer{pinsAt(i)}(a);
    a += turning(i) * linkAt(arrays.links, i).p;
  }
  const Vec2p start = sumOfOthers(a, ground, true);
  for (int i = arrays.steps - 1; i >= 0; --i) {
    const Body<Pack> link = linkAt(arrays.links, i);
    Reader{pinsAt(i)}(a);
    a += start;
    Writer{pinsAt(i)}(a, force);
    force += link.m * (a + turning(i) * link.r);
  }
  const Vec2p outer = sumOfOthers(force, {}, false), all = force + outer;
  for (int i = 0; i < arrays.steps; ++i) {
    Reader{pinsAt(i)}(a, force);
    force += outer;
    Writer{pinsAt(i)}(a, force);
  }
  return {all.x.v[0], all.y.v[0]};
}

}  // namespace
}  // namespace planar_chain::simd
