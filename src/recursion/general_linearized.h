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
/// Forces may depend on the position and velocity of their bodies: each body then has K and D of
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
/// its outer pin, and t_k in the row of moments:
///
///     T_a = m 1     T_v = D_xx     T_x = K_xx          t_a = m iR     t_v = D_θx     t_x = K_θx
///
/// As in linearized.h, inwards from zeros at the tip:
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
/// own point. There B, p = U_L, h = U_R, q = D_m, b and r = −ε of the body, with T_k, are known. With
/// f = id·F:
///
///     U = Σ B_k z_k                     V_k = B_kᵀ d                      p'_k = p_k + B_kᵀ iS
///     h' = h + Σ B_k Z_k                v = d·h' + f                      D = d·U + k̂
///     u = Σ p_k·z_k + f + iS·U          q' = q + Σ p_k·Z_k − S·F + iS·h'
///     b' = b + Σ B_k (…)                r' = r + Σ p_k·(…) + f σ_s − S·F σ + iS·b'
///     ε = J ρ_s − k σ_s − d·b' − f σ    g = (ε − Σ V_k·y_k − v u')/D, or ρ_s/s² of a prescribed joint
///
///     B_k ← B_k − U V_kᵀ/D              p_k ← p'_k − u V_k/D              b ← b' + U (ε/D, or g)
///     h ← h' − U v/D                    q ← q' − u v/D                    r ← r' + u (ε/D, or g)
///
/// where (…) is how y_k moves, but for u' and g.
///
/// The tip. A change δλ of its force is linear in all that is shown, and so is the acceleration of the tip;
/// beside the terms without δλ,
///
///     δF_pin = … − G δλ          δμ = … − η·δλ          δa_tip = Σ Γ_k y_k + γ u'_parent + C δλ + c_t
///
/// The change is not symmetric, so (G, η) and (Γ, γ) are two pairs. Inwards from G = Γ_a = 1 and zeros,
///
///     body          η ← η + Gᵀ iP        γ ← γ + Σ Γ_k z_k P        c_t ← c_t + Σ Γ_k w_k P
///     revolute      C ← C + γ ηᵀ/D       G ← G − U_R ηᵀ/D           Γ_k ← Γ_k − γ U_L,kᵀ/D
///                   η ← k̂ η/D            γ ← k̂ γ/D                  c_t ← c_t + γ (ε/D, or w)
///     prismatic     e = Gᵀ d             x = Σ Γ_k z_k              c_t ← c_t + Σ Γ_k (…) + x (ε/D, or g)
///                   C ← C + x eᵀ/D       G ← G − U eᵀ/D             Γ_k ← Γ_k − x V_kᵀ/D
///                   η ← η + Gᵀ iS − u e/D                           γ ← γ + Σ Γ_k Z_k − x v/D
///
/// and c_j·δa_tip = 0 along the rows that act gives δλ. The rows do not change with the state.
///
/// Source: derived as in linearized.h. Against Newton's and Euler's equations: general_linearized_test.

#include <Eigen/LU>
#include <memory>
#include <type_traits>
#include <vector>

#include "recursion/general_factors.h"
#include "recursion/general_solve.h"

namespace planar_chain {

/// See GeneralFactors.
template <class Scalar, std::size_t kinds, bool isMixed>
class GeneralLinearized final : public GeneralSolve<Scalar>, private GeneralFactors<Scalar, kinds, isMixed> {
 public:
  using Factors = GeneralFactors<Scalar, kinds, isMixed>;
  using Factors::Factors;

  void factor(Scalar s) override { Factors::factor(s); }
  void solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) override {
    carryInwards(rhoQ, rhoV);
    if (!tips_.empty()) hold(rhoQ, rhoV);
    carryOutwards(rhoQ, rhoV, u, v);
  }
  Scalar moment(int i) const override { return moments_[index(i)]; }
  Vec2<Scalar> baseForce() const override { return baseForce_; }
  Scalar baseMoment() const override { return baseMoment_; }
  Vec2<Scalar> tipForce() const override { return tipForce_; }

 private:
  using Factors::bodies_;
  using Factors::C_;
  using Factors::factors_;
  using Factors::G_;
  using Factors::isPrismatic;
  using Factors::overS_;
  using Factors::prismaticFactors_;
  using Factors::s_;
  using Factors::sum;
  using Factors::tips_;
  using typename Factors::AtTip;
  using typename Factors::BodyFactors;
  using typename Factors::Motion;
  using typename Factors::PrismaticFactors;

  void carryInwards(const Scalar* rhoQ, const Scalar* rhoV);
  void carryOutwards(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v);
  void hold(const Scalar* rhoQ, const Scalar* rhoV);
  Vec2<Scalar> tipFree(const Scalar* rhoQ, const Scalar* rhoV) const;

