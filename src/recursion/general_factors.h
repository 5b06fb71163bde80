#pragma once

/// The factors of s·1 − J, from the tip inwards: what general_linearized.h, which has the equations, keeps of
/// a chain.

#include <array>
#include <cstddef>
#include <vector>

#include "recursion/force_tangent.h"
#include "recursion/general_bodies.h"

namespace planar_chain {

/// Numbers for k = a, v, x, or for k = a alone if no force depends on position or velocity.
template <class Value, std::size_t kinds = 3>
using PerMotion = std::array<Value, kinds>;

/// The terms of all that hangs on a pin, for its parent.
template <class Scalar, std::size_t kinds = 3>
struct LinearTerms {
  PerMotion<Matrix2<Scalar>, kinds> B{};
  PerMotion<Vec2<Scalar>, kinds> p{};
  Vec2<Scalar> h;
  Scalar q{};
};

/// Returns z_k of each k.
template <std::size_t kinds, class Scalar>
PerMotion<Vec2<Scalar>, kinds> turnsOf(const BodyAt<double>& body, Scalar s) {
  if constexpr (kinds == 1)
    return {turnOf(body, s)};
  else
    return {turnOf(body, s), Vec2<Scalar>{Scalar(-body.omega), s}, Vec2<Scalar>{Scalar(0), Scalar(1)}};
}

/// −w_k for σ = 1 and ρ_v = 0
template <std::size_t kinds>
PerMotion<Vec2d, kinds> driftsOf(const BodyAt<double>& body) {
  const Vec2d ofAcceleration{body.alpha, body.omega * body.omega};
  if constexpr (kinds == 1)
    return {ofAcceleration};
  else
    return {ofAcceleration, Vec2d{body.omega, 0}, Vec2d{0, -1}};
}

template <class Scalar>
Vec2<Scalar> wide(Vec2d a) {
  return {Scalar(a.x), Scalar(a.y)};
}

/// kinds: 3, or 1 if no force depends on position or velocity. isMixed: a joint is prismatic.
template <class Scalar, std::size_t kinds, bool isMixed>
class GeneralFactors {
 public:
  /// tangents: K and D of each body, not read if kinds = 1. holdsTip: the tip is ever held. basePays:
  /// somebody asks for the wrench of the base, which moves. All must outlive this object; factor() reads
  /// them. Allocates.
  GeneralFactors(const GeneralBodies& bodies, const ForceTangent* tangents, bool holdsTip, bool basePays)
      : bodies_(bodies),
        tangents_(tangents),
        carriages_(basePays ? 0 : index(bodies.coordinates().leading())),
        factors_(bodies.size()),
        prismaticFactors_(isMixed ? bodies.size() : 0),
        tips_(holdsTip ? bodies.size() : 0) {}

  void factor(Scalar s) {
    s_ = s;
    overS_ = 1.0 / s;
    LinearTerms<Scalar, kinds> articulated;
    for (std::size_t j = bodies_.size(); j-- > carriages_;) {
      const Sums sums = addBody(j, articulated);
      isPrismatic(j) ? passPrismatic(j, sums, articulated) : passRevolute(j, sums, articulated);
    }
    for (std::size_t j = isMixed ? carriages_ : 0; j-- > 0;) passCarriage(j, articulated);
    if (!tips_.empty()) sweepTip();
  }

 protected:
  using Motion = PerMotion<Vec2<Scalar>, kinds>;
  /// The factors of a body, and of its joint if that is revolute. over: 1/D, kD: k̂/D; 0 and 1 if the joint
  /// is prescribed. turn: ε/D, or w; of a prismatic joint ε/D, or g.
  struct BodyFactors {
    Scalar Mv, Mq, Dm, over, kD;
    Vec2<Scalar> Ev, Eq, UR;
    Motion ULD, p;
    Scalar q, turn;
  };
  /// The factors of a prismatic joint: U, V_k/D, V_k, and E and M with the terms of σ and ρ_v.
  struct PrismaticFactors {
    Vec2<Scalar> ofRate, ofPosition;        ///< b' changes with −ρ_s and σ_s
    Scalar momentOfRate, momentOfPosition;  ///< and r'
    Scalar f, v, vD, u, D0;
    Motion Z, W, z, w;
  };
  /// eD: of a joint, e or η over D. eta: behind it. g: γ, or x. Ev, Eq, ofRate, ofPosition: how c_t changes
  /// with −ρ_v, σ, −ρ_s and σ_s.
  struct AtTip {
    Vec2<Scalar> e, eD, g, Ev, Eq, ofRate, ofPosition, eta;
  };

