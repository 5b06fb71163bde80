#pragma once

/// The exact linear solve of linearized.h for a chain with coupled joints (coupled.h). A rotor is one more
/// term of the joint's spring, and a held joint is its limit:
///
///     rotor    k̂ = k + s d + s² J         δ also + J (ρ_v,i − ρ_v,i−1)
///     held     k̂ → ∞:   B ← T + B     h ← U_R     p ← U_L     q ← D_m
///              u' = u'_parent + w     w = (ρ_v,i − ρ_v,i−1)/s²
///              b ← b − E_v ρ_v − E_q σ + U_R w     r ← D_m w − ε
///
/// The moment of a joint changes by δμ = q u'_parent + Σ p_k·y_k + r with (p, q, r) of its inner pin, and the
/// force of the base by b of the first body. They give the changes of the powers.
///
/// Forces may depend on the place and velocity of their bodies: each body then has K and D of
/// force_tangent.h. Such a force feels how its body's pin moves, not only how the pin accelerates. So a body
/// shows its parent, which turns by σ + u', a force and a moment that are linear in y = (δa, δv, δx) of the
/// pin, six numbers; or in δa alone where no force is of this kind:
///
///     δF_pin = Σ B_k y_k + h u' + b          δμ = Σ p_k·y_k + q u' + r          k = a, v, x
///
/// A point P of the body moves by y_k + (z_k u' + w_k) P, in complex numbers, where
///
///     z_a = i (s² − ω²) − 2 ω s − α          z_v = i s − ω          z_x = i
///     w_a = −i ρ_v − (α + i ω²) σ            w_v = −ω σ             w_x = i σ
///
/// Write z_k = x_k + i y_k and w_k = (x'_k + i y'_k) σ, but for −i ρ_v. The body adds T_k to what hangs on
/// its outer pin: T_a = m 1, T_v = D_xx, T_x = K_xx. The row of moments adds t_k: t_a = m iR, t_v = D_θx, t_x
/// = K_θx. As in linearized.h, inwards from zeros at the tip:
///
///     λ_k = B_kᵀ iP + p_k          ζ_k = B_k iP, ξ_k = B_k P, and m iR, m R more for k = a
///     U_R = h + Σ (y_k ζ_k + x_k ξ_k) + K_xθ + s D_xθ          U_L,k = t_k + λ_k
///     D_m = J s² + κ + K_θθ + s D_θθ + q + iP·h + Σ (y_k λ_k·iP + x_k λ_k·P)          D = D_m + k̂
///     B_k ← T_k + B_k − U_R U_L,kᵀ/D     h ← U_R k̂/D     p_k ← k̂ U_L,k/D     q ← k̂ D_m/D
///
///     M_v = J + λ_a·iP     M_q = −κ − K_θθ − Σ (y'_k λ_k·iP + x'_k λ_k·P)
///     E_v = ζ_a            E_q = −K_xθ − Σ (y'_k ζ_k + x'_k ξ_k)
///
/// With these, ε, b and r are those of linearized.h, and a right-hand side costs the same. Outwards
/// u' = (k̂ u'_parent + ε − Σ U_L,k·y_k)/D.
///
/// Source: derived as in linearized.h. Against Newton's and Euler's equations: tangent_linearized_test.

#include <array>
#include <cstddef>
#include <vector>

#include "recursion/coupled_bodies.h"
#include "recursion/force_tangent.h"

namespace planar_chain {

/// Numbers for k = a, v, x, or for k = a alone if no force depends on place or velocity.
template <class Value, std::size_t kinds = 3>
using PerMotion = std::array<Value, kinds>;

/// What hangs on a pin, as its parent feels it.
template <class Scalar, std::size_t kinds = 3>
struct CoupledShown {
  PerMotion<Matrix2<Scalar>, kinds> B{};
  PerMotion<Vec2<Scalar>, kinds> p{};
  Vec2<Scalar> h;
  Scalar q{};
};

/// z_k
template <std::size_t kinds, class Scalar>
PerMotion<Vec2<Scalar>, kinds> turnsOf(const BodyAt<double>& body, Scalar s) {
  if constexpr (kinds == 1)
    return {turnOf(body, s)};
  else
    return {turnOf(body, s), Vec2<Scalar>{Scalar(-body.omega), s}, Vec2<Scalar>{Scalar(0), Scalar(1)}};
}

/// w_k for σ = 1 and ρ_v = 0
template <std::size_t kinds>
PerMotion<Vec2d, kinds> driftsOf(const BodyAt<double>& body) {
  const Vec2d ofAcceleration{-body.alpha, -body.omega * body.omega};
  if constexpr (kinds == 1)
    return {ofAcceleration};
  else
    return {ofAcceleration, Vec2d{-body.omega, 0}, Vec2d{0, 1}};
}

/// The solve of a chain whose joints couple accelerations. Only constructors allocate.
template <class Scalar>
class CoupledSolve {
 public:
  virtual ~CoupledSolve() = default;
  /// Factors s·1 − J.
  virtual void factor(Scalar s) = 0;
  /// [u; v] = (s·1 − J)⁻¹ [ρ_q; ρ_v]; n values each, and the results may stand in the same place.
  virtual void solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) = 0;

