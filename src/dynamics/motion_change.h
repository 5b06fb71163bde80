#pragma once

/// How the accelerations of a chain change with its motion, its loads and the motion of its base: for the
/// linear model, and for ∂f/∂t.
///
/// The recursion of ended.h runs once on dual numbers (recursion/dual.h).
///
///     δ(F, N) = −K δ(x, θ) − D δ(v, ω) − (0, X·F) δθ + what is given

#include <vector>

#include "dynamics/effect_tangents.h"
#include "dynamics/evaluation.h"
#include "recursion/dual.h"
#include "recursion/ended.h"

namespace planar_chain {

/// Only the constructor allocates.
class MotionChange {
 public:
  /// No change yet. The mechanism must outlive this object.
  explicit MotionChange(const Mechanism& mechanism);

  // ---- What changes; set all that does ----------------------------------------------------------------

  Vec2d pin, velocity, acceleration;  ///< of the ground pin
  double turning = 0;                 ///< of the base's angular acceleration
  Vec2d tip;                          ///< of the acceleration at which the tip is held
  std::vector<double> turn, speed;    ///< of each body, θ and ω; of slides, s and ṡ
  std::vector<double> N;              ///< moments about the inner pins
  std::vector<Vec2d> F;               ///< forces
  std::vector<double> held;           ///< q̈ of held joints

  /// Computes the results at an evaluation. hasForces: at.F acts.
  void find(const Evaluation& at, bool hasForces, const Couplings& couplings, const EffectTangents& tangents);

  // ---- The results ------------------------------------------------------------------------------------

  std::vector<double> alpha, moments;      ///< of the bodies and joints; s̈ of slides
  Vec2d pinForce;                          ///< of the base on the chain
  Vec2d tipForce;                          ///< on the tip
  std::vector<Vec2d> pins, pinVelocities;  ///< of the inner pins

 private:
  void nudge(const Evaluation& at, bool hasForces, const Couplings& couplings,
             const EffectTangents& tangents);
  Tip<Dual> nudgedTip(const Evaluation& at) const;

  const Mechanism& mechanism_;
  Ended<Dual> recursion_;
  std::vector<Rotation<Dual>> e_;
  std::vector<Dual> omega_, N_, alpha_, moments_;
  std::vector<Vec2<Dual>> F_;
  std::vector<Coupling<Dual>> joints_;
};

}  // namespace planar_chain
