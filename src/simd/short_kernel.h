#pragma once

/// Short chains, for the CPU that the including file's compiler options name: what does not depend on the
/// neighbours in lanes, one body a lane, and then the recursion of articulated.h in a row, written out
/// without loops for up to eight links. What the template's arguments do not name is not computed.

#include "lane_kernel.h"

namespace planar_chain::simd {
namespace {

/// A double whose functions are compiled for this CPU alone; see lanes.h.
struct Number {
  double v = 0;

  Number() = default;
  explicit Number(double x) : v(x) {}

  friend Number operator+(Number a, Number b) { return Number(a.v + b.v); }
  friend Number operator-(Number a, Number b) { return Number(a.v - b.v); }
  friend Number operator*(Number a, Number b) { return Number(a.v * b.v); }
  friend Number operator/(Number a, Number b) { return Number(a.v / b.v); }
  friend Number operator-(Number a) { return Number(-a.v); }
  Number& operator+=(Number b) { return *this = *this + b; }
  Number& operator-=(Number b) { return *this = *this - b; }
};

#ifdef __FMA__
Number mulAdd(Number a, Number b, Number c) {
  return Number(__builtin_fma(a.v, b.v, c.v));
}
#endif

/// The first numbers of a register, so many as there are; the others are 0.
[[gnu::always_inline]] inline Real loadSome(const double* from, int count) {
  if (count >= laneCount) return Real::load(from);
  Real a;
  for (int s = 0; s < laneCount; ++s) {
    if (s < count) a.v[s] = from[s];
  }
  return a;
}

/// exp(i θ) of so many angles, in lanes and to e, which has room for laneCount of them.
[[gnu::always_inline]] inline Pairs rotationsOfSome(const double* theta, int count, double* e) {
#ifdef __FMA__
  const Real angles = loadSome(theta, count);
  if (isReducible(angles)) {
    const Pairs turns = rotationsOf(angles);
    storePairs(e, turns);
    return turns;
  }
#endif
  rotate(theta, e, count < laneCount ? count : laneCount);
  return gatherPairs(e, 2);
}

/// One body a lane: what the recursion reads.
struct BodiesInLanes {
  double J[laneCount], Rx[laneCount], Ry[laneCount], Px[laneCount], Py[laneCount], ww[laneCount];
};

template <int fixed, Acting acting>
void shortChain(int given, const double* links, const double* y, double* __restrict e, const double* N,
                const double* F, const double* ground, double* __restrict dydt) {
  const int n = fixed > 0 ? fixed : given;
  constexpr int most = fixed > 0 ? fixed : ShortChains::most;
  constexpr int mostBlocks = (most + laneCount - 1) / laneCount;
  const int blocks = (n + laneCount - 1) / laneCount;
  const double* omega = y + n;

  BodiesInLanes bodies[mostBlocks];
#pragma GCC unroll 4
  for (int k = 0; k < blocks; ++k) {
    const int first = k * laneCount;
    const double* own = links + first * ShortChains::linkQuantities;
    const auto link = [own](int q) { return Real::load(own + q * laneCount); };
    const Pairs turn = acting == Acting::forces ? gatherPairs(e + 2 * first, 2)
                                                : rotationsOfSome(y + first, n - first, e + 2 * first);
    const Turned<Real> body = turned(Body<Real>{link(0), link(1), {link(2), link(3)}, {link(4), link(5)}},
                                     Rotation<Real>{turn.x, turn.y}, loadSome(omega + first, n - first));
    BodiesInLanes& to = bodies[k];
    body.J.store(to.J), body.ww.store(to.ww);
    body.R.x.store(to.Rx), body.R.y.store(to.Ry);
    body.P.x.store(to.Px), body.P.y.store(to.Py);
  }
  const auto body = [&](int j) {
    const BodiesInLanes& from = bodies[j / laneCount];
    const int s = j % laneCount;
    const double m = links[j / laneCount * laneCount * ShortChains::linkQuantities + s];
    return Turned<Number>{Number(m),
                          Number(from.J[s]),
                          {Number(from.Rx[s]), Number(from.Ry[s])},
                          {Number(from.Px[s]), Number(from.Py[s])},
                          Number(from.ww[s])};
  };
  const auto moment = [N](int j) {
    if constexpr (acting == Acting::nothing) return Number(0);
    return Number(N[j]);
  };

  Sym2<Number> A;
  Vec2<Number> b;
  Reply<Number> replies[most];
  const auto inwardsOver = [&](auto isTip, int j) {
    const Turned<Number> here = body(j);
    replies[j] = replyOf(inwards<decltype(isTip)::value>(here, moment(j), A, b), here);
    if constexpr (acting == Acting::forces) b -= Vec2<Number>{Number(F[2 * j]), Number(F[2 * j + 1])};
  };
  inwardsOver(std::true_type{}, n - 1);
#pragma GCC unroll 8
  for (int j = n - 2; j >= 0; --j) inwardsOver(std::false_type{}, j);

  Vec2<Number> a{Number(ground[0]), Number(ground[1])};
#pragma GCC unroll 8
  for (int j = 0; j < n; ++j) {
    dydt[j] = omega[j];
    dydt[n + j] = outwards(replies[j], a).v;
  }
}

template <Acting acting>
constexpr ShortChains::Run shortChainOf(int n) {
  constexpr ShortChains::Run fixed[] = {shortChain<1, acting>, shortChain<2, acting>, shortChain<3, acting>,
                                        shortChain<4, acting>, shortChain<5, acting>, shortChain<6, acting>,
                                        shortChain<7, acting>, shortChain<8, acting>};
  return n <= 8 ? fixed[n - 1] : shortChain<0, acting>;
}

ShortChains::Run shortChainFor(int n, Acting acting) {
  switch (acting) {
    case Acting::nothing:
      return shortChainOf<Acting::nothing>(n);
    case Acting::moments:
      return shortChainOf<Acting::moments>(n);
    default:
      return shortChainOf<Acting::forces>(n);
  }
}

}  // namespace
}  // namespace planar_chain::simd
