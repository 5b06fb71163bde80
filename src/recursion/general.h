#pragma once

/// Forward dynamics in O(n) with joints of any kind anywhere: revolute or prismatic, free with armature or
/// prescribed, on a base that moves, with a tip that is held. articulated.h has the recursion of chains whose
/// joints are all revolute and free, on a base at rest.
///
/// The point of the body inside a joint has the acceleration a (less gravity), and the body turns with α_p.
/// All that is outside the joint acts on that body with a force and a moment about that point:
///
///     F = A a + H α_p + b          μ = H·a + Q α_p + c
///
/// N_i is the moment of all that acts about the own point of body i, and of the bodies that turn with it; of
/// a prismatic joint the force along its axis d. J is the armature of the joint, f = N, and body j has β = b
/// − ω² A P. Inwards, from zeros at the tip:
///
///     body          Q ← I + m|R|² + iP·(A iP) + 2 iP·H + Q
///                   c ← iP·β + c − ω² H·P          b ← β − ω² m R − F
///                   H ← m iR + A iP + H            A ← m + A
///     revolute      u = H      v = Q       D_0 = Q          ε = f − c
///     prismatic     u = A d    v = H·d     D_0 = d·u        ε = f − d·b
///     free          A ← A − u uᵀ/D         H ← H − u v/D    Q ← Q − v²/D      with D = D_0 + J
///                   b ← b + u ε/D          c ← c + v ε/D
///     prescribed    b ← b + u q̈            c ← c + v q̈
///
/// A revolute joint shows κ u, κ D_0 and κ (D_0 q̈ − ε) with κ = J/D, or κ = 1 if it is prescribed: so nothing
/// cancels, and N is not in c. From the own point of a body behind a prismatic joint to the pin inside, with
/// S = s d and γ = −ω² S + 2 ω ṡ i d:
///
///     b ← b + A γ      c ← c + H·γ + iS·b      Q ← Q + 2 iS·H + iS·(A iS)      H ← H + A iS
///
/// Outwards, from the acceleration of the base less gravity and its angular acceleration:
///
///     revolute      α = (ε − u·a)/D + κ α_p        μ = −J q̈          or α_p + q̈       μ = D_0 α + u·a − ε
///     prismatic     a ← a + α_p iS + γ             q̈ = (ε − u·a − v α_p)/D             μ = −J q̈
///                   or as prescribed               μ = D_0 q̈ + u·a + v α_p − ε         a ← a + q̈ d
///     then          a ← a + iα P − ω² P
///
/// μ is the torque or force of armatures and of what moves prescribed joints, beside f.
///
/// A base that moves is three prescribed joints without mass, a free chain begins with two free prismatic
/// joints without mass. F and μ of the first joint, at the base, are the wrench of the base on the chain.
///
/// A force λ on the tip is linear in all that is shown, and so is the acceleration of the tip:
///
///     F = … − G λ          μ = … − η·λ          a_tip = Gᵀ a + η α_p + C λ + c_t
///
/// Both have G and η, as the mass matrix is symmetric. From G = 1 and zeros at the tip:
///
///     body          c_t ← c_t − ω² Gᵀ P          η ← η + Gᵀ iP
///     joint         y = η, or Gᵀ d               ε ← ε + y·λ
///     free          C ← C + y yᵀ/D    c_t ← c_t + y ε/D    G ← G − u yᵀ/D    η ← η − v y/D
///     prescribed    c_t ← c_t + y q̈
///     prismatic     c_t ← c_t + Gᵀ γ             η ← η + Gᵀ iS
///
/// C sums positive terms, so it does not cancel.
///
/// Source: R. Featherstone, Rigid Body Dynamics Algorithms (2008), ch. 7, reduced to the plane. Against dense
/// equations: general_test; against another formulation: machines_test.

#include "planar_chain/planar.h"
#include "recursion/articulated.h"