  // The changes along the last solution: of the moment in joint i, of the force of the base, and of that on
  // the tip.
  virtual Scalar moment(int i) const = 0;
  virtual Vec2<Scalar> pinForce() const = 0;
  virtual Vec2<Scalar> tipForce() const { return {}; }
  /// Of the moment of the base about the ground pin, beside that in the first joint that turns.
  virtual Scalar baseMoment() const { return {}; }
};

/// kinds: 3, or 1 if no force depends on place or velocity.
template <class Scalar, std::size_t kinds>
class CoupledLinearized : public CoupledSolve<Scalar> {
 public:
  /// tangents: K and D of each body, not read if kinds = 1. Both must outlive this object; factor() reads
  /// them.
  CoupledLinearized(const CoupledBodies& bodies, const ForceTangent* tangents)
      : bodies_(bodies), tangents_(tangents), handles_(bodies.size()), moments_(bodies.size()) {}

  void factor(Scalar s) override {
    s_ = s;
    CoupledShown<Scalar, kinds> shown;
    for (std::size_t j = bodies_.size(); j-- > 0;) eliminate(j, shown);
    shown_ = shown;
  }
  void solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) override {
    carryInwards(rhoQ, rhoV);
    carryOutwards(rhoQ, rhoV, {}, u, v);
  }
  Scalar moment(int i) const override { return moments_[index(i)]; }
  Vec2<Scalar> pinForce() const override { return pinForce_; }

 protected:
  struct Handle {
    Scalar Mv, Mq, Dm, over, kD;  ///< over: 1/D; kD: k̂/D; 0 and 1 for a held joint
    Vec2<Scalar> Ev, Eq, UR;
    PerMotion<Vec2<Scalar>, kinds> ULD, p;
    Scalar q, turn;  ///< turn: ε/D, or w of a held joint
  };

  /// Of each joint ε/D and r, and δF_pin of the first body.
  void carryInwards(const Scalar* rhoQ, const Scalar* rhoV);
  /// y: how the first pin moves.
  void carryOutwards(const Scalar* rhoQ, const Scalar* rhoV, PerMotion<Vec2<Scalar>, kinds> y, Scalar* u,
                     Scalar* v);

  const CoupledBodies& bodies_;
  const ForceTangent* tangents_;
  Scalar s_{};
  CoupledShown<Scalar, kinds> shown_;  ///< by the first pin
  std::vector<Handle> handles_;
  std::vector<Scalar> moments_;
  Vec2<Scalar> pinForce_;

 private:
  void eliminate(std::size_t j, CoupledShown<Scalar, kinds>& shown) {
    const BodyAt<double>& body = bodies_[j];
    const Coupling<double>& joint = bodies_.joint(j);
    const Vec2d P = body.P, iP = perp(P), mR = body.m * body.R;
    const auto z = turnsOf<kinds>(body, s_);
    const auto w = driftsOf<kinds>(body);
    Vec2<Scalar> UR = shown.h, Eq;
    Scalar Mq(-body.kappa), Dm = body.J * s_ * s_ + body.kappa + shown.q + dotMixed(iP, shown.h);
    if constexpr (kinds == 3) {
      const auto& [K, D] = tangents_[j];
      UR = mulAdd(s_, D.forceTurn, mulAdd(1.0, K.forceTurn, UR));
      Eq = {Scalar(-K.forceTurn.x), Scalar(-K.forceTurn.y)};
      Mq -= K.momentTurn;
      Dm += K.momentTurn + s_ * D.momentTurn;
    }
    Handle& handle = handles_[j];

    // Σ over a, v, x
    PerMotion<Vec2<Scalar>, kinds> UL;
    for (std::size_t k = 0; k < kinds; ++k) {
      const Matrix2<Scalar>& B = shown.B[k];
      const Vec2<Scalar> lambda{iP.x * B.xx + iP.y * B.yx + shown.p[k].x,
                                iP.x * B.xy + iP.y * B.yy + shown.p[k].y};
      const Scalar alongTurn = dotMixed(iP, lambda), alongPin = dotMixed(P, lambda);
      const Vec2d m = k == 0 ? mR : Vec2d{};
      const Vec2<Scalar> zeta = B.times(iP, {Scalar(-m.y), Scalar(m.x)});
      const Vec2<Scalar> xi = B.times(P, {Scalar(m.x), Scalar(m.y)});
      if (k == 0) {
        handle.Mv = body.J + alongTurn;
        handle.Ev = zeta;
      }
      UR = mulAdd(z[k].y, zeta, mulAdd(z[k].x, xi, UR));
      Dm += z[k].y * alongTurn + z[k].x * alongPin;
      const Vec2<Scalar> drift = mulAdd(w[k].y, zeta, Vec2<Scalar>{w[k].x * xi.x, w[k].x * xi.y});
      Eq = kinds == 1 ? Vec2<Scalar>{-drift.x, -drift.y} : Eq - drift;
      Mq -= w[k].y * alongTurn + w[k].x * alongPin;
      UL[k] = mulAdd(1.0, k == 0 ? perp(mR) : tangent(j, k).momentPlace, lambda);
    }

    const Scalar stiffness = body.k + s_ * (body.d + s_ * joint.rotor);
    handle.over = joint.isHeld ? Scalar{} : 1.0 / (Dm + stiffness);
    handle.kD = joint.isHeld ? Scalar(1) : stiffness * handle.over;
    handle.UR = UR;
    handle.Eq = Eq;
    handle.Mq = Mq;
    handle.Dm = Dm;
    pass(j, UL, handle, shown);
  }

  /// From the outer pin to the inner one.
  [[gnu::always_inline]] void pass(std::size_t j, const PerMotion<Vec2<Scalar>, kinds>& UL, Handle& handle,
                                   CoupledShown<Scalar, kinds>& shown) {
    const BodyAt<double>& body = bodies_[j];
    const Vec2<Scalar> UR = handle.UR;
    const Scalar over = handle.over, kD = handle.kD, Dm = handle.Dm;
    for (std::size_t k = 0; k < kinds; ++k) {
      const Vec2<Scalar> ULD = handle.ULD[k] = over * UL[k];
      Matrix2<Scalar> B = shown.B[k];
      if (k == 0) {
        B.xx += body.m;
        B.yy += body.m;
      } else {
        const Matrix2d& T = tangent(j, k).forcePlace;
        B = {T.xx + B.xx, T.xy + B.xy, T.yx + B.yx, T.yy + B.yy};
      }
      shown.B[k] = {B.xx - UR.x * ULD.x, B.xy - UR.x * ULD.y, B.yx - UR.y * ULD.x, B.yy - UR.y * ULD.y};
      shown.p[k] = handle.p[k] = kD * UL[k];
    }
    shown.h = kD * UR;
    shown.q = handle.q = kD * Dm;
  }

  const PlaneTangent& tangent(std::size_t j, std::size_t k) const {
    return k == 1 ? tangents_[j].D : tangents_[j].K;
  }
};