  bool isPrismatic(std::size_t j) const { return isMixed && bodies_.isPrismatic(j); }
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

  const GeneralBodies& bodies_;
  const ForceTangent* tangents_;
  std::size_t carriages_;  ///< the first joints, prismatic, inside of which nothing turns
  Scalar s_{}, overS_{};   ///< s, 1/s
  std::vector<BodyFactors> factors_;
  std::vector<PrismaticFactors> prismaticFactors_;  ///< if a joint is prismatic
  std::vector<AtTip> tips_;                         ///< if the tip is ever held
  Matrix2<Scalar> C_, G_;                           ///< by the base

 private:
  /// The terms of a body at its own point while it turns: p_k, h, q.
  struct Sums {
    Motion UL;
  };

  void addForces(std::size_t j, LinearTerms<Scalar, kinds>& articulated) const;
  Sums addBody(std::size_t j, LinearTerms<Scalar, kinds>& articulated);
  void passRevolute(std::size_t j, const Sums& sums, LinearTerms<Scalar, kinds>& articulated);
  void passPrismatic(std::size_t j, const Sums& sums, LinearTerms<Scalar, kinds>& articulated);
  void passCarriage(std::size_t j, LinearTerms<Scalar, kinds>& articulated);
  void displace(std::size_t j, PrismaticFactors& prismatic) const;
  void sweepTip();