namespace planar_chain {

/// The law of a joint: free with armature, or prescribed.
template <class Real>
struct JointLaw {
  Real armature{};  ///< J, kg m², of a prismatic joint kg
  bool isPrescribed = false;
  Real acceleration{};  ///< q̈ of a prescribed joint
};

/// A joint as numbers, for lanes too.
template <class Real>
struct JointNumbers {
  Real armature, prescribed, acceleration;  ///< armature: 0 of a prescribed joint; prescribed: 1 or 0
};

template <class Real>
JointNumbers<Real> numbersOf(const JointLaw<Real>& law) {
  return {law.isPrescribed ? Real(0) : law.armature, Real(law.isPrescribed ? 1 : 0), law.acceleration};
}

/// A prismatic joint at its state; zeros: a revolute one.
template <class Real>
struct Displacement {
  Vec2<Real> d, S, gamma;
};

/// The terms of the force and moment from all that is outside a joint.
template <class Real>
struct ArticulatedTerms {
  Sym2<Real> A;
  Vec2<Real> b, H;
  Real Q{}, c{};
};

/// The results of the sweep inwards for one joint.
template <class Real>
struct JointTerms {
  Vec2<Real> u;
  Real v, epsilon, inverseD, D0;  ///< v: κ of a revolute joint
};

/// From the outer pin of a body to its own point. The caller subtracts the forces F on the body from b.
template <class Real>
[[gnu::always_inline]] inline void addBody(const BodyPose<Real>& body, ArticulatedTerms<Real>& to) {
  const auto& [A, b, H, Q, c] = to;
  const Vec2<Real> mR = body.m * body.R, iP = perp(body.P), AiP = A * iP;
  const Vec2<Real> beta = mulAdd(-body.ww, A * body.P, b);
  to = {{body.m + A.xx, A.xy, body.m + A.yy},
        mulAdd(-body.ww, mR, beta),
        perp(mR) + AiP + H,
        body.J + dot(iP, AiP + H) + dot(iP, H) + Q,
        dot(iP, beta) + mulAdd(-body.ww, dot(H, body.P), c)};
}

/// A ← A − w uᵀ, symmetric
template <class Real>
[[gnu::always_inline]] inline Sym2<Real> less(const Sym2<Real>& A, Vec2<Real> w, Vec2<Real> u) {
  return {mulAdd(-w.x, u.x, A.xx), mulAdd(-w.x, u.y, A.xy), mulAdd(-w.y, u.y, A.yy)};
}

/// Takes b and c from the outside of a revolute joint to its inside. Its other terms are known. N: without
/// the part that is in c.
template <class Real>
[[gnu::always_inline]] inline void biasRevolute(Real N, const JointNumbers<Real>& joint,
                                                JointTerms<Real>& terms, Vec2<Real>& b, Real& c) {
  terms.epsilon = N - c;
  b = mulAdd(mulAdd(terms.inverseD, terms.epsilon, joint.acceleration), terms.u, b);
  c = terms.v * mulAdd(terms.D0, joint.acceleration, -terms.epsilon);
}
/// The bias of a prismatic joint, at the own point of its body. N: the force along the axis d.
template <class Real>
[[gnu::always_inline]] inline void biasPrismatic(Real N, const JointNumbers<Real>& joint, Vec2<Real> d,
                                                 JointTerms<Real>& terms, Vec2<Real>& b, Real& c) {
  terms.epsilon = N - dot(d, b);
  const Real turn = mulAdd(terms.inverseD, terms.epsilon, joint.acceleration);
  b = mulAdd(turn, terms.u, b);
  c = mulAdd(turn, terms.v, c);
}

/// Through a revolute joint.
template <class Real>
[[gnu::always_inline]] inline JointTerms<Real> passRevolute(Real N, const JointNumbers<Real>& joint,
                                                            ArticulatedTerms<Real>& articulated) {
  JointTerms<Real> terms{articulated.H, {}, {}, {}, articulated.Q};
  terms.inverseD = (Real(1) - joint.prescribed) / (terms.D0 + joint.armature + joint.prescribed);
  terms.v = mulAdd(joint.armature, terms.inverseD, joint.prescribed);
  biasRevolute(N, joint, terms, articulated.b, articulated.c);
  articulated.A = less(articulated.A, terms.inverseD * terms.u, terms.u);
  articulated.H = terms.v * terms.u;
  articulated.Q = terms.v * terms.D0;
  return terms;
}

/// Through a prismatic joint, at the own point of its body.
template <class Real>
[[gnu::always_inline]] inline JointTerms<Real> passPrismatic(Real N, const JointNumbers<Real>& joint,
                                                             Vec2<Real> d,
                                                             ArticulatedTerms<Real>& articulated) {
  JointTerms<Real> terms{articulated.A * d, dot(articulated.H, d), {}, {}, {}};
  terms.D0 = dot(d, terms.u);
  terms.inverseD = (Real(1) - joint.prescribed) / (terms.D0 + joint.armature + joint.prescribed);
  biasPrismatic(N, joint, d, terms, articulated.b, articulated.c);
  const Vec2<Real> uD = terms.inverseD * terms.u;
  articulated.A = less(articulated.A, uD, terms.u);
  articulated.H = mulAdd(-terms.v, uD, articulated.H);
  articulated.Q = mulAdd(-terms.v * terms.inverseD, terms.v, articulated.Q);
  return terms;
}

/// From the own point of a body behind a prismatic joint to the pin inside.
template <class Real>
[[gnu::always_inline]] inline void stepInwards(const Displacement<Real>& by,
                                               ArticulatedTerms<Real>& articulated) {
  const Vec2<Real> iS = perp(by.S), AiS = articulated.A * iS;
  articulated.b += articulated.A * by.gamma;
  articulated.c += dot(articulated.H, by.gamma) + dot(iS, articulated.b);
  articulated.Q += dot(iS, articulated.H + articulated.H + AiS);
  articulated.H += AiS;
}

/// How a point of the chain moves on the way out: its acceleration less gravity, and the angular acceleration
/// of its body.
template <class Real>
struct Moved {
  Vec2<Real> a;
  Real alpha{};
};

/// Through a revolute joint. Returns μ.
template <class Real>
[[gnu::always_inline]] inline Real outwardsRevolute(const JointTerms<Real>& joint,
                                                    const JointNumbers<Real>& law, Moved<Real>& at) {
  const Real parent = at.alpha;
  const Real pulled = mulAdd(-joint.u.x, at.a.x, mulAdd(-joint.u.y, at.a.y, joint.epsilon));
  at.alpha = mulAdd(joint.inverseD, pulled, mulAdd(joint.v, parent, law.acceleration));
  return mulAdd(law.prescribed, mulAdd(joint.D0, at.alpha, -pulled), law.armature * (parent - at.alpha));
}
/// Through a prismatic joint, from the pin inside to the own point of the body. Writes q̈, returns μ.
template <class Real>
[[gnu::always_inline]] inline Real outwardsPrismatic(const JointTerms<Real>& joint,
                                                     const JointNumbers<Real>& law,
                                                     const Displacement<Real>& by, Moved<Real>& at,
                                                     Real& qdd) {
  at.a = mulAdd(at.alpha, perp(by.S), at.a + by.gamma);
  const Real pulled =
      mulAdd(-joint.v, at.alpha, mulAdd(-joint.u.x, at.a.x, mulAdd(-joint.u.y, at.a.y, joint.epsilon)));
  qdd = mulAdd(joint.inverseD, pulled, law.acceleration);
  at.a += qdd * by.d;
  return mulAdd(law.prescribed, mulAdd(joint.D0, qdd, -pulled), -(law.armature * qdd));
}
/// From the own point of a body to its outer pin.
template <class Real>
[[gnu::always_inline]] inline void toOuterPin(Vec2<Real> P, Real ww, Moved<Real>& at) {
  at.a = mulAdd(at.alpha, perp(P), mulAdd(-ww, P, at.a));
}

/// The further terms of a chain with a held tip.
template <class Real>
struct TipTerms {
  Vec2<Real> Gx{Real(1), Real(0)}, Gy{Real(0), Real(1)};  ///< the columns of G
  Vec2<Real> eta, c;                                      ///< η, c_t
  Sym2<Real> C;

