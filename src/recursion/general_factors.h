#pragma once

/// The factors of s·1 − J, from the tip inwards. Part of general_linearized.h, which has the equations.

#include "recursion/general_linearized.h"

namespace planar_chain {

/// Replaces what hangs on the outer pin by what the body shows at its own point: B and T, U_R as h, D_m as q.
template <class Scalar, std::size_t kinds>
[[gnu::always_inline]] inline auto GeneralLinearized<Scalar, kinds>::addBody(
    std::size_t j, LinearTerms<Scalar, kinds>& shown) -> Sums {
  const GeneralBody& body = bodies_[j];
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
  Sums sums;
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
    sums.UL[k] = mulAdd(1.0, k == 0 ? perp(mR) : tangent(j, k).momentPlace, lambda);
  }
  handle.Eq = Eq;
  handle.Mq = Mq;
  handle.Dm = Dm;
  shown.h = UR;
  shown.q = Dm;
  shown.B[0].xx += body.m;
  shown.B[0].yy += body.m;
  for (std::size_t k = 1; k < kinds; ++k) {
    const Matrix2d& T = tangent(j, k).forcePlace;
    Matrix2<Scalar>& B = shown.B[k];
    B = {T.xx + B.xx, T.xy + B.xy, T.yx + B.yx, T.yy + B.yy};
  }
  return sums;
}

template <class Scalar, std::size_t kinds>
[[gnu::always_inline]] inline void GeneralLinearized<Scalar, kinds>::passRevolute(
    std::size_t j, const Sums& sums, LinearTerms<Scalar, kinds>& shown) {
  Handle& handle = handles_[j];
  const bool isPrescribed = bodies_.joint(j).isPrescribed;
  const Scalar stiffness = stiffnessOf(j), Dm = shown.q;
  const Scalar over = handle.over = isPrescribed ? Scalar{} : 1.0 / (Dm + stiffness);
  const Scalar kD = handle.kD = isPrescribed ? Scalar(1) : stiffness * over;
  const Vec2<Scalar> UR = handle.UR = shown.h;
  for (std::size_t k = 0; k < kinds; ++k) {
    const Vec2<Scalar> UL = sums.UL[k];
    handle.ULD[k] = over * UL;
    subtract(UR, handle.ULD[k], shown.B[k]);
    shown.p[k] = handle.p[k] = kD * UL;
  }
  shown.h = kD * UR;
  shown.q = handle.q = kD * Dm;
}

/// Z, W, z and w.
template <class Scalar, std::size_t kinds>
void GeneralLinearized<Scalar, kinds>::displace(std::size_t j, Slid& slid) const {
  const GeneralBody& body = bodies_[j];
  const double omega = body.omega, ww = omega * omega, alpha = body.alpha;
  const Vec2d d = body.axis, id = perp(d), S = body.S, iS = perp(S), moved = body.rate * id - omega * S;
  const auto set = [](Motion& to, const Vec2d& a, const Vec2d& v, const Vec2d& x) {
    to[0] = wide<Scalar>(a);
    if constexpr (kinds == 3) {
      to[1] = wide<Scalar>(v);
      to[2] = wide<Scalar>(x);
    }
  };
  set(slid.W, body.acceleration * id - (2 * omega * body.rate) * d - ww * iS - alpha * S, moved, iS);
  set(slid.w, alpha * id - ww * d, omega * id, d);
  slid.Z = slid.W;
  slid.z = slid.w;
  const Scalar ss = s_ * s_, twice = s_ + s_;
  slid.Z[0] += mulAdd(ss, iS, mulAdd(twice, moved, Vec2<Scalar>{}));
  slid.z[0] += mulAdd(ss, d, mulAdd(twice * omega, id, Vec2<Scalar>{}));
  if constexpr (kinds == 3) {
    slid.Z[1] = mulAdd(s_, iS, slid.Z[1]);
    slid.z[1] = mulAdd(s_, d, slid.z[1]);
  }
}

