#pragma once

/// The exact linear solve of linearized.h for a chain with joints of any kind (general.h). The armature of a
/// joint is one more term of its spring, and a prescribed joint is the limit of that:
///
///     armature      k̂ = k + s d + s² J         δ also + J (ρ_v,i − ρ_v,inner)
///     prescribed    k̂ → ∞:   B ← T + B     h ← U_R     p ← U_L     q ← D_m
///                   u' = u'_parent + w     w = (ρ_v,i − ρ_v,inner)/s²
///                   b ← b − E_v ρ_v − E_q σ + U_R w     r ← D_m w − ε
///
/// The force of the base changes by b of the first body, its moment about the ground pin by r. They and the
/// moments of prescribed joints, δμ = q u'_parent + Σ p_k·y_k + r, give the changes of the powers.
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
/// A prismatic joint. Its body turns with the one inside, by σ + u' with ρ_v, and slides by σ_s + g with ρ_s,
/// along d, at S, at the rate ṡ. From the pin inside to the own point of the body, y_k moves by
///
///     Z_k u' + W_k σ + z_k g + w_k σ_s          and for k = a also by −iS ρ_v − d ρ_s
///
///     W_a = s̈ id − 2 ω ṡ d − ω² iS − α S        W_v = ṡ id − ω S       W_x = iS
///     Z_a = s² iS + 2 s (ṡ id − ω S) + W_a      Z_v = s iS + W_v       Z_x = iS
///     w_a = α id − ω² d                         w_v = ω id             w_x = d
///     z_a = s² d + 2 ω s id + w_a               z_v = s d + w_v        z_x = d
///
/// The force along the axis is given: δ(d·F) = −k (σ_s + g) − s d g − J (s² g − ρ_s), with F the force at the
/// own point. There B, p = U_L, h = U_R, q = D_m, b and r = −ε of the body, with T_k, are known. With f =
/// id·F:
///
///     U = Σ B_k z_k          V_k = B_kᵀ d          h' = h + Σ B_k Z_k          v = d·h' + f          D = d·U
///     + k̂ u = Σ p_k·z_k + f + iS·U          q' = q + Σ p_k·Z_k − S·F + iS·h'          p'_k = p_k + B_kᵀ iS
///     b' = b + Σ B_k (…)          r' = r + Σ p_k·(…) + f σ_s − S·F σ + iS·b'          (…): but for u' and g
///     ε = J ρ_s − k σ_s − d·b' − f σ          g = (ε − Σ V_k·y_k − v u')/D, or ρ_s/s² of a prescribed joint
///     B_k ← B_k − U V_kᵀ/D     h ← h' − U v/D     p_k ← p'_k − u V_k/D     q ← q' − u v/D
///     b ← b' + U (ε/D, or g)   r ← r' + u (ε/D, or g)
///
/// The tip. A change δλ of its force is linear in all that is shown, and so is the acceleration of the tip;
/// beside the terms without δλ,
///
///     δF_pin = … − G δλ          δμ = … − η·δλ          δa_tip = Σ Γ_k y_k + γ u'_parent + C δλ + c_t
///
/// The change is not symmetric, so (G, η) and (Γ, γ) are two pairs. Inwards from G = Γ_a = 1 and zeros,
///
///     body          η ← η + Gᵀ iP        γ ← γ + Σ Γ_k z_k P        c_t ← c_t + Σ Γ_k w_k P
///     revolute      C ← C + γ ηᵀ/D       c_t ← c_t + γ (ε/D, or w)
///                   G ← G − U_R ηᵀ/D     Γ_k ← Γ_k − γ U_L,kᵀ/D     η ← k̂ η/D              γ ← k̂ γ/D
///     prismatic     e = Gᵀ d             x = Σ Γ_k z_k              C ← C + x eᵀ/D
///                   η ← η + Gᵀ iS − u e/D                           γ ← γ + Σ Γ_k Z_k − x v/D
///                   c_t ← c_t + Σ Γ_k (…) + x (ε/D, or g)           G ← G − U eᵀ/D         Γ_k ← Γ_k − x
///                   V_kᵀ/D
///
/// and c_j·δa_tip = 0 along the rows that act gives δλ. The rows do not change with the state.
///
/// Source: derived as in linearized.h. Against Newton's and Euler's equations: general_linearized_test.

#include <Eigen/LU>
#include <array>
#include <cstddef>
#include <vector>

#include "recursion/force_tangent.h"
#include "recursion/general_bodies.h"

namespace planar_chain {

/// Numbers for k = a, v, x, or for k = a alone if no force depends on place or velocity.
template <class Value, std::size_t kinds = 3>
using PerMotion = std::array<Value, kinds>;

/// What hangs on a pin, as its parent feels it.
template <class Scalar, std::size_t kinds = 3>
struct LinearTerms {
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

template <class Scalar>
Vec2<Scalar> wide(Vec2d a) {
  return {Scalar(a.x), Scalar(a.y)};
}

/// The solve, as the stiff methods see it. Only constructors allocate.
template <class Scalar>
class GeneralSolve {
 public:
  virtual ~GeneralSolve() = default;
  /// Factors s·1 − J.
  virtual void factor(Scalar s) = 0;
  /// [u; v] = (s·1 − J)⁻¹ [ρ_q; ρ_v]; n values each, and the results may stand in the same place.
  virtual void solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) = 0;

