#include "dynamics/motion_change.h"

namespace planar_chain {

namespace {

constexpr double h = 0x1p-300;

std::complex<double> nudged(double value, double change) {
  return {value, h * change};
}
Vec2<std::complex<double>> nudged(Vec2d value, Vec2d change) {
  return {nudged(value.x, change.x), nudged(value.y, change.y)};
}
double changeOf(std::complex<double> number) {
  return number.imag() / h;
}

}  // namespace

MotionChange::MotionChange(const Chain& chain) : chain_(chain), recursion_(chain) {
  const auto n = index(chain.size());
  for (auto* numbers : {&turn, &speed, &N, &held, &alpha, &moments}) numbers->resize(n);
  for (auto* vectors : {&F, &pins, &pinVelocities}) vectors->resize(n);
  e_.resize(n);
  for (auto* numbers : {&omega_, &N_, &alpha_, &moments_}) numbers->resize(n);
  F_.resize(n);
  joints_.resize(n);
}

/// The forces and moments, and the motion of the pins on which they depend.
void MotionChange::nudgeLoads(const Evaluation& at, bool hasForces, const EffectTangents& tangents) {
  Vec2d dx = pin, dv = velocity;
  for (std::size_t j = 0; j < e_.size(); ++j) {
    pins[j] = dx;
    pinVelocities[j] = dv;
    Vec2d dF = F[j];
    double dN = N[j];
    if (!tangents.XF.empty()) dN -= tangents.XF[j] * turn[j];
    if (!tangents.bodies.empty()) {
      const auto& [K, D] = tangents.bodies[j];
      dF -= K.forcePlace * dx + turn[j] * K.forceTurn + D.forcePlace * dv + speed[j] * D.forceTurn;
      dN -=
          dot(K.momentPlace, dx) + K.momentTurn * turn[j] + dot(D.momentPlace, dv) + D.momentTurn * speed[j];
    }
    N_[j] = nudged(at.N[j], dN);
    F_[j] = nudged(hasForces ? at.F[j] : Vec2d{}, dF);

    const Vec2d P = at.e[j] * chain_.links()[j].pin;
    dx += turn[j] * perp(P);
    dv += speed[j] * perp(P) - (at.omega()[j] * turn[j]) * P;
  }
}

void MotionChange::find(const Evaluation& at, bool hasForces, const Couplings& couplings,
                        const EffectTangents& tangents) {
  nudgeLoads(at, hasForces, tangents);
  for (std::size_t j = 0; j < e_.size(); ++j) {
    const auto [c, s] = at.e[j];
    e_[j] = {nudged(c, -s * turn[j]), nudged(s, c * turn[j])};
    omega_[j] = nudged(at.omega()[j], speed[j]);
    const Coupling<double>& joint = couplings.joints[j];
    joints_[j] = {joint.rotor, joint.isHeld, nudged(joint.acceleration, held[j])};
  }
  const auto force = recursion_.accelerations(
      e_.data(), omega_.data(), N_.data(), F_.data(), joints_.data(), nudged(at.ground, acceleration),
      nudged(at.groundTurning, turning), alpha_.data(), moments_.data());
  for (std::size_t j = 0; j < e_.size(); ++j) {
    alpha[j] = changeOf(alpha_[j]);
    moments[j] = changeOf(moments_[j]);
  }
  pinForce = {changeOf(force.x), changeOf(force.y)};
}

}  // namespace planar_chain