  const PlaneTangent& tangent(std::size_t j, std::size_t k) const {
    return k == 1 ? tangents_[j].D : tangents_[j].K;
  }
  Scalar stiffnessOf(std::size_t j) const {
    const BodyAt<double>& body = bodies_[j];
    return body.k + s_ * (body.d + s_ * bodies_.joint(j).armature);
  }
  /// Subtracts a bᵀ.
  static void subtract(Vec2<Scalar> a, Vec2<Scalar> b, Matrix2<Scalar>& M) {
    M = {M.xx - a.x * b.x, M.xy - a.x * b.y, M.yx - a.y * b.x, M.yy - a.y * b.y};
  }
};

/// Replaces what hangs on the outer pin by what the body shows at its own point: B and T, U_R as h, D_m as q.
template <class Scalar, std::size_t kinds, bool isMixed>
[[gnu::always_inline]] inline auto GeneralFactors<Scalar, kinds, isMixed>::addBody(
    std::size_t j, LinearTerms<Scalar, kinds>& articulated) -> Sums {
  const BodyAt<double>& body = bodies_[j];
  const Vec2d P = body.P, iP = perp(P), mR = body.m * body.R;
  const auto z = turnsOf<kinds>(body, s_);
  const auto less = driftsOf<kinds>(body);
  Vec2<Scalar> UR = articulated.h, Eq;
  Scalar Mq(-body.kappa), Dm = body.J * s_ * s_ + body.kappa + articulated.q + dotMixed(iP, articulated.h);
  if constexpr (kinds == 3) {
    const auto& [K, D] = tangents_[j];
    UR = mulAdd(s_, D.forceTurn, mulAdd(1.0, K.forceTurn, UR));
    Eq = {Scalar(-K.forceTurn.x), Scalar(-K.forceTurn.y)};
    Mq -= K.momentTurn;
    Dm += K.momentTurn + s_ * D.momentTurn;
  }
  BodyFactors& factors = factors_[j];
  Sums sums;
  for (std::size_t k = 0; k < kinds; ++k) {
    const Matrix2<Scalar>& B = articulated.B[k];
    const Vec2<Scalar> lambda{iP.x * B.xx + iP.y * B.yx + articulated.p[k].x,
                              iP.x * B.xy + iP.y * B.yy + articulated.p[k].y};
    const Scalar alongTurn = dotMixed(iP, lambda), alongPin = dotMixed(P, lambda);
    const Vec2d m = k == 0 ? mR : Vec2d{};
    const Vec2<Scalar> zeta = B.times(iP, {Scalar(-m.y), Scalar(m.x)});
    const Vec2<Scalar> xi = B.times(P, {Scalar(m.x), Scalar(m.y)});
    if (k == 0) {
      factors.Mv = body.J + alongTurn;
      factors.Ev = zeta;
    }
    UR = mulAdd(z[k].y, zeta, mulAdd(z[k].x, xi, UR));
    Dm += z[k].y * alongTurn + z[k].x * alongPin;
    const Vec2<Scalar> drift = mulAdd(less[k].y, zeta, Vec2<Scalar>{less[k].x * xi.x, less[k].x * xi.y});
    Eq = kinds == 1 ? drift : Eq + drift;
    Mq += less[k].y * alongTurn + less[k].x * alongPin;
    sums.UL[k] = mulAdd(1.0, k == 0 ? perp(mR) : tangent(j, k).momentShift, lambda);
  }
  factors.Eq = Eq;
  factors.Mq = Mq;
  factors.Dm = Dm;
  articulated.h = UR;
  articulated.q = Dm;
  addForces(j, articulated);
  return sums;
}

/// B ← T + B
template <class Scalar, std::size_t kinds, bool isMixed>
[[gnu::always_inline]] inline void GeneralFactors<Scalar, kinds, isMixed>::addForces(
    std::size_t j, LinearTerms<Scalar, kinds>& articulated) const {
  articulated.B[0].xx += bodies_[j].m;
  articulated.B[0].yy += bodies_[j].m;
  for (std::size_t k = 1; k < kinds; ++k) {
    const Matrix2d& T = tangent(j, k).forceShift;
    Matrix2<Scalar>& B = articulated.B[k];
    B = {T.xx + B.xx, T.xy + B.xy, T.yx + B.yx, T.yy + B.yy};
  }
}

template <class Scalar, std::size_t kinds, bool isMixed>
[[gnu::always_inline]] inline void GeneralFactors<Scalar, kinds, isMixed>::passRevolute(
    std::size_t j, const Sums& sums, LinearTerms<Scalar, kinds>& articulated) {
  BodyFactors& factors = factors_[j];
  const bool isPrescribed = bodies_.joint(j).isPrescribed;
  const Scalar stiffness = stiffnessOf(j), Dm = articulated.q;
  const Scalar over = factors.over = isPrescribed ? Scalar{} : 1.0 / (Dm + stiffness);
  const Scalar kD = factors.kD = isPrescribed ? Scalar(1) : stiffness * over;
  const Vec2<Scalar> UR = factors.UR = articulated.h;
  for (std::size_t k = 0; k < kinds; ++k) {
    const Vec2<Scalar> UL = sums.UL[k];
    factors.ULD[k] = over * UL;
    subtract(UR, factors.ULD[k], articulated.B[k]);
    articulated.p[k] = factors.p[k] = kD * UL;
  }
  articulated.h = kD * UR;
  articulated.q = factors.q = kD * Dm;
}

/// Z, W, z and w.
template <class Scalar, std::size_t kinds, bool isMixed>
void GeneralFactors<Scalar, kinds, isMixed>::displace(std::size_t j, PrismaticFactors& prismatic) const {
  const BodyAt<double>& body = bodies_[j];
  const PrismaticAt& joint = bodies_.prismatic(j);
  const double omega = body.omega, ww = omega * omega, alpha = body.alpha;
  const Vec2d d = joint.axis, id = perp(d), S = joint.S, iS = perp(S), moved = joint.rate * id - omega * S;
  const auto set = [](Motion& to, const Vec2d& a, const Vec2d& v, const Vec2d& x) {
    to[0] = wide<Scalar>(a);
    if constexpr (kinds == 3) {
      to[1] = wide<Scalar>(v);
      to[2] = wide<Scalar>(x);
    }
  };
  set(prismatic.W, joint.acceleration * id - (2 * omega * joint.rate) * d - ww * iS - alpha * S, moved, iS);
  set(prismatic.w, alpha * id - ww * d, omega * id, d);
  prismatic.Z = prismatic.W;
  prismatic.z = prismatic.w;
  const Scalar ss = s_ * s_, twice = s_ + s_;
  prismatic.Z[0] += mulAdd(ss, iS, mulAdd(twice, moved, Vec2<Scalar>{}));
  prismatic.z[0] += mulAdd(ss, d, mulAdd(twice * omega, id, Vec2<Scalar>{}));
  if constexpr (kinds == 3) {
    prismatic.Z[1] = mulAdd(s_, iS, prismatic.Z[1]);
    prismatic.z[1] = mulAdd(s_, d, prismatic.z[1]);
  }
}

template <class Scalar, std::size_t kinds, bool isMixed>
void GeneralFactors<Scalar, kinds, isMixed>::passPrismatic(std::size_t j, const Sums& sums,
                                                           LinearTerms<Scalar, kinds>& articulated) {
  const PrismaticAt& joint = bodies_.prismatic(j);
  BodyFactors& factors = factors_[j];
  PrismaticFactors& prismatic = prismaticFactors_[j];
  displace(j, prismatic);
  const Motion& p = sums.UL;
  const auto& B = articulated.B;
  const Vec2d d = joint.axis, iS = perp(joint.S);
  const Vec2<Scalar> wideD = wide<Scalar>(d), wideS = wide<Scalar>(iS);
  const double alongS = dot(joint.S, joint.force);
  prismatic.f = Scalar(dot(perp(d), joint.force));

  const Vec2<Scalar> U = sum(B, prismatic.z), h = articulated.h + sum(B, prismatic.Z);
  prismatic.v = dotMixed(d, h) + prismatic.f;
  prismatic.u = sum(p, prismatic.z) + prismatic.f + dotMixed(iS, U);
  prismatic.D0 = dotMixed(d, U);
  const Scalar q = articulated.q + sum(p, prismatic.Z) - alongS + dotMixed(iS, h);

  // Right-hand sides.
  factors.Ev += B[0].times(iS, Vec2<Scalar>{});
  factors.Eq = factors.Eq - sum(B, prismatic.W);
  factors.Mv += dot(p[0], wideS);
  factors.Mq -= sum(p, prismatic.W) - alongS;
  prismatic.ofRate = B[0].times(d, Vec2<Scalar>{});
  prismatic.ofPosition = sum(B, prismatic.w);
  prismatic.momentOfRate = dot(p[0], wideD);
  prismatic.momentOfPosition = sum(p, prismatic.w) + prismatic.f;

  const bool isPrescribed = bodies_.joint(j).isPrescribed;
  const Scalar over = factors.over = isPrescribed ? Scalar{} : 1.0 / (prismatic.D0 + stiffnessOf(j));
  prismatic.vD = over * prismatic.v;
  factors.UR = U;
  for (std::size_t k = 0; k < kinds; ++k) {
    const Vec2<Scalar> V = factors.p[k] = transposedTimes(B[k], wideD), VD = factors.ULD[k] = over * V;
    articulated.p[k] = p[k] + transposedTimes(B[k], wideS) - prismatic.u * VD;
    subtract(U, VD, articulated.B[k]);
  }
  articulated.h = h - prismatic.vD * U;
  articulated.q = q - prismatic.u * prismatic.vD;
}

/// The body with it, where nothing inside turns: σ, ρ_v and u' there are 0, so only B and V are of use.
template <class Scalar, std::size_t kinds, bool isMixed>
void GeneralFactors<Scalar, kinds, isMixed>::passCarriage(std::size_t j,
                                                          LinearTerms<Scalar, kinds>& articulated) {
  addForces(j, articulated);
  BodyFactors& factors = factors_[j];
  PrismaticFactors& prismatic = prismaticFactors_[j];
  auto& B = articulated.B;
  const Vec2d d = bodies_.prismatic(j).axis;
  const Vec2<Scalar> wideD = wide<Scalar>(d);
  prismatic.ofRate = B[0].times(d, Vec2<Scalar>{});
  prismatic.z[0] = s_ * s_ * wideD;
  if constexpr (kinds == 3) {
    prismatic.z[1] = s_ * wideD;
    prismatic.z[2] = prismatic.w[2] = wideD;
    prismatic.ofPosition = B[2].times(d, Vec2<Scalar>{});
  }
  factors.UR = sum(B, prismatic.z);
  prismatic.D0 = dotMixed(d, factors.UR);
  const bool isPrescribed = bodies_.joint(j).isPrescribed;
  const Scalar over = factors.over = isPrescribed ? Scalar{} : 1.0 / (prismatic.D0 + stiffnessOf(j));
  for (std::size_t k = 0; k < kinds; ++k) {
    const Vec2<Scalar> V = factors.p[k] = transposedTimes(B[k], wideD);
    factors.ULD[k] = over * V;
    subtract(factors.UR, factors.ULD[k], B[k]);
  }
}

template <class Scalar, std::size_t kinds, bool isMixed>
void GeneralFactors<Scalar, kinds, isMixed>::sweepTip() {
  C_ = {};
  Matrix2<Scalar> G;
  G.xx = G.yy = Scalar(1);
  PerMotion<Matrix2<Scalar>, kinds> Gamma{};
  Gamma[0] = G;
  Vec2<Scalar> eta, gamma;
  for (std::size_t j = tips_.size(); j-- > 0;) {
    const BodyAt<double>& body = bodies_[j];
    const BodyFactors& factors = factors_[j];
    AtTip& at = tips_[j];
    const auto z = turnsOf<kinds>(body, s_);
    const auto less = driftsOf<kinds>(body);
    eta += transposedTimes(G, wide<Scalar>(perp(body.P)));
    at.Ev = Gamma[0].times(perp(body.P), Vec2<Scalar>{});
    at.Eq = {};
    for (std::size_t k = 0; k < kinds; ++k) {
      gamma += Gamma[k].times(turnScale(z[k], body.P), Vec2<Scalar>{});
      at.Eq -= Gamma[k].times(turnScale(less[k], body.P), Vec2<Scalar>{});
    }
    if (isPrismatic(j)) {
      const PrismaticFactors& prismatic = prismaticFactors_[j];
      const Vec2d d = bodies_.prismatic(j).axis, iS = perp(bodies_.prismatic(j).S);
      at.e = transposedTimes(G, wide<Scalar>(d));
      at.g = sum(Gamma, prismatic.z);
      at.Ev += Gamma[0].times(iS, Vec2<Scalar>{});
      at.Eq += sum(Gamma, prismatic.W);
      at.ofRate = Gamma[0].times(d, Vec2<Scalar>{});
      at.ofPosition = sum(Gamma, prismatic.w);
      at.eD = factors.over * at.e;
      eta += transposedTimes(G, wide<Scalar>(iS)) - prismatic.u * at.eD;
      gamma += sum(Gamma, prismatic.Z) - prismatic.vD * at.g;
    } else {
      at.e = eta;
      at.g = gamma;
      at.eD = factors.over * eta;
      eta = factors.kD * eta;
      gamma = factors.kD * gamma;
    }
    at.eta = eta;
    for (std::size_t k = 0; k < kinds; ++k) subtract(at.g, factors.ULD[k], Gamma[k]);
    subtract(Scalar(-1) * at.g, at.eD, C_);
    subtract(factors.UR, at.eD, G);
  }
  G_ = G;
}

}  // namespace planar_chain