  /// Gᵀ a
  [[gnu::always_inline]] Vec2<Real> transposed(Vec2<Real> a) const { return {dot(Gx, a), dot(Gy, a)}; }
  /// G λ
  [[gnu::always_inline]] Vec2<Real> times(Vec2<Real> lambda) const { return lambda.x * Gx + lambda.y * Gy; }

  [[gnu::always_inline]] void addBody(Vec2<Real> P, Real ww) {
    c = mulAdd(-ww, transposed(P), c);
    eta += transposed(perp(P));
  }
  /// Through a joint with this y. turn: ε/D + q̈.
  [[gnu::always_inline]] void pass(Vec2<Real> y, const JointTerms<Real>& joint, Real turn) {
    const Vec2<Real> yD = joint.inverseD * y;
    C = {mulAdd(yD.x, y.x, C.xx), mulAdd(yD.x, y.y, C.xy), mulAdd(yD.y, y.y, C.yy)};
    c = mulAdd(turn, y, c);
    Gx = mulAdd(-yD.x, joint.u, Gx);
    Gy = mulAdd(-yD.y, joint.u, Gy);
  }
  /// Returns y.
  [[gnu::always_inline]] Vec2<Real> passRevolute(const JointTerms<Real>& joint,
                                                 const JointNumbers<Real>& law) {
    const Vec2<Real> y = eta;
    pass(y, joint, mulAdd(joint.inverseD, joint.epsilon, law.acceleration));
    eta = joint.v * y;
    return y;
  }
  [[gnu::always_inline]] Vec2<Real> passPrismatic(const JointTerms<Real>& joint,
                                                  const JointNumbers<Real>& law, Vec2<Real> d) {
    const Vec2<Real> y = transposed(d);
    pass(y, joint, mulAdd(joint.inverseD, joint.epsilon, law.acceleration));
    eta = mulAdd(-joint.v * joint.inverseD, y, eta);
    return y;
  }
  [[gnu::always_inline]] void stepInwards(const Displacement<Real>& by) {
    c += transposed(by.gamma);
    eta += transposed(perp(by.S));
  }
};

}  // namespace planar_chain
