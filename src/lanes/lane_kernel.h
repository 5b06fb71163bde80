#pragma once

/// The recursion in segments, for `laneCount` lanes. The compiler options of the including
/// file choose the CPU. See segments.h for the equations.

#include <cstddef>

#include "lanes/join_kernel.h"
#include "lanes/kernel.h"
#include "recursion/articulated.h"
#include "simd/rotation_kernel.h"

namespace planar_chain::simd {
namespace {

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

/// So many quantities of step i.
template <int quantities>
inline double* stepAt(double* first, int i) {
  return first + static_cast<std::ptrdiff_t>(i) * quantities * laneCount;
}

template <bool hasMoments, bool hasForces>
inline SegmentMatrices inwardsOver(const SegmentArrays& arrays, const double* e, const double* omega,
                                   const double* N, const double* F) {
  Sym2<Pack> A, C;
  Vec2p b, c;
  const Vec2p d = outerFrames(arrays.links, e, arrays.steps);
  Vec2p Gx{d.x, -d.y}, Gy{d.y, d.x};  // rows of G
  for (int i = arrays.steps - 1; i >= 0; --i) {
    const BodyPose<Pack> body = bodyPose(linkAt(arrays.links, i), readRotation(e, i), read(omega, i));
    const Vec2p P = body.P;
    Pack moment;
    if constexpr (hasMoments) moment = read(N, i);
    const Factors<Pack> factors = inwards<false>(body, moment, A, b);
    if constexpr (hasForces) {
      b -= readVector(F, i);
    }

    const Vec2p g = mulAdd(P.x, Gy, -P.y * Gx);  // Gᵀ iP
    const Vec2p GP = mulAdd(P.x, Gx, P.y * Gy);  // Gᵀ P
    const Vec2p gD = factors.inverseD * g;
    C = {mulAdd(g.x, gD.x, C.xx), mulAdd(g.x, gD.y, C.xy), mulAdd(g.y, gD.y, C.yy)};
    c = mulAdd(factors.u, gD, mulAdd(-body.ww, GP, c));
    Gx = mulAdd(-factors.U.x, gD, Gx);
    Gy = mulAdd(-factors.U.y, gD, Gy);
    if (i % stepsPerFlush == 0) {
      Gx = mapped(Gx, flush);
      Gy = mapped(Gy, flush);
    }

    const OutwardTerms<Pack> outwardTerms = outwardTermsOf(factors, body);
    Writer{stepAt<SegmentArrays::factorQuantities>(arrays.factors, i)}(outwardTerms.UD, outwardTerms.uD,
                                                                       outwardTerms.ww, P, gD);
  }
  return {d, A, C, b, c, {Gx, Gy}};
}

inline void outwardsOver(const SegmentArrays& arrays, Vec2p a, Vec2p force, double* alpha) {
  for (int i = 0; i < arrays.steps; ++i) {
    OutwardTerms<Pack> outwardTerms;
    Vec2p gD;
    Reader{stepAt<SegmentArrays::factorQuantities>(arrays.factors, i)}(outwardTerms.UD, outwardTerms.uD,
                                                                       outwardTerms.ww, outwardTerms.P, gD);
    outwardTerms.uD -= dot(gD, force);
    outwards(outwardTerms, a).store(stepAt<1>(alpha, i));
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

/// `start` and the vectors of the lanes before each lane, or of those behind.
template <class Real>
[[gnu::always_inline]] inline Vec2<Real> sumOfOthers(Vec2<Real> own, Vec2d start, bool before) {
  constexpr int lanes = doubles<Real>;
  double x[lanes], y[lanes];
  own.x.store(x);
  own.y.store(y);
  for (int k = 0; k < lanes; ++k) {
    const int lane = before ? k : lanes - 1 - k;
    const Vec2d its{x[lane], y[lane]};
    x[lane] = start.x;
    y[lane] = start.y;
    start += its;
  }
  return {Real::load(x), Real::load(y)};
}

PLANAR_CHAIN_IN_ONE_PIECE Vec2d pinsOfSegments(const SegmentArrays& arrays, const double* e,
                                               const double* omega, const double* alpha, Vec2d ground,
                                               double* pins) {
  const auto turning = [&](int i) {
    const Rotation<Pack> turn = readRotation(e, i);
    const Pack rate = read(omega, i), ww = rate * rate, slope = read(alpha, i);
    return Rotation<Pack>{-(ww * turn.c) - slope * turn.s, slope * turn.c - ww * turn.s};
  };
  const auto pinsAt = [pins](int i) { return stepAt<SegmentArrays::pinQuantities>(pins, i); };
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
