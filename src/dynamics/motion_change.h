#pragma once

/// How the accelerations of a chain change with its motion, its loads and the motion of its base: for the
/// linear model, and for ∂f/∂t.
///
/// The recursion of ended.h runs once on dual numbers (recursion/dual.h).
///
///     δ(F, N) = −K δ(x, θ) − D δ(v, ω) − (0, X·F) δθ + what is given

#include <algorithm>
#include <vector>

#include "dynamics/effect_tangents.h"
#include "dynamics/evaluation.h"
#include "dynamics/inner_end.h"
#include "recursion/dual.h"
#include "recursion/ended.h"

namespace planar_chain {

/// Only the constructor allocates.
class MotionChange {
 public:
  /// No change yet. The mechanism must outlive this object.
  explicit MotionChange(const Mechanism& mechanism) : mechanism_(mechanism), recursion_(mechanism.bodies()) {
    const auto n = index(mechanism.size());
    for (auto* numbers : {&turn, &speed, &N, &held, &alpha, &moments}) numbers->resize(n);
    for (auto* vectors : {&F, &pins, &pinVelocities}) vectors->resize(n);
    e_.resize(n);
    for (auto* numbers : {&omega_, &N_, &alpha_, &moments_}) numbers->resize(n);
    F_.resize(n);
    joints_.resize(n);
  }

  // ---- What changes; set all that does ----------------------------------------------------------------

  Vec2d pin, velocity, acceleration;  ///< of the ground pin
  double angle = 0, rate = 0;         ///< of the base's angle and rate, as far as they move slides
  double turning = 0;                 ///< of the base's angular acceleration
  Vec2d tip;                          ///< of the acceleration at which the tip is held
  std::vector<double> turn, speed;    ///< of each body, θ and ω; of slides, s and ṡ
  std::vector<double> N;              ///< moments about the inner pins
  std::vector<Vec2d> F;               ///< forces
  std::vector<double> held;           ///< q̈ of held joints

  /// Computes the results at an evaluation. hasForces: at.F acts.
  void find(const Evaluation& at, bool hasForces, const Couplings& couplings,
            const EffectTangents& tangents) {
    nudge(at, hasForces, couplings, tangents);
    const int slides = mechanism_.slides();
    InnerEnd<Dual> inner = innerEndOf(mechanism_.chain(), joints_.data());
    setForces(N_.data(), F_.data(), inner, at.turnsRails() ? &rails_ : nullptr);
    const Vec2<Dual> base = nudged(at.ground, acceleration);
    const EndsMotion<Dual> motion =
        recursion_.accelerations(e_.data() + slides, omega_.data() + slides,
                                 {N_.data() + slides,
                                  F_.data() + slides,
                                  joints_.data() + slides,
                                  base + rails_.first.drift,
                                  {at.groundTurning, turning}},
                                 inner, nudgedTip(at), alpha_.data() + slides, moments_.data() + slides);
    std::copy_n(motion.acceleration.begin(), slides, alpha_.begin());
    writeHolding(inner, motion, moments_.data());
    for (std::size_t j = 0; j < alpha.size(); ++j) {
      alpha[j] = alpha_[j].slope;
      moments[j] = moments_[j].slope;
    }
    tipForce = changeOf(motion.tipForce);
    const OfBase<Dual> by = ofBase(inner, motion, base, F_.data(), rails_);
    pinForce = changeOf(by.force);
    slidesMoment = by.moment.slope;
    for (int i = 0; i < slides; ++i) slidesMoment += mechanism_.chain().links()[index(i)].inertia * turning;
  }

  // ---- The results ------------------------------------------------------------------------------------

  std::vector<double> alpha, moments;      ///< of the bodies and joints; s̈ of slides
  Vec2d pinForce;                          ///< of the base on the chain
  double slidesMoment = 0;                 ///< see Evaluation
  Vec2d tipForce;                          ///< on the tip
  std::vector<Vec2d> pins, pinVelocities;  ///< of the inner pins

 private:
  /// The rails on the base, and the places and velocities of all pins.
  void movePins(const Evaluation& at) {
    if (mechanism_.slides() > 0) {
      const BaseTurn<Dual> base{
          planar_chain::turning(at.turn().e, angle), {at.base.rate, rate}, {at.groundTurning, turning}};
      rails_ = changingRails(mechanism_.chain(), base, at.y.data(), at.omega(), turn.data(), speed.data());
    }
    mechanism_.findPinChanges(at.e.data(), at.omega(), turn.data(), speed.data(), mechanism_.size(), rails_,
                              pins.data(), pinVelocities.data(), pin, velocity);
  }
  /// The bodies, and the forces and moments, which depend on the motion of the pins.
  void nudge(const Evaluation& at, bool hasForces, const Couplings& couplings,
             const EffectTangents& tangents) {
    movePins(at);
    for (std::size_t j = 0; j < e_.size(); ++j) {
      // Slides do not turn against the base, and forces on them have no moment.
      const bool turns = j >= index(mechanism_.slides());
      const double turned = turns ? turn[j] : angle, sped = turns ? speed[j] : rate;
      Vec2d dF = F[j];
      double dN = N[j];
      if (!tangents.XF.empty() && turns) dN -= tangents.XF[j] * turned;
      if (!tangents.bodies.empty()) {
        const auto& [K, D] = tangents.bodies[j];
        const Vec2d dx = pins[j], dv = pinVelocities[j];
        dF -= K.forcePlace * dx + turned * K.forceTurn + D.forcePlace * dv + sped * D.forceTurn;
        if (turns)
          dN -= dot(K.momentPlace, dx) + K.momentTurn * turned + dot(D.momentPlace, dv) + D.momentTurn * sped;
      }
      N_[j] = {at.N[j], dN};
      F_[j] = nudged(hasForces ? at.F[j] : Vec2d{}, dF);
      e_[j] = planar_chain::turning(at.e[j], turned);
      omega_[j] = {at.omega()[j], speed[j]};
      const Coupling<double>& joint = couplings.joints[j];
      joints_[j] = {joint.rotor, joint.isHeld, {joint.acceleration, held[j]}};
    }
  }
  /// The directions that act at the state.
  Tip<Dual> nudgedTip(const Evaluation& at) const {
    const Tip<double>& acting = at.ends.acting;
    return {acting.rows,
            {nudged(acting.row[0], {}), nudged(acting.row[1], {})},
            nudged(acting.acceleration, tip)};
  }

  static Vec2<Dual> nudged(Vec2d value, Vec2d change) { return {{value.x, change.x}, {value.y, change.y}}; }

  const Mechanism& mechanism_;
  Rails<Dual> rails_;
  Ended<Dual> recursion_;
  std::vector<Rotation<Dual>> e_;
  std::vector<Dual> omega_, N_, alpha_, moments_;
  std::vector<Vec2<Dual>> F_;
  std::vector<Coupling<Dual>> joints_;
};

}  // namespace planar_chain