template <class Scalar, std::size_t kinds>
void CoupledLinearized<Scalar, kinds>::carryInwards(const Scalar* rhoQ, const Scalar* rhoV) {
  Vec2<Scalar> b;
  Scalar r{};
  for (std::size_t j = bodies_.size(); j-- > 0;) {
    const BodyAt<double>& body = bodies_[j];
    const Coupling<double>& joint = bodies_.joint(j);
    Handle& handle = handles_[j];
    const Scalar sigma = rhoQ[j] / s_;
    const Scalar bend = j > 0 ? sigma - rhoQ[j - 1] / s_ : sigma;
    const Scalar jump = j > 0 ? rhoV[j] - rhoV[j - 1] : rhoV[j];
    const Scalar delta = joint.isHeld ? Scalar{} : joint.rotor * jump - body.k * bend;
    const Scalar epsilon = handle.Mv * rhoV[j] + handle.Mq * sigma + delta - dotMixed(perp(body.P), b) - r;
    const Scalar turn = joint.isHeld ? jump / (s_ * s_) : epsilon * handle.over;
    b = mulAdd(turn, handle.UR, mulAdd(-rhoV[j], handle.Ev, mulAdd(-sigma, handle.Eq, b)));
    r = joint.isHeld ? handle.Dm * turn - epsilon : delta - handle.kD * epsilon;
    handle.turn = turn;
    moments_[j] = r;
  }
  pinForce_ = b;
}

template <class Scalar, std::size_t kinds>
void CoupledLinearized<Scalar, kinds>::carryOutwards(const Scalar* rhoQ, const Scalar* rhoV,
                                                     PerMotion<Vec2<Scalar>, kinds> y, Scalar* u, Scalar* v) {
  Scalar parent{};
  for (std::size_t j = 0; j < bodies_.size(); ++j) {
    const BodyAt<double>& body = bodies_[j];
    const Handle& handle = handles_[j];
    const Scalar sigma = rhoQ[j] / s_;
    Scalar moment = handle.q * parent;
    parent = handle.kD * parent + handle.turn;
    for (std::size_t k = 0; k < kinds; ++k) {
      moment += dot(handle.p[k], y[k]);
      parent -= dot(handle.ULD[k], y[k]);
    }
    moments_[j] += moment;
    const auto z = turnsOf<kinds>(body, s_);
    const auto w = driftsOf<kinds>(body);
    for (std::size_t k = 0; k < kinds; ++k) {
      const Vec2<Scalar> drift =
          k == 0 ? driftOf(body, sigma, rhoV[j]) : Vec2<Scalar>{w[k].x * sigma, w[k].y * sigma};
      y[k] = mulAdd(parent, turnScale(z[k], body.P), y[k] + turnScale(drift, body.P));
    }
    u[j] = sigma + parent;
    v[j] = s_ * parent;
  }
}

}  // namespace planar_chain