template <class Scalar, std::size_t kinds>
void GeneralLinearized<Scalar, kinds>::passPrismatic(std::size_t j, const Sums& sums,
                                                     LinearTerms<Scalar, kinds>& shown) {
  const GeneralBody& body = bodies_[j];
  Handle& handle = handles_[j];
  Slid& slid = slid_[j];
  displace(j, slid);
  const Motion& p = sums.UL;
  const auto& B = shown.B;
  const Vec2d d = body.axis, iS = perp(body.S);
  const Vec2<Scalar> wideD = wide<Scalar>(d), wideS = wide<Scalar>(iS);
  const double alongS = dot(body.S, body.force);
  slid.f = Scalar(dot(perp(d), body.force));

  const Vec2<Scalar> U = sum(B, slid.z), h = shown.h + sum(B, slid.Z);
  slid.v = dotMixed(d, h) + slid.f;
  slid.u = sum(p, slid.z) + slid.f + dotMixed(iS, U);
  slid.D0 = dotMixed(d, U);
  const Scalar q = shown.q + sum(p, slid.Z) - alongS + dotMixed(iS, h);

  // Right-hand sides.
  handle.Ev += B[0].times(iS, Vec2<Scalar>{});
  handle.Eq = handle.Eq - sum(B, slid.W);
  handle.Mv += dot(p[0], wideS);
  handle.Mq -= sum(p, slid.W) - alongS;
  slid.ofRate = B[0].times(d, Vec2<Scalar>{});
  slid.ofPlace = sum(B, slid.w);
  slid.momentOfRate = dot(p[0], wideD);
  slid.momentOfPlace = sum(p, slid.w) + slid.f;

  const bool isPrescribed = bodies_.joint(j).isPrescribed;
  const Scalar over = handle.over = isPrescribed ? Scalar{} : 1.0 / (slid.D0 + stiffnessOf(j));
  slid.vD = over * slid.v;
  handle.UR = U;
  for (std::size_t k = 0; k < kinds; ++k) {
    const Vec2<Scalar> V = handle.p[k] = transposedTimes(B[k], wideD), VD = handle.ULD[k] = over * V;
    shown.p[k] = p[k] + transposedTimes(B[k], wideS) - slid.u * VD;
    subtract(U, VD, shown.B[k]);
  }
  shown.h = h - slid.vD * U;
  shown.q = q - slid.u * slid.vD;
}

template <class Scalar, std::size_t kinds>
void GeneralLinearized<Scalar, kinds>::sweepTip() {
  C_ = {};
  Matrix2<Scalar> G;
  G.xx = G.yy = Scalar(1);
  PerMotion<Matrix2<Scalar>, kinds> Gamma{};
  Gamma[0] = G;
  Vec2<Scalar> eta, gamma;
  for (std::size_t j = tips_.size(); j-- > 0;) {
    const GeneralBody& body = bodies_[j];
    const Handle& handle = handles_[j];
    AtTip& at = tips_[j];
    const auto z = turnsOf<kinds>(body, s_);
    const auto w = driftsOf<kinds>(body);
    eta += transposedTimes(G, wide<Scalar>(perp(body.P)));
    at.Ev = Gamma[0].times(perp(body.P), Vec2<Scalar>{});
    at.Eq = {};
    for (std::size_t k = 0; k < kinds; ++k) {
      gamma += Gamma[k].times(turnScale(z[k], body.P), Vec2<Scalar>{});
      at.Eq += Gamma[k].times(turnScale(w[k], body.P), Vec2<Scalar>{});
    }
    if (bodies_.isPrismatic(j)) {
      const Slid& slid = slid_[j];
      const Vec2d iS = perp(body.S);
      at.e = transposedTimes(G, wide<Scalar>(body.axis));
      at.g = sum(Gamma, slid.z);
      at.Ev += Gamma[0].times(iS, Vec2<Scalar>{});
      at.Eq += sum(Gamma, slid.W);
      at.ofRate = Gamma[0].times(body.axis, Vec2<Scalar>{});
      at.ofPlace = sum(Gamma, slid.w);
      at.eD = handle.over * at.e;
      eta += transposedTimes(G, wide<Scalar>(iS)) - slid.u * at.eD;
      gamma += sum(Gamma, slid.Z) - slid.vD * at.g;
    } else {
      at.e = eta;
      at.g = gamma;
      at.eD = handle.over * eta;
      eta = handle.kD * eta;
      gamma = handle.kD * gamma;
    }
    at.eta = eta;
    for (std::size_t k = 0; k < kinds; ++k) subtract(at.g, handle.ULD[k], Gamma[k]);
    subtract(Scalar(-1) * at.g, at.eD, C_);
    subtract(handle.UR, at.eD, G);
  }
  G_ = G;
}

}  // namespace planar_chain
