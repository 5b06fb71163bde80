#pragma once

/// Short chains; see short_chain.h. All that does not depend on the neighbours is computed in lanes, one body
/// a lane. Then the recursion of articulated.h runs link by link. The compiler options of the including file
/// choose the CPU.

#include <algorithm>
#include <utility>

#include "lanes/lane_kernel.h"
#include "simd/number.h"

namespace planar_chain::simd {
namespace {

/// exp(i θ_j) of bodies first, first + 1 …, computed, or read if forces act.
template <Acting acting>
[[gnu::always_inline]] inline Rotation<Real> rotationsFrom(int first, int n, const double* y, double* e) {
  if constexpr (acting != Acting::forces) return rotationsOfSome(y + first, n - first, e + 2 * first);
  const Vector pairs = loadPairs(e + 2 * first);
  return {pairs.x, pairs.y};
}

/// All that does not depend on the neighbours, one body a lane.
template <int fixed>
class BodiesInLanes {
 public:
  template <Acting acting>
  [[gnu::always_inline]] void turn(int n, const double* links, const double* y, double* e) {
    const double* omega = y + n;
    PLANAR_CHAIN_WRITTEN_OUT
    for (int k = 0; k < (n + laneCount - 1) / laneCount; ++k) {
      const int first = k * laneCount;
      const auto own = [=](int q) { return Real::load(links + (k * width + q) * laneCount); };
      const Rotation<Real> turn = rotationsFrom<acting>(first, n, y, e);
      blocks_[k] = turned(Body<Real>{own(0), own(1), {own(2), own(3)}, {own(4), own(5)}}, turn,
                          loadSome(omega + first, n - first));
    }
  }

  [[gnu::always_inline]] Turned<Number> operator[](int j) const {
    const Turned<Real>& block = blocks_[j / laneCount];
    const int s = j % laneCount;
    const auto lane = [s](const Real& value) {
      if constexpr (fixed > 0) return Number(value.v[s]);  // stays in its register
      Number a;
      std::memcpy(&a.v, reinterpret_cast<const char*>(&value.v) + sizeof a.v * static_cast<std::size_t>(s),
                  sizeof a.v);
      return a;
    };
    return {lane(block.m),
            lane(block.J),
            {lane(block.R.x), lane(block.R.y)},
            {lane(block.P.x), lane(block.P.y)},
            lane(block.ww)};
  }

 private:
  static constexpr int width = ShortChains::linkQuantities;
  static constexpr int most = fixed > 0 ? fixed : ShortChains::most;
  Turned<Real> blocks_[(most + laneCount - 1) / laneCount];
};

/// N_j and F_j if they act, else 0.
template <Acting acting>
Number momentOn(const Outside& outside, int j) {
  if constexpr (acting == Acting::nothing) return Number(0);
  return Number(outside.N[j]);
}

template <Acting acting>
Vec2<Number> forceOn(const Outside& outside, int j) {
  if constexpr (acting != Acting::forces) return {};
  return vectorOf(outside.F[j]);
}

/// The recursion for `fixed` links, or for `given` ones if that is 0.
template <int fixed, Acting acting>
void shortChain(int given, const double* links, const Outside& outside, const double* y,
                double* __restrict dydt) {
  const int n = fixed > 0 ? fixed : given;
  constexpr int most = fixed > 0 ? fixed : ShortChains::most;
  BodiesInLanes<fixed> bodies;
  bodies.template turn<acting>(n, links, y, &outside.e->c);

  Sym2<Number> A;
  Vec2<Number> b;
  Reply<Number> replies[most];
  const auto inwardsOver = [&](auto isTip, int j) {
    const Turned<Number> body = bodies[j];
    replies[j] = replyOf(inwards<decltype(isTip)::value>(body, momentOn<acting>(outside, j), A, b), body);
    if constexpr (acting == Acting::forces) b -= forceOn<acting>(outside, j);
  };
  inwardsOver(std::true_type{}, n - 1);
  PLANAR_CHAIN_WRITTEN_OUT
  for (int j = n - 2; j >= 0; --j) inwardsOver(std::false_type{}, j);

  Vec2<Number> a = vectorOf(outside.ground);
  PLANAR_CHAIN_WRITTEN_OUT
  for (int j = 0; j < n; ++j) {
    dydt[j] = y[n + j];
    dydt[n + j] = outwards(replies[j], a).v;
  }
}

/// Two bodies in closed form: M α = f in absolute angles (formulation.md, written out). With the first
/// moments S_1 = m_1 R_1 + m_2 P_1 and S_2 = m_2 R_2, κ = P_1·S_2 and λ = P_1×S_2
///
///     M_11 α_1 + κ α_2 = N_1 + P_1×F_2 − S_1×a + ω_2² λ            M_11 = J_1 + m_2 |p_1|²
///        κ α_1 + J_2 α_2 = N_2 − S_2×a − ω_1² λ
///
/// and det M = J_1 J_2 + m_2 |p_1|² I_2 + λ², where nothing cancels. Constants: see twoInLanes().
template <Acting acting>
void twoBodies(int /*n*/, const double* links, const Outside& outside, const double* y,
               double* __restrict dydt) {
  const Rotation<Real> turn = rotationsFrom<acting>(0, 2, y, &outside.e->c);
  const auto own = [links](int q) { return Real::load(links + q * laneCount); };
  const Vector moments = turn * Vector{own(2), own(3)};
  const Vector pins = turn * Vector{own(4), own(5)};
  const auto vector = [](const Vector& of, int j) {
    return Vec2<Number>{Number(of.x.v[j]), Number(of.y.v[j])};
  };
  const Vec2<Number> S1 = vector(moments, 0), S2 = vector(moments, 1), P1 = vector(pins, 0);
  const Number M11(links[0]), J2(links[1]), constant(links[laneCount]);
  const Number omega1(y[2]), omega2(y[3]);
  const Vec2<Number> a = vectorOf(outside.ground);

  const Number kappa = dot(P1, S2);
  const Number lambda = cross(P1, S2);
  Number f1 = mulAdd(omega2 * omega2, lambda, momentOn<acting>(outside, 0) - cross(S1, a));
  if constexpr (acting == Acting::forces) f1 += cross(P1, forceOn<acting>(outside, 1));
  const Number f2 = mulAdd(-(omega1 * omega1), lambda, momentOn<acting>(outside, 1) - cross(S2, a));
  const Number inverse = Number(1) / mulAdd(lambda, lambda, constant);
  dydt[0] = y[2];
  dydt[1] = y[3];
  dydt[2] = (mulAdd(J2, f1, -kappa * f2) * inverse).v;
  dydt[3] = (mulAdd(M11, f2, -kappa * f1) * inverse).v;
}

#ifdef PLANAR_CHAIN_SANITIZE
constexpr int longestWrittenOut = 3;  // see lanes.h
#else
constexpr int longestWrittenOut = ShortChains::mostUnrolled;
#endif

/// The function for so many links: one for each number up to longestWrittenOut, one for all others.
template <Acting acting, int... n>
constexpr ShortChains::Run shortChainOf(int links, std::integer_sequence<int, n...>) {
  constexpr ShortChains::Run fixed[] = {shortChain<n + 3, acting>..., shortChain<0, acting>};
  if (links == 1) return shortChain<1, acting>;
  if (links == 2) return twoBodies<acting>;
  return fixed[std::min(links - 3, static_cast<int>(sizeof...(n)))];
}

template <Acting acting>
constexpr ShortChains::Run shortChainOf(int links) {
  return shortChainOf<acting>(links, std::make_integer_sequence<int, longestWrittenOut - 2>());
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