  /// The coordinate of the angle inside of joint j, and the one that is the angle of body j; or none.
  int inner(std::size_t j) const {
    const int i = static_cast<int>(j);
    return isMixed ? bodies_.coordinates().inner(i) : i - 1;
  }
  /// σ or ρ_v of the body, by that of its coordinate; 0 of one that turns with the base.
  Scalar ofBody(const Scalar* values, std::size_t j) const {
    if constexpr (!isMixed) return values[j];
    const int turner = bodies_.coordinates().turner(static_cast<int>(j));
    return turner >= 0 ? values[turner] : Scalar{};
  }

  std::vector<Scalar> moments_ = std::vector<Scalar>(factors_.size());
  // Along the last solution:
  Vec2<Scalar> baseForce_, tipForce_;
  Scalar baseMoment_{};
};

template <class Scalar, std::size_t kinds, bool isMixed>
void GeneralLinearized<Scalar, kinds, isMixed>::carryInwards(const Scalar* rhoQ, const Scalar* rhoV) {
  Vec2<Scalar> b;
  Scalar r{};
  for (std::size_t j = bodies_.size(); j-- > 0;) {
    const BodyAt<double>& body = bodies_[j];
    const JointLaw<double>& joint = bodies_.joint(j);
    BodyFactors& factors = factors_[j];
    const Scalar sigma = ofBody(rhoQ, j) * overS_, rho = ofBody(rhoV, j);
    const Scalar known = factors.Mv * rho + factors.Mq * sigma - dotMixed(perp(body.P), b) - r;
    b = mulAdd(-rho, factors.Ev, mulAdd(-sigma, factors.Eq, b));
    if (!isPrismatic(j)) {
      const int parent = inner(j);
      const Scalar relative = parent >= 0 ? sigma - rhoQ[parent] * overS_ : sigma;
      const Scalar jump = parent >= 0 ? rho - rhoV[parent] : rho;
      const Scalar delta = joint.isPrescribed ? Scalar{} : joint.armature * jump - body.k * relative;
      const Scalar epsilon = known + delta;
      const Scalar turn = factors.turn =
          joint.isPrescribed ? jump * (overS_ * overS_) : epsilon * factors.over;
      b = mulAdd(turn, factors.UR, b);
      moments_[j] = r = joint.isPrescribed ? factors.Dm * turn - epsilon : delta - factors.kD * epsilon;
      continue;
    }
    const PrismaticFactors& prismatic = prismaticFactors_[j];
    const Scalar position = rhoQ[j] * overS_, rate = rhoV[j];
    b = mulAdd(-rate, prismatic.ofRate, mulAdd(position, prismatic.ofPosition, b));
    r = prismatic.momentOfPosition * position - known - prismatic.momentOfRate * rate +
        dotMixed(perp(bodies_.prismatic(j).S), b);
    const Scalar delta = joint.isPrescribed ? Scalar{} : joint.armature * rate - body.k * position;
    const Scalar epsilon = delta - dotMixed(bodies_.prismatic(j).axis, b) - prismatic.f * sigma;
    const Scalar turn = factors.turn = joint.isPrescribed ? rate * (overS_ * overS_) : epsilon * factors.over;
    b = mulAdd(turn, factors.UR, b);
    r += prismatic.u * turn;
    moments_[j] = prismatic.D0 * turn - epsilon;
  }
  baseForce_ = b;
  baseMoment_ = r;
}

