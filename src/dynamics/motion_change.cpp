#include "dynamics/motion_change.h"

#include <algorithm>

#include "dynamics/inner_end.h"

namespace planar_chain {

namespace {

Vec2<Dual> nudged(Vec2d value, Vec2d change) {
  return {{value.x, change.x}, {value.y, change.y}};
}
Vec2d changeOf(Vec2<Dual> vector) {
  return {vector.x.slope, vector.y.slope};
}

}  // namespace

MotionChange::MotionChange(const Mechanism& mechanism)
    : mechanism_(mechanism), recursion_(mechanism.bodies()) {
  const auto n = index(mechanism.size());
  for (auto* numbers : {&turn, &speed, &N, &held, &alpha, &moments}) numbers->resize(n);
  for (auto* vectors : {&F, &pins, &pinVelocities}) vectors->resize(n);
  e_.resize(n);
  for (auto* numbers : {&omega_, &N_, &alpha_, &moments_}) numbers->resize(n);
  F_.resize(n);
  joints_.resize(n);
}

/// The bodies, and the forces and moments, which depend on the motion of the pins.
void MotionChange::nudge(const Evaluation& at, bool hasForces, const Couplings& couplings,
                         const EffectTangents& tangents) {
  mechanism_.findPinChanges(at.e.data(), at.omega(), turn.data(), speed.data(), mechanism_.size(),
                            pins.data(), pinVelocities.data(), pin, velocity);
  for (std::size_t j = 0; j < e_.size(); ++j) {
    const bool slides = j < index(mechanism_.slides());
    Vec2d dF = F[j];
    double dN = N[j];
    if (!tangents.XF.empty() && !slides) dN -= tangents.XF[j] * turn[j];
    if (!tangents.bodies.empty() && !slides) {
      const auto& [K, D] = tangents.bodies[j];
      const Vec2d dx = pins[j], dv = pinVelocities[j];
      dF -= K.forcePlace * dx + turn[j] * K.forceTurn + D.forcePlace * dv + speed[j] * D.forceTurn;
      dN -=
          dot(K.momentPlace, dx) + K.momentTurn * turn[j] + dot(D.momentPlace, dv) + D.momentTurn * speed[j];
    }
    N_[j] = {at.N[j], dN};
    F_[j] = nudged(hasForces ? at.F[j] : Vec2d{}, dF);
    e_[j] = planar_chain::turning(at.e[j], turn[j]);
    omega_[j] = {at.omega()[j], speed[j]};
    const Coupling<double>& joint = couplings.joints[j];
    joints_[j] = {joint.rotor, joint.isHeld, {joint.acceleration, held[j]}};
  }
}

/// The directions that act at the state.
Tip<Dual> MotionChange::nudgedTip(const Evaluation& at) const {
  const Tip<double>& acting = at.ends.acting;
  return {
      acting.rows, {nudged(acting.row[0], {}), nudged(acting.row[1], {})}, nudged(acting.acceleration, tip)};
}

void MotionChange::find(const Evaluation& at, bool hasForces, const Couplings& couplings,
                        const EffectTangents& tangents) {
  nudge(at, hasForces, couplings, tangents);
  const int slides = mechanism_.slides();
  InnerEnd<Dual> inner = innerEndOf(mechanism_.chain(), joints_.data());
  setForces(N_.data(), F_.data(), inner);
  const EndsMotion<Dual> motion =
      recursion_.accelerations(e_.data() + slides, omega_.data() + slides,
                               {N_.data() + slides,
                                F_.data() + slides,
                                joints_.data() + slides,
                                nudged(at.ground, acceleration),
                                {at.groundTurning, turning}},
                               inner, nudgedTip(at), alpha_.data() + slides, moments_.data() + slides);
  std::copy_n(motion.acceleration.begin(), slides, alpha_.begin());
  writeHolding(inner, motion, moments_.data());
  for (std::size_t j = 0; j < alpha.size(); ++j) {
    alpha[j] = alpha_[j].slope;
    moments[j] = moments_[j].slope;
  }
  tipForce = changeOf(motion.tipForce);
  pinForce = changeOf(forceOfBase(inner, motion, nudged(at.ground, acceleration), F_.data()));
}

}  // namespace planar_chain
