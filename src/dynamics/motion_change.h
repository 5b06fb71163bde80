#pragma once

/// How the accelerations of a chain change with its motion, its loads and the motion of its base: for the
/// linear model, and for ∂f/∂t.
///
/// The recursion of general.h runs once on dual numbers (recursion/dual.h).
///
///     δ(F, N) = −K δ(x, θ) − D δ(v, ω) − (0, X·F) δθ + what is given

#include <algorithm>
#include <vector>

#include "dynamics/effect_tangents.h"
#include "dynamics/evaluation.h"
#include "recursion/dual.h"
#include "recursion/general_recursion.h"

namespace planar_chain {

/// Only the constructor allocates.
class MotionChange {
 public:
  /// No change yet. The mechanism must outlive this object.
  explicit MotionChange(const Mechanism& mechanism) : mechanism_(mechanism), recursion_(mechanism.chain()) {
    const auto n = index(mechanism.size());
    for (auto* numbers : {&turn, &speed, &N, &prescribed, &xdd, &moments}) numbers->resize(n);
    for (auto* vectors : {&F, &pins, &pinVelocities}) vectors->resize(n);
    e_.resize(n);
    for (auto* numbers : {&x_, &rates_, &omega_, &N_, &xdd_, &moments_}) numbers->resize(n);
    F_.resize(n);
    joints_.resize(n);
    displaced_.resize(n);
  }

  // ---- What changes; set all that does ----------------------------------------------------------------

  Vec2d pin, velocity, acceleration;  ///< of the ground pin
  double angle = 0, rate = 0;         ///< of the base's angle and rate
  double turning = 0;                 ///< of its angular acceleration
  Vec2d tip;                          ///< of the acceleration at which the tip is held
  std::vector<double> turn, speed;    ///< of the coordinates and their rates, angles against the ground
  std::vector<double> N;              ///< moments about the inner pins
  std::vector<Vec2d> F;               ///< forces
  std::vector<double> prescribed;     ///< q̈ of prescribed joints

  /// Computes the results at an evaluation. hasForces: at.F acts.
  void find(const Evaluation& at, bool hasForces, const Couplings& couplings,
            const EffectTangents& tangents) {
    pose(at);
    nudge(at, hasForces, couplings, tangents);
    const EndForces<Dual> ends = recursion_.accelerations(
        {e_.data(), omega_.data(), displaced_.data()},
        {N_.data(), F_.data(), joints_.data(), nudged(at.ground, acceleration), {at.groundTurning, turning}},
        nudgedTip(at), xdd_.data(), moments_.data());
    for (std::size_t j = 0; j < xdd.size(); ++j) {
      xdd[j] = xdd_[j].slope;
      moments[j] = moments_[j].slope;
    }
    tipForce = changeOf(ends.tip.force);
    baseForce = changeOf(ends.baseForce);
    baseMoment = ends.baseMoment.slope;
  }

  // ---- The results ------------------------------------------------------------------------------------

  std::vector<double> xdd, moments;        ///< of the coordinates and joints
  Vec2d baseForce;                         ///< of the base on the chain
  double baseMoment = 0;                   ///< see EndForces
  Vec2d tipForce;                          ///< on the tip
  std::vector<Vec2d> pins, pinVelocities;  ///< of the own points of the bodies

 private:
  static Vec2d changeOf(Vec2<Dual> vector) { return {vector.x.slope, vector.y.slope}; }

  /// The bodies, and their own points.
  void pose(const Evaluation& at) {
    const Chain& chain = mechanism_.chain();
    const Coordinates& coordinates = chain.coordinates();
    const std::size_t n = e_.size();
    for (std::size_t j = 0; j < n; ++j) {
      const int i = static_cast<int>(j);
      x_[j] = {at.y[j], turn[j]};
      rates_[j] = {at.y[n + j], speed[j]};
      e_[j] = planar_chain::turning(at.e[j], coordinates.angle(turn.data(), i, angle));
      omega_[j] = {at.omega()[j], coordinates.angle(speed.data(), i, rate)};
      if (coordinates.isPrismatic(i))
        displaced_[j] = displacementOf(chain.joints()[j].axis, e_[j], omega_[j], x_[j], rates_[j]);
    }
    const PointAt<Dual> ground{nudged(at.base.pin, pin), nudged(at.base.velocity, velocity)};
    sweepOutwards(chain, ground, e_.data(), omega_.data(), x_.data(), rates_.data(),
                  [&](int j, const PointAt<Dual>& own) {
                    pins[index(j)] = changeOf(own.position);
                    pinVelocities[index(j)] = changeOf(own.velocity);
                  });
  }
  /// The forces and moments, which depend on the motion of the pins.
  void nudge(const Evaluation& at, bool hasForces, const Couplings& couplings,
             const EffectTangents& tangents) {
    for (std::size_t j = 0; j < e_.size(); ++j) {
      const Coordinates& coordinates = mechanism_.coordinates();
      const int i = static_cast<int>(j);
      const double turned = coordinates.angle(turn.data(), i, angle), sped = omega_[j].slope;
      Vec2d dF = F[j];
      double dN = N[j], dM = 0;  // dM: of the body
      if (!tangents.XF.empty() && !coordinates.isPrismatic(i)) dM -= tangents.XF[j] * turned;
      if (!tangents.bodies.empty()) {
        const auto& [K, D] = tangents.bodies[j];
        const Vec2d dx = pins[j], dv = pinVelocities[j];
        dF -= K.forceShift * dx + turned * K.forceTurn + D.forceShift * dv + sped * D.forceTurn;
        dM -= dot(K.momentShift, dx) + K.momentTurn * turned + dot(D.momentShift, dv) + D.momentTurn * sped;
      }
      N_[j] = {at.N[j], dN};
      if (coordinates.turner(i) >= 0) N_[index(coordinates.turner(i))].slope += dM;
      F_[j] = nudged(hasForces ? at.F[j] : Vec2d{}, dF);
      const JointLaw<double>& joint = couplings.joints[j];
      joints_[j] = {joint.armature, joint.isPrescribed, {joint.acceleration, prescribed[j]}};
    }
  }
  /// The directions that act at the state.
  Tip<Dual> nudgedTip(const Evaluation& at) const {
    const Tip<double>& acting = at.ends.tip.acting;
    return {acting.rows,
            {nudged(acting.row[0], {}), nudged(acting.row[1], {})},
            nudged(acting.acceleration, tip)};
  }

  static Vec2<Dual> nudged(Vec2d value, Vec2d change) { return {{value.x, change.x}, {value.y, change.y}}; }

  const Mechanism& mechanism_;
  GeneralRecursion<Dual> recursion_;
  std::vector<Rotation<Dual>> e_;
  std::vector<Dual> x_, rates_, omega_, N_, xdd_, moments_;
  std::vector<Vec2<Dual>> F_;
  std::vector<JointLaw<Dual>> joints_;
  std::vector<Displacement<Dual>> displaced_;
};

}  // namespace planar_chain
