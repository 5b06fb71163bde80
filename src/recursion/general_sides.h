#pragma once

/// A right-hand side, inwards and outwards. Part of general_linearized.h, which has the equations.

#include "recursion/general_linearized.h"

namespace planar_chain {

template <class Scalar, std::size_t kinds>
void GeneralLinearized<Scalar, kinds>::carryInwards(const Scalar* rhoQ, const Scalar* rhoV) {
  const Coordinates& coordinates = bodies_.coordinates();
  Vec2<Scalar> b;
  Scalar r{};
  for (std::size_t j = bodies_.size(); j-- > 0;) {
    const GeneralBody& body = bodies_[j];
    const JointLaw<double>& joint = bodies_.joint(j);
    Handle& handle = handles_[j];
    const Scalar sigma = ofBody(rhoQ, j) / s_, rho = ofBody(rhoV, j);
    const Scalar known = handle.Mv * rho + handle.Mq * sigma - dotMixed(perp(body.P), b) - r;
    b = mulAdd(-rho, handle.Ev, mulAdd(-sigma, handle.Eq, b));
    if (!bodies_.isPrismatic(j)) {
      const int inner = coordinates.inner(static_cast<int>(j));
      const Scalar bend = inner >= 0 ? sigma - rhoQ[inner] / s_ : sigma;
      const Scalar jump = inner >= 0 ? rho - rhoV[inner] : rho;
      const Scalar delta = joint.isPrescribed ? Scalar{} : joint.armature * jump - body.k * bend;
      const Scalar epsilon = known + delta;
      const Scalar turn = handle.turn = joint.isPrescribed ? jump / (s_ * s_) : epsilon * handle.over;
      b = mulAdd(turn, handle.UR, b);
      moments_[j] = r = joint.isPrescribed ? handle.Dm * turn - epsilon : delta - handle.kD * epsilon;
      continue;
    }
    const Slid& slid = slid_[j];
    const Scalar place = rhoQ[j] / s_, rate = rhoV[j];
    b = mulAdd(-rate, slid.ofRate, mulAdd(place, slid.ofPlace, b));
    r = slid.momentOfPlace * place - known - slid.momentOfRate * rate + dotMixed(perp(body.S), b);
    const Scalar delta = joint.isPrescribed ? Scalar{} : joint.armature * rate - body.k * place;
    const Scalar epsilon = delta - dotMixed(body.axis, b) - slid.f * sigma;
    const Scalar turn = handle.turn = joint.isPrescribed ? rate / (s_ * s_) : epsilon * handle.over;
    b = mulAdd(turn, handle.UR, b);
    r += slid.u * turn;
    moments_[j] = slid.D0 * turn - epsilon;
  }
  baseForce_ = b;
  baseMoment_ = r;
  if (!holdsTip_) return;
  tipFree_ = {};
  for (std::size_t j = 0; j < tips_.size(); ++j) {
    const AtTip& at = tips_[j];
    tipFree_ = mulAdd(handles_[j].turn, at.g,
                      mulAdd(ofBody(rhoQ, j) / s_, at.Eq, mulAdd(-ofBody(rhoV, j), at.Ev, tipFree_)));
    if (bodies_.isPrismatic(j))
      tipFree_ = mulAdd(rhoQ[j] / s_, at.ofPlace, mulAdd(-rhoV[j], at.ofRate, tipFree_));
  }
}

template <class Scalar, std::size_t kinds>
void GeneralLinearized<Scalar, kinds>::carryOutwards(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u,
                                                     Scalar* v) {
  Motion y{};
  Scalar parent{}, sigma{}, rho{};  // u', σ and ρ_v of the body that turns
  for (std::size_t j = 0; j < bodies_.size(); ++j) {
    const GeneralBody& body = bodies_[j];
    const Handle& handle = handles_[j];
    Scalar own, rate = rhoV[j];  // u' and ρ_v of the coordinate
    if (bodies_.isPrismatic(j)) {
      const Slid& slid = slid_[j];
      const Scalar place = rhoQ[j] / s_;
      moments_[j] += slid.v * parent + sum(handle.p, y);
      own = handle.turn - slid.vD * parent - sum(handle.ULD, y);
      for (std::size_t k = 0; k < kinds; ++k) {
        y[k] +=
            mulAdd(parent, slid.Z[k], mulAdd(sigma, slid.W[k], mulAdd(own, slid.z[k], place * slid.w[k])));
      }
      y[0] -= mulAdd(rho, perp(body.S), mulAdd(rate, body.axis, Vec2<Scalar>{}));
      u[j] = place + own;
    } else {
      sigma = rhoQ[j] / s_;
      rho = rate;
      moments_[j] += handle.q * parent + sum(handle.p, y);
      parent = handle.kD * parent + handle.turn - sum(handle.ULD, y);
      own = parent;
      u[j] = sigma + own;
    }
    const auto z = turnsOf<kinds>(body, s_);
    const auto w = driftsOf<kinds>(body);
    for (std::size_t k = 0; k < kinds; ++k) {
      const Vec2<Scalar> drift =
          k == 0 ? driftOf(body, sigma, rho) : Vec2<Scalar>{w[k].x * sigma, w[k].y * sigma};
      y[k] = mulAdd(parent, turnScale(z[k], body.P), y[k] + turnScale(drift, body.P));
    }
    v[j] = s_ * own;
  }
}

/// Finds δλ, and adds what it changes.
template <class Scalar, std::size_t kinds>
void GeneralLinearized<Scalar, kinds>::hold() {
  const Tip<double>& tip = bodies_.tip();
  tipForce_ = {};
  if (tip.rows == 0) return;
  const Vec2d c1 = tip.row[0];
  const auto along = [&](Vec2d row, Vec2d force) { return dotMixed(row, C_.times(force, Vec2<Scalar>{})); };
  if (tip.rows == 1) {
    tipForce_ = (-dotMixed(c1, tipFree_) / along(c1, c1)) * wide<Scalar>(c1);
  } else {
    Eigen::Matrix<Scalar, 2, 2> C;
    C << C_.xx, C_.xy, C_.yx, C_.yy;
    const Eigen::Matrix<Scalar, 2, 1> force =
        C.partialPivLu().solve(Eigen::Matrix<Scalar, 2, 1>(-tipFree_.x, -tipFree_.y));
    tipForce_ = {force[0], force[1]};
  }
  for (std::size_t j = 0; j < tips_.size(); ++j) {
    const AtTip& at = tips_[j];
    handles_[j].turn += dot(at.eD, tipForce_);
    moments_[j] -= dot(bodies_.isPrismatic(j) ? at.e : at.eta, tipForce_);
  }
  baseForce_ -= G_.times(tipForce_, Vec2<Scalar>{});
  baseMoment_ -= dot(tips_.front().eta, tipForce_);
}

}  // namespace planar_chain
