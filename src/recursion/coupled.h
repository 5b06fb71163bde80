#pragma once

/// Forward dynamics in O(n) of a chain whose joints couple accelerations: with rotors, driven or stuck
/// joints, and a base that moves. articulated.h has the letters and the recursion without them.
///
/// The moment μ of such a joint on its body depends on the accelerations of both bodies. So a body shows its
/// inner pin, of acceleration a, and the body inside of it, of angular acceleration α_p,
///
///     F_pin = A a + H α_p + b          μ = H·a + Q α_p + c
///
/// N contains all other joint torques. κ = J/D and 1/D are those of a free joint with a rotor (J = 0 without
/// one), where q̈ = 0. A held joint, with given q̈, is the limit J → ∞. The sweep inwards starts at the tip
/// with zeros:
///
///     U = m iR + A iP + H              D0 = I + m|R|² + iP·(A iP) + 2 iP·H + Q
///     β = b − ω² A P                   ε  = N − iP·β − (c − ω² H·P)
///     f = β − F − ω² m R
///
///     D = D0 + J, κ = J/D              or of a held joint 1/D = 0, κ = 1
///     α = (ε − U·a)/D + κ α_p + q̈      μ = −J (α − α_p), or of a held joint D0 α + U·a − ε
///     A ← m + A − U Uᵀ/D               H ← κ U         Q ← κ D0
///     b ← f + U (ε/D + q̈)              c ← κ (D0 q̈ − ε)
///
/// Outwards a ← a + iα P − ω² P, from the acceleration of the ground pin less gravity and from the base's
/// angular acceleration. The F_pin of the first body is the force of the base on it. If all joints are held,
/// this is inverse dynamics.
///
/// Source: derived as in articulated.h. Against another formulation: machines_test.

#include "planar_chain/planar.h"
#include "recursion/articulated.h"

namespace planar_chain {

/// What couples the accelerations of a joint's two bodies.
template <class Real>
struct Coupling {
  Real rotor{};         ///< J, kg m²
  bool isHeld = false;  ///< driven or stuck: q̈ is given
  Real acceleration{};  ///< q̈ of a held joint, rad/s²
};

/// The same as numbers, for lanes too.
template <class Real>
struct JointAt {
  Real rotor, held, acceleration;  ///< rotor: 0 of a held joint; held: 1 or 0
};

template <class Real>
JointAt<Real> numbersOf(const Coupling<Real>& joint) {
  return {joint.isHeld ? Real(0) : joint.rotor, Real(joint.isHeld ? 1 : 0), joint.acceleration};
}

/// What a body shows its inner pin.
template <class Real>
struct CoupledPin {
  Sym2<Real> A;
  Vec2<Real> b, H;
  Real Q{}, c{};
};

/// The results of the sweep inwards for one body. kappa: κ.
template <class Real>
struct CoupledHandle {
  Vec2<Real> U;
  Real epsilon, inverseD, kappa, D0;
};

/// One body of the sweep inwards. Replaces the outer pin by the inner one; the caller subtracts the forces F
/// on the body from b.
template <class Real>
[[gnu::always_inline]] inline CoupledHandle<Real> inwards(const Turned<Real>& body, Real N,
                                                          const JointAt<Real>& joint, CoupledPin<Real>& pin) {
  const auto& [A, b, H, Q, c] = pin;
  const Vec2<Real> mR = body.m * body.R, iP = perp(body.P), AiP = A * iP;
  const Vec2<Real> beta = mulAdd(-body.ww, A * body.P, b);
  const Vec2<Real> U = perp(mR) + AiP + H;
  const Real D0 = body.J + dot(iP, AiP + H) + dot(iP, H) + Q;
  const Real epsilon = N - dot(iP, beta) - mulAdd(-body.ww, dot(H, body.P), c);
  const Real inverseD = (Real(1) - joint.held) / (D0 + joint.rotor + joint.held);
  const Real kappa = mulAdd(joint.rotor, inverseD, joint.held);
  const Vec2<Real> UD = inverseD * U;
  pin = {{mulAdd(-UD.x, U.x, body.m + A.xx), mulAdd(-UD.x, U.y, A.xy), mulAdd(-UD.y, U.y, body.m + A.yy)},
         mulAdd(mulAdd(inverseD, epsilon, joint.acceleration), U, mulAdd(-body.ww, mR, beta)),
         kappa * U,
         kappa * D0,
         kappa * mulAdd(D0, joint.acceleration, -epsilon)};
  return {U, epsilon, inverseD, kappa, D0};
}

/// One body of the sweep outwards. Replaces a and the angular acceleration of the inner side by those of the
/// outer side. Returns μ.
template <class Real>
[[gnu::always_inline]] inline Real outwards(const CoupledHandle<Real>& body, const JointAt<Real>& joint,
                                            Vec2<Real> P, Real ww, Vec2<Real>& a, Real& turning) {
  const Real parent = turning, pulled = mulAdd(-body.U.x, a.x, mulAdd(-body.U.y, a.y, body.epsilon));
  turning = mulAdd(body.inverseD, pulled, mulAdd(body.kappa, parent, joint.acceleration));
  a = mulAdd(turning, perp(P), mulAdd(-ww, P, a));
  return mulAdd(joint.held, mulAdd(body.D0, turning, -pulled), joint.rotor * (parent - turning));
}

/// What a chain shows its ends: see ended.h.
template <class Real>
struct EndedPin {
  CoupledPin<Real> pin;
  Vec2<Real> Gx{Real(1), Real(0)}, Gy{Real(0), Real(1)};  ///< the columns of G
  Vec2<Real> eta, tip;                                    ///< η, c_t
  Sym2<Real> C;

  /// Gᵀ a
  [[gnu::always_inline]] Vec2<Real> transposed(Vec2<Real> a) const { return {dot(Gx, a), dot(Gy, a)}; }
  /// G λ
  [[gnu::always_inline]] Vec2<Real> times(Vec2<Real> lambda) const { return lambda.x * Gx + lambda.y * Gy; }

  /// One body inwards, but for η. turn: ε/D + q̈. Returns g.
  [[gnu::always_inline]] Vec2<Real> pass(const Turned<Real>& body, Vec2<Real> U, Real inverseD, Real turn) {
    const Vec2<Real> g = transposed(perp(body.P)) + eta, gD = inverseD * g;
    C = {mulAdd(gD.x, g.x, C.xx), mulAdd(gD.x, g.y, C.xy), mulAdd(gD.y, g.y, C.yy)};
    tip = mulAdd(turn, g, mulAdd(-body.ww, transposed(body.P), tip));
    Gx = mulAdd(-gD.x, U, Gx);
    Gy = mulAdd(-gD.y, U, Gy);
    return g;
  }
};

}  // namespace planar_chain
