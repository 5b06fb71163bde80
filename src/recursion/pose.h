#pragma once

/// The one sweep outwards: where the bodies of a chain are, and how they move.
///
/// Body j turns at ω_j by e_j = exp(i θ_j), like the body inside if its joint is prismatic. Its own point O_j
/// is the pin inside or, behind a prismatic joint of direction d_j = e_j (axis), S = s d further:
///
///     O ← O + S        v ← v + ω iS + ṡ d        then to the outer pin   O ← O + P     v ← v + ω iP
///
/// Everything has ground components. Nothing allocates.

#include "planar_chain/chain.h"
#include "recursion/general.h"

namespace planar_chain {

/// A point of the chain: its position, m, and velocity, m/s.
template <class Real>
struct PointAt {
  Vec2<Real> position, velocity;
};

/// A prismatic joint at displacement s and rate v, whose body turns at ω.
template <class Real>
Displacement<Real> displacementOf(Vec2d axis, Rotation<Real> e, Real omega, Real s, Real v) {
  const Vec2<Real> d = e * Vec2<Real>{Real(axis.x), Real(axis.y)}, S = s * d;
  const Real coriolis = omega * v;
  return {d, S, mulAdd(coriolis + coriolis, perp(d), -(omega * omega) * S)};
}

/// Calls f(j, point) with the own point of bodies first … end − 1, outwards from the outer pin `at` of the
/// body before. e, omega: of these bodies; x, rates: their coordinates, read of prismatic joints alone.
/// Returns the last outer pin. isMixed: false if no joint is prismatic.
template <bool isMixed = true, class Real, class F>
PointAt<Real> sweepOutwards(const Chain& chain, int first, int end, PointAt<Real> at, const Rotation<Real>* e,
                            const Real* omega, const Real* x, const Real* rates, F f) {
  for (int j = first; j < end; ++j) {
    const Rotation<Real> turn = e[j - first];
    const Real rate = omega[j - first];
    const Joint& joint = chain.joints()[index(j)];
    if (isMixed && joint.isPrismatic) {
      const Vec2<Real> d = turn * Vec2<Real>{Real(joint.axis.x), Real(joint.axis.y)}, S = x[j - first] * d;
      at.position += S;
      at.velocity += mulAdd(rate, perp(S), rates[j - first] * d);
    }
    f(j, at);
    const Vec2d pin = chain.links()[index(j)].pin;
    const Vec2<Real> P = turn * Vec2<Real>{Real(pin.x), Real(pin.y)};
    at.position += P;
    at.velocity += rate * perp(P);
  }
  return at;
}
/// All bodies, from the ground pin. Returns the tip.
template <class Real, class F>
PointAt<Real> sweepOutwards(const Chain& chain, PointAt<Real> at, const Rotation<Real>* e, const Real* omega,
                            const Real* x, const Real* rates, F f) {
  return sweepOutwards(chain, 0, chain.size(), at, e, omega, x, rates, f);
}

}  // namespace planar_chain
