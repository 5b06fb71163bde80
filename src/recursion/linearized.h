#pragma once

/// The exact linear solve of implicit methods in O(n).
///
/// Implicit methods need (s·1 − J) [u; v] = [ρ_q; ρ_v] with J the full Jacobian of (θ̇, ω̇) = (ω, α(θ, ω)).
/// The upper half says v = s u − ρ_q. So that v is not left over from a subtraction, write u = σ + u' with
/// σ = ρ_q/s; then v = s u'. For the lower half the recursion of articulated.h is differentiated as it
/// stands, so geometric (tension) stiffness, Coriolis terms, springs and dampers are all in it, and nothing
/// is approximated. With δα = s² u' − ρ_v, a point P of body j has δ(acceleration) = (z u' + w) P, where
///
///     z = i (s² − ω²) − 2 ω s − α          w = −i ρ_v − (i ω² + α) σ
///
/// (products of complex numbers). The joint at the inner pin resists with k̂ = k + s d. What hangs on a pin
/// shows its parent, which moves by δa and turns by σ + u', the force B δa + h u' + b and the moment
/// p·δa + q u' + r. With a the acceleration of the inner pin less gravity, F_outer the force on the next body
/// at its pin, X·F summed over the loads, J = I + m|R|² and z = x + i y, inwards:
///
///     κ   = X·F − R·(m a) − P·F_outer            λ   = Bᵀ iP + p
///     E_v = m iR + B iP                          E_d = m R + B P
///     U_R = y E_v + x E_d + h                    U_L = m iR + λ
///     D_m = J s² + κ + q + iP·h + y λ·iP + x λ·P        D = D_m + k̂
///     B ← m·1 + B − U_R U_Lᵀ/D     h ← U_R k̂/D     p ← k̂ U_L/D     q ← k̂ D_m/D
///
///     M_v = J + λ·iP     M_q = ω² λ·iP + α λ·P − κ     E_q = ω² E_v + α E_d     δ = −k (σ_j − σ_{j−1})
///     ε   = M_v ρ_v + M_q σ + δ − iP·b − r
///     b ← b − E_v ρ_v − E_q σ + U_R ε/D     r ← δ − k̂ ε/D
///
/// and outwards:  u' = (k̂ u'_parent + ε − U_L·δa)/D     δa ← δa + u' zP + wP.
///
/// q is not written k̂ − k̂²/D, which cancels for stiff springs. The factors are not symmetric, as J is not.
/// Everything is analytic in s, so Scalar may be complex. lanes/linear_kernel.h goes through the bodies.

#include "planar_chain/planar.h"

namespace planar_chain {

/// z·P, a product of complex numbers of the plane; z's parts may themselves be complex numbers.
template <class Scalar, class Real>
Vec2<Scalar> turnScale(Vec2<Scalar> z, Vec2<Real> P) {
  return {mulAdd(P.x, z.x, -P.y * z.y), mulAdd(P.y, z.x, P.x * z.y)};
}

template <class Scalar, class Real>
Scalar dotMixed(Vec2<Real> a, Vec2<Scalar> b) {
  return mulAdd(a.x, b.x, a.y * b.y);
}

/// A 2×2 matrix without symmetry.
template <class Scalar>
struct Matrix2 {
  Scalar xx{}, xy{}, yx{}, yy{};