  // The changes along the last solution: of the moment or force in prescribed joint i, of the force of the
  // base and its moment about the ground pin, and of the force on the tip.
  virtual Scalar moment(int i) const = 0;
  virtual Vec2<Scalar> baseForce() const = 0;
  virtual Scalar baseMoment() const = 0;
  virtual Vec2<Scalar> tipForce() const = 0;
};

/// kinds: 3, or 1 if no force depends on place or velocity.
template <class Scalar, std::size_t kinds>
class GeneralLinearized : public GeneralSolve<Scalar> {
 public:
  /// tangents: K and D of each body, not read if kinds = 1. holdsTip: the tip is ever held. All must outlive
  /// this object; factor() reads them.
  GeneralLinearized(const GeneralBodies& bodies, const ForceTangent* tangents, bool holdsTip)
      : bodies_(bodies),
        tangents_(tangents),
        holdsTip_(holdsTip),
        handles_(bodies.size()),
        moments_(bodies.size()) {
    if (bodies.coordinates().anyIsPrismatic()) slid_.resize(bodies.size());
    if (holdsTip) tips_.resize(bodies.size());
  }

  void factor(Scalar s) override {
    s_ = s;
    LinearTerms<Scalar, kinds> shown;
    for (std::size_t j = bodies_.size(); j-- > 0;) {
      const Sums sums = addBody(j, shown);
      bodies_.isPrismatic(j) ? passPrismatic(j, sums, shown) : passRevolute(j, sums, shown);
    }
    if (holdsTip_) sweepTip();
  }

  void solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) override {
    carryInwards(rhoQ, rhoV);
    if (holdsTip_) hold();
    carryOutwards(rhoQ, rhoV, u, v);
  }
  Scalar moment(int i) const override { return moments_[index(i)]; }
  Vec2<Scalar> baseForce() const override { return baseForce_; }
  Scalar baseMoment() const override { return baseMoment_; }
  Vec2<Scalar> tipForce() const override { return tipForce_; }

 private:
  using Motion = PerMotion<Vec2<Scalar>, kinds>;
  /// Of a body, and its joint if it is revolute. over: 1/D, kD: k̂/D; 0 and 1 if the joint is prescribed.
  /// turn: ε/D, or w; of a prismatic joint ε/D, or g.
  struct Handle {
    Scalar Mv, Mq, Dm, over, kD;
    Vec2<Scalar> Ev, Eq, UR;
    Motion ULD, p;
    Scalar q, turn;
  };
  /// Of a prismatic joint. The handle has U, V_k/D, V_k, and E and M with the terms of σ and ρ_v.
  struct Slid {
    Vec2<Scalar> ofRate, ofPlace;        ///< b' changes with −ρ_s and σ_s
    Scalar momentOfRate, momentOfPlace;  ///< and r'
    Scalar f, v, vD, u, D0;
    Motion Z, W, z, w;
  };
  /// What a body shows at its own point while it turns: p_k, h, q.
  struct Sums {
    Motion UL;
  };
  /// eD: of a joint, e or η over D. eta: behind it. g: γ, or x. Ev, Eq, ofRate, ofPlace: how c_t changes with
  /// −ρ_v, σ, −ρ_s and σ_s.
  struct AtTip {
    Vec2<Scalar> e, eD, g, Ev, Eq, ofRate, ofPlace, eta;
  };

  Sums addBody(std::size_t j, LinearTerms<Scalar, kinds>& shown);
  void passRevolute(std::size_t j, const Sums& sums, LinearTerms<Scalar, kinds>& shown);
  void passPrismatic(std::size_t j, const Sums& sums, LinearTerms<Scalar, kinds>& shown);
  void displace(std::size_t j, Slid& slid) const;
  void carryInwards(const Scalar* rhoQ, const Scalar* rhoV);
  void carryOutwards(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v);
  void sweepTip();
  void hold();

  /// σ or ρ_v of the body, by that of its coordinate; 0 of one that turns with the base.
  Scalar ofBody(const Scalar* values, std::size_t j) const {
    const int turner = bodies_.coordinates().turner(static_cast<int>(j));
    return turner >= 0 ? values[turner] : Scalar{};
  }
  const PlaneTangent& tangent(std::size_t j, std::size_t k) const {
    return k == 1 ? tangents_[j].D : tangents_[j].K;
  }
  Scalar stiffnessOf(std::size_t j) const {
    const GeneralBody& body = bodies_[j];
    return body.k + s_ * (body.d + s_ * bodies_.joint(j).armature);
  }
  static Vec2<Scalar> sum(const PerMotion<Matrix2<Scalar>, kinds>& M, const Motion& y) {
    Vec2<Scalar> total;
    for (std::size_t k = 0; k < kinds; ++k) total += M[k].times(y[k], Vec2<Scalar>{});
    return total;
  }
  static Scalar sum(const Motion& p, const Motion& y) {
    Scalar total{};
    for (std::size_t k = 0; k < kinds; ++k) total += dot(p[k], y[k]);
    return total;
  }
  /// Subtracts a bᵀ.
  static void subtract(Vec2<Scalar> a, Vec2<Scalar> b, Matrix2<Scalar>& M) {
    M = {M.xx - a.x * b.x, M.xy - a.x * b.y, M.yx - a.y * b.x, M.yy - a.y * b.y};
  }

  const GeneralBodies& bodies_;
  const ForceTangent* tangents_;
  bool holdsTip_;
  Scalar s_{};
  std::vector<Handle> handles_;
  std::vector<Slid> slid_;
  std::vector<AtTip> tips_;
  Matrix2<Scalar> C_, G_;  ///< by the base
  std::vector<Scalar> moments_;
  // Along the last solution:
  Vec2<Scalar> baseForce_, tipFree_, tipForce_;
  Scalar baseMoment_{};
};

}  // namespace planar_chain

#include "recursion/general_factors.h"
#include "recursion/general_sides.h"
