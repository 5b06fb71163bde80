#pragma once

/// Short chains; see short_chain.h. All that does not depend on the neighbours is computed in lanes, one body
/// a lane. Then the recursion of articulated.h runs link by link. The compiler options of the including file
/// choose the CPU.

#include <utility>

#include "lanes/lane_kernel.h"

namespace planar_chain::simd {
namespace {

/// exp(i θ_j) of bodies first, first + 1 …, computed, or read if forces act.
template <LoadKind acting>
[[gnu::always_inline]] inline Rotation<Pack> rotationsFrom(int first, int n, const double* y, double* e) {
  if constexpr (acting != LoadKind::forces) return rotationsOfSome(y + first, n - first, e + 2 * first);
  return loadRotations(e + 2 * first);
}

/// All that does not depend on the neighbours, one body a lane.
template <int n>
class BodiesInLanes {
 public:
  template <LoadKind acting>
  [[gnu::always_inline]] void turn(const double* links, const double* y, double* e) {
    const double* omega = y + n;
    PLANAR_CHAIN_WRITTEN_OUT
    for (int k = 0; k < blocks; ++k) {
      const int first = k * laneCount;
      blocks_[k] = bodyPose(linkAt(links, k), rotationsFrom<acting>(first, n, y, e),
                            loadSome(omega + first, n - first));
    }
  }

  [[gnu::always_inline]] BodyPose<Lane> operator[](int j) const {
    const BodyPose<Pack>& block = blocks_[j / laneCount];
    const int s = j % laneCount;
    const auto lane = [s](const Pack& value) { return Lane(value.v[s]); };
    return {lane(block.m),
            lane(block.J),
            {lane(block.R.x), lane(block.R.y)},
            {lane(block.P.x), lane(block.P.y)},
            lane(block.ww)};
  }

 private:
  static constexpr int blocks = (n + laneCount - 1) / laneCount;
  BodyPose<Pack> blocks_[blocks];
};

/// N_j and F_j if they act, else 0.
template <LoadKind acting>
Lane momentOn(const Loads& external, int j) {
  if constexpr (acting == LoadKind::nothing) return Lane(0);
  return Lane(external.N[j]);
}

template <LoadKind acting>
Vec2<Lane> forceOn(const Loads& external, int j) {
  if constexpr (acting != LoadKind::forces) return {};
  return vectorOf(external.F[j]);
}

template <int n, LoadKind acting>
void shortChain(const double* links, const Loads& external, const double* y, double* __restrict dydt) {
  BodiesInLanes<n> bodies;
  bodies.template turn<acting>(links, y, &external.e->c);

  Sym2<Lane> A;
  Vec2<Lane> b;
  OutwardTerms<Lane> outwardTerms[n];
  const auto inwardsOver = [&](auto isTip, int j) {
    const BodyPose<Lane> body = bodies[j];
    outwardTerms[j] =
        outwardTermsOf(inwards<decltype(isTip)::value>(body, momentOn<acting>(external, j), A, b), body);
    if constexpr (acting == LoadKind::forces) b -= forceOn<acting>(external, j);
  };
  inwardsOver(std::true_type{}, n - 1);
  PLANAR_CHAIN_WRITTEN_OUT
  for (int j = n - 2; j >= 0; --j) inwardsOver(std::false_type{}, j);

  Vec2<Lane> a = vectorOf(external.ground);
  PLANAR_CHAIN_WRITTEN_OUT
  for (int j = 0; j < n; ++j) {
    dydt[j] = y[n + j];
    dydt[n + j] = outwards(outwardTerms[j], a).v;
  }
}

/// Two bodies in closed form: M α = f in absolute angles (the equations of articulated.h, written out). With
/// the first moments S_1 = m_1 R_1 + m_2 P_1 and S_2 = m_2 R_2, κ = P_1·S_2 and λ = P_1×S_2
///
///     M_11 α_1 + κ α_2 = N_1 + P_1×F_2 − S_1×a + ω_2² λ            M_11 = J_1 + m_2 |p_1|²
///        κ α_1 + J_2 α_2 = N_2 − S_2×a − ω_1² λ
///
/// and det M = J_1 J_2 + m_2 |p_1|² I_2 + λ², where nothing cancels. Constants: see twoInLanes().
template <LoadKind acting>
void twoBodies(const double* links, const Loads& external, const double* y, double* __restrict dydt) {
  const Rotation<Pack> turn = rotationsFrom<acting>(0, 2, y, &external.e->c);
  Vec2p moments, pins;
  Reader{links + 2 * laneCount}(moments, pins);
  moments = turn * moments;
  pins = turn * pins;
  const auto vector = [](const Vec2p& of, int j) { return Vec2<Lane>{Lane(of.x.v[j]), Lane(of.y.v[j])}; };
  const Vec2<Lane> S1 = vector(moments, 0), S2 = vector(moments, 1), P1 = vector(pins, 0);
  const Lane M11(links[0]), J2(links[1]), constant(links[laneCount]);
  const Lane omega1(y[2]), omega2(y[3]);
  const Vec2<Lane> a = vectorOf(external.ground);

  const Lane kappa = dot(P1, S2);
  const Lane lambda = cross(P1, S2);
  Lane f1 = mulAdd(omega2 * omega2, lambda, momentOn<acting>(external, 0) - cross(S1, a));
  if constexpr (acting == LoadKind::forces) f1 += cross(P1, forceOn<acting>(external, 1));
  const Lane f2 = mulAdd(-(omega1 * omega1), lambda, momentOn<acting>(external, 1) - cross(S2, a));
  const Lane inverse = Lane(1) / mulAdd(lambda, lambda, constant);
  dydt[0] = y[2];
  dydt[1] = y[3];
  dydt[2] = (mulAdd(J2, f1, -kappa * f2) * inverse).v;
  dydt[3] = (mulAdd(M11, f2, -kappa * f1) * inverse).v;
}

template <LoadKind acting, int... n>
ShortChains::Run shortChainOf(int links, std::integer_sequence<int, n...>) {
  constexpr ShortChains::Run runs[] = {shortChain<1, acting>, twoBodies<acting>,
                                       shortChain<n + 3, acting>...};
  return runs[links - 1];
}

ShortChains::Run shortChainFor(int links, LoadKind acting) {
  constexpr std::make_integer_sequence<int, ShortChains::most - 2> longer;
  if (acting == LoadKind::nothing) return shortChainOf<LoadKind::nothing>(links, longer);
  if (acting == LoadKind::moments) return shortChainOf<LoadKind::moments>(links, longer);
  return shortChainOf<LoadKind::forces>(links, longer);
}

}  // namespace
}  // namespace planar_chain::simd