template <class Scalar, std::size_t kinds, bool isMixed>
void GeneralLinearized<Scalar, kinds, isMixed>::carryOutwards(const Scalar* rhoQ, const Scalar* rhoV,
                                                              Scalar* u, Scalar* v) {
  Motion y{};
  Scalar parent{}, sigma{}, rho{};  // u', σ and ρ_v of the body that turns
  for (std::size_t j = 0; j < bodies_.size(); ++j) {
    const BodyAt<double>& body = bodies_[j];
    const BodyFactors& factors = factors_[j];
    Scalar own, rate = rhoV[j];  // u' and ρ_v of the coordinate
    if (isPrismatic(j)) {
      const PrismaticFactors& prismatic = prismaticFactors_[j];
      const Scalar position = rhoQ[j] * overS_;
      moments_[j] += prismatic.v * parent + sum(factors.p, y);
      own = factors.turn - prismatic.vD * parent - sum(factors.ULD, y);
      for (std::size_t k = 0; k < kinds; ++k) {
        y[k] += mulAdd(parent, prismatic.Z[k],
                       mulAdd(sigma, prismatic.W[k], mulAdd(own, prismatic.z[k], position * prismatic.w[k])));
      }
      y[0] -=
          mulAdd(rho, perp(bodies_.prismatic(j).S), mulAdd(rate, bodies_.prismatic(j).axis, Vec2<Scalar>{}));
      u[j] = position + own;
    } else {
      sigma = rhoQ[j] * overS_;
      rho = rate;
      moments_[j] += factors.q * parent + sum(factors.p, y);
      parent = factors.kD * parent + factors.turn - sum(factors.ULD, y);
      own = parent;
      u[j] = sigma + own;
    }
    const auto z = turnsOf<kinds>(body, s_);
    const auto less = driftsOf<kinds>(body);
    for (std::size_t k = 0; k < kinds; ++k) {
      const Vec2<Scalar> drift =
          k == 0 ? driftOf(body, sigma, rho) : Vec2<Scalar>{-(less[k].x * sigma), -(less[k].y * sigma)};
      y[k] = mulAdd(parent, turnScale(z[k], body.P), y[k] + turnScale(drift, body.P));
    }
    v[j] = s_ * own;
  }
}

/// Returns c_t at these right-hand sides.
template <class Scalar, std::size_t kinds, bool isMixed>
Vec2<Scalar> GeneralLinearized<Scalar, kinds, isMixed>::tipFree(const Scalar* rhoQ,
                                                                const Scalar* rhoV) const {
  Vec2<Scalar> free, ofPositions;  // ofPositions: times s
  for (std::size_t j = 0; j < tips_.size(); ++j) {
    const AtTip& at = tips_[j];
    free = mulAdd(factors_[j].turn, at.g, mulAdd(-ofBody(rhoV, j), at.Ev, free));
    ofPositions = mulAdd(ofBody(rhoQ, j), at.Eq, ofPositions);
    if (!isPrismatic(j)) continue;
    free = mulAdd(-rhoV[j], at.ofRate, free);
    ofPositions = mulAdd(rhoQ[j], at.ofPosition, ofPositions);
  }
  return mulAdd(overS_, ofPositions, free);
}

/// Finds δλ, and adds what it changes.
template <class Scalar, std::size_t kinds, bool isMixed>
void GeneralLinearized<Scalar, kinds, isMixed>::hold(const Scalar* rhoQ, const Scalar* rhoV) {
  const Tip<double>& tip = bodies_.tip();
  tipForce_ = {};
  if (tip.rows == 0) return;
  const Vec2<Scalar> free = tipFree(rhoQ, rhoV);
  const Vec2d c1 = tip.row[0];
  const auto along = [&](Vec2d row, Vec2d force) { return dotMixed(row, C_.times(force, Vec2<Scalar>{})); };
  if (tip.rows == 1) {
    tipForce_ = (-dotMixed(c1, free) / along(c1, c1)) * wide<Scalar>(c1);
  } else {
    Eigen::Matrix<Scalar, 2, 2> C;
    C << C_.xx, C_.xy, C_.yx, C_.yy;
    const Eigen::Matrix<Scalar, 2, 1> force =
        C.partialPivLu().solve(Eigen::Matrix<Scalar, 2, 1>(-free.x, -free.y));
    tipForce_ = {force[0], force[1]};
  }
  for (std::size_t j = 0; j < tips_.size(); ++j) {
    const AtTip& at = tips_[j];
    factors_[j].turn += dot(at.eD, tipForce_);
    moments_[j] -= dot(isPrismatic(j) ? at.e : at.eta, tipForce_);
  }
  baseForce_ -= G_.times(tipForce_, Vec2<Scalar>{});
  baseMoment_ -= dot(tips_.front().eta, tipForce_);
}

/// The solve for these bodies. tangents: nullptr if no force depends on position or velocity.
template <class Scalar>
std::unique_ptr<GeneralSolve<Scalar>> makeGeneralSolve(const GeneralBodies& bodies,
                                                       const ForceTangent* tangents, bool holdsTip,
                                                       bool basePays) {
  const auto make = [&](auto kinds, auto isMixed) -> std::unique_ptr<GeneralSolve<Scalar>> {
    return std::make_unique<GeneralLinearized<Scalar, kinds(), isMixed()>>(bodies, tangents, holdsTip,
                                                                           basePays);
  };
  const auto makeOf = [&](auto kinds) {
    return bodies.coordinates().anyIsPrismatic() ? make(kinds, std::true_type())
                                                 : make(kinds, std::false_type());
  };
  return tangents ? makeOf(std::integral_constant<std::size_t, 3>())
                  : makeOf(std::integral_constant<std::size_t, 1>());
}

}  // namespace planar_chain