  /// The product with P, plus a.
  template <class Real>
  Vec2<Scalar> times(Vec2<Real> P, Vec2<Scalar> a) const {
    return {mulAdd(P.x, xx, mulAdd(P.y, xy, a.x)), mulAdd(P.x, yx, mulAdd(P.y, yy, a.y))};
  }
};

/// A body in the state at which the chain is linearized.
template <class Real>
struct BodyAt {
  Real m, J, omega, alpha, kappa, k, d;
  Vec2<Real> R, P;
};

/// a + iα X − ω² X
template <class Real>
Vec2<Real> accelerationAt(const BodyAt<Real>& body, Vec2<Real> a, Vec2<Real> X) {
  return mulAdd(body.alpha, perp(X), mulAdd(-(body.omega * body.omega), X, a));
}

/// The terms of all that hangs on a pin, for its parent.
template <class Scalar>
struct LinearArticulatedTerms {
  Matrix2<Scalar> B;
  Vec2<Scalar> h, p;
  Scalar q{};
};

/// The factors of a body.
template <class Scalar>
struct LinearFactors {
  Scalar Mv, Mq, inverseD;  ///< inwards
  Vec2<Scalar> Ev, Eq, UR;
  Vec2<Scalar> ULD;  ///< outwards: U_L/D
  Scalar kD;         ///< k̂/D
};

/// k̂
template <class Scalar, class Real>
Scalar stiffness(const BodyAt<Real>& body, Scalar s) {
  return mulAdd(body.d, s, Scalar(body.k));
}

/// z
template <class Scalar, class Real>
Vec2<Scalar> turnOf(const BodyAt<Real>& body, Scalar s) {
  return {Real(-2) * body.omega * s - body.alpha, s * s - body.omega * body.omega};
}

/// w
template <class Scalar, class Real>
Vec2<Scalar> driftOf(const BodyAt<Real>& body, Scalar sigma, Scalar rhoV) {
  return {-(body.alpha * sigma), -rhoV - body.omega * body.omega * sigma};
}

/// One body inwards, for the factorization of s·1 − J: `articulated` by the outer pin becomes that by the
/// inner one.
template <class Scalar, class Real>
[[gnu::always_inline]] inline LinearFactors<Scalar> eliminate(const BodyAt<Real>& body, Scalar s,
                                                              LinearArticulatedTerms<Scalar>& articulated) {
  const auto [x, y] = turnOf(body, s);
  const Vec2<Real> P = body.P, iP = perp(P);
  const Matrix2<Scalar> B = articulated.B;
  const Vec2<Scalar> lambda{mulAdd(iP.x, B.xx, mulAdd(iP.y, B.yx, articulated.p.x)),
                            mulAdd(iP.x, B.xy, mulAdd(iP.y, B.yy, articulated.p.y))};
  const Vec2<Scalar> Ev = B.times(iP, {Scalar(-body.m * body.R.y), Scalar(body.m * body.R.x)});
  const Vec2<Scalar> Ed = B.times(P, {Scalar(body.m * body.R.x), Scalar(body.m * body.R.y)});
  const Scalar alongTurn = dotMixed(iP, lambda), alongPin = dotMixed(P, lambda);
  const Real ww = body.omega * body.omega;
  LinearFactors<Scalar> factors;
  factors.Mv = body.J + alongTurn;
  factors.Mq = mulAdd(ww, alongTurn, mulAdd(body.alpha, alongPin, Scalar(-body.kappa)));
  factors.Ev = Ev;
  factors.Eq = {mulAdd(ww, Ev.x, body.alpha * Ed.x), mulAdd(ww, Ev.y, body.alpha * Ed.y)};
  factors.UR = mulAdd(y, Ev, mulAdd(x, Ed, articulated.h));
  const Scalar Dm = mulAdd(body.J, s * s, body.kappa + articulated.q) +
                    (dotMixed(iP, articulated.h) + mulAdd(y, alongTurn, x * alongPin));
  const Scalar k = stiffness(body, s);
  factors.inverseD = Real(1) / (Dm + k);
  factors.kD = k * factors.inverseD;
  factors.ULD = factors.inverseD * mulAdd(body.m, perp(body.R), lambda);

  const Vec2<Scalar>&UR = factors.UR, &ULD = factors.ULD;
  articulated.B = {mulAdd(-UR.x, ULD.x, body.m + B.xx), mulAdd(-UR.x, ULD.y, B.xy),
                   mulAdd(-UR.y, ULD.x, B.yx), mulAdd(-UR.y, ULD.y, body.m + B.yy)};
  articulated.h = factors.kD * UR;
  articulated.p = k * ULD;
  articulated.q = factors.kD * Dm;
  return factors;
}

/// One body inwards, for a right-hand side: b and r of what hangs on its outer pin become those of what hangs
/// on its inner one. Returns ε/D. relative: σ less that of the parent.
template <class Scalar, class Real>
Scalar carry(const BodyAt<Real>& body, const LinearFactors<Scalar>& factors, Scalar s, Scalar sigma,
             Scalar relative, Scalar rhoV, Vec2<Scalar>& b, Scalar& r) {
  const Scalar delta = -(body.k * relative);
  const Scalar own = mulAdd(factors.Mv, rhoV, mulAdd(factors.Mq, sigma, delta - r));
  const Scalar epsilonD = (own - dotMixed(perp(body.P), b)) * factors.inverseD;
  b = mulAdd(epsilonD, factors.UR, mulAdd(-rhoV, factors.Ev, mulAdd(-sigma, factors.Eq, b)));
  r = mulAdd(-stiffness(body, s), epsilonD, delta);
  return epsilonD;
}

/// δa and u' of the way out, from body to body.
template <class Scalar>
struct Moving {
  Vec2<Scalar> da;
  Scalar parent{};

  template <class Real>
  void pass(const BodyAt<Real>& body, const LinearFactors<Scalar>& factors, Scalar s, Scalar sigma,
            Scalar rhoV, Scalar epsilonD) {
    const Vec2<Scalar> zP = turnScale(turnOf(body, s), body.P);
    const Vec2<Scalar> wP = turnScale(driftOf(body, sigma, rhoV), body.P);
    const Scalar pulled = mulAdd(-factors.ULD.x, da.x, mulAdd(-factors.ULD.y, da.y, epsilonD));
    parent = mulAdd(factors.kD, parent, pulled);
    da = mulAdd(parent, zP, da + wP);
  }
};

}  // namespace planar_chain
