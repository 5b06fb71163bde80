#pragma once

/// Forward dynamics in O(n): articulated bodies in the plane. Simulations use this method.
///
/// A pin transmits a force, and no moment that depends on the motion. So the force on a pin from everything
/// outside it is linear in the pin's acceleration:  F_pin = A a_pin + b.  A is symmetric, 2×2, and called the
/// articulated mass. b is the bias force.
///
/// Let e_j = exp(i θ_j), R = e r, P = e p. N is the moment about the inner pin of everything but pins and
/// inertia: N_j = M_j + τ_j − τ_{j+1} + X×F. The sweep inwards starts at the tip with A = 0 and b = 0:
///
///     U = m iR + A iP
///     D = I + m|R|² + iP·(A iP)         |R|² of the rounded R, not |r|²: then A cancels better
///     β = b − ω² A P
///     u = N − iP·β
///     A ← m·1 + A − U Uᵀ/D
///     b ← β − F − ω² m R + U u/D
///
/// The sweep outwards starts at the ground with a = −g. Gravity is an acceleration of the frame here, so F
/// does not contain it:
///
///     α = u/D − (U/D)·a        a ← a + iα P − ω² P
///
/// Source: R. Featherstone, Rigid Body Dynamics Algorithms (2008), ch. 7, reduced to planar pins. Without the
/// rotation at the pin, 2×2 matrices and one division per link remain. The number type is a template
/// parameter: tests use long double.

#include "planar_chain/planar.h"

namespace planar_chain {

/// The constants of one body.
template <class Real>
struct Body {
  Real m, I;
  Vec2<Real> r, p;
};

/// A body at its present angle and rate: the values that do not depend on its neighbours.
template <class Real>
struct BodyPose {
  Real m, J;  ///< J = I + m|R|²
  Vec2<Real> R, P;
  Real ww;  ///< ω²
};

template <class Real>
inline BodyPose<Real> bodyPose(const Body<Real>& body, Rotation<Real> e, Real omega) {
  const Vec2<Real> R = e * body.r;
  return {body.m, mulAdd(body.m, dot(R, R), body.I), R, e * body.p, omega * omega};
}

/// The results of the sweep inwards for one body: U, u and 1/D.
template <class Real>
struct Factors {
  Vec2<Real> U;
  Real u, inverseD;
};

/// One body of the sweep inwards. Replaces A and b of the outer pin by those of the inner pin; the caller
/// subtracts the forces F on the body from b. For the tip, A and b are only written.
template <bool isTip, class Real>
[[gnu::always_inline]] inline Factors<Real> inwards(const BodyPose<Real>& body, Real N, Sym2<Real>& A,
                                                    Vec2<Real>& b) {
  const Vec2<Real> mR = body.m * body.R;
  Factors<Real> factors{perp(mR), N, Real(1)};
  Real D = body.J;
  Sym2<Real> mass{body.m, Real(0), body.m};
  Vec2<Real> beta{};
  if constexpr (!isTip) {
    const Vec2<Real> AiP = A * perp(body.P);
    factors.U += AiP;
    D = mulAdd(body.P.x, AiP.y, mulAdd(-body.P.y, AiP.x, D));
    beta = mulAdd(-body.ww, A * body.P, b);
    factors.u = N - dot(perp(body.P), beta);
    mass = {body.m + A.xx, A.xy, body.m + A.yy};
  }
  factors.inverseD = Real(1) / D;
  const Vec2<Real> U = factors.U;
  const Real minus = -factors.inverseD;
  A = {mulAdd(minus, U.x * U.x, mass.xx), mulAdd(minus, U.x * U.y, mass.xy),
       mulAdd(minus, U.y * U.y, mass.yy)};
  b = mulAdd(factors.u * factors.inverseD, U, mulAdd(-body.ww, mR, beta));
  return factors;
}

/// The values of a body for the sweep outwards.
template <class Real>
struct OutwardTerms {
  Vec2<Real> UD, P;  ///< U/D, P
  Real uD, ww;       ///< u/D, ω²
};

template <class Real>
[[gnu::always_inline]] inline OutwardTerms<Real> outwardTermsOf(const Factors<Real>& factors,
                                                                const BodyPose<Real>& body) {
  return {factors.inverseD * factors.U, body.P, factors.inverseD * factors.u, body.ww};
}

/// One body of the sweep outwards. Replaces a of the inner pin by that of the outer pin. Returns α.
template <class Real>
[[gnu::always_inline]] inline Real outwards(const OutwardTerms<Real>& body, Vec2<Real>& a) {
  const Real alpha = mulAdd(-body.UD.x, a.x, mulAdd(-body.UD.y, a.y, body.uD));
  a = mulAdd(alpha, perp(body.P), mulAdd(-body.ww, body.P, a));
  return alpha;
}

}  // namespace planar_chain
