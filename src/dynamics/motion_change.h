#pragma once

/// How the accelerations of a chain change with its motion, its loads and the motion of its base: for the
/// linear model, and for ∂f/∂t.
///
/// The recursion of coupled.h runs once on complex numbers, a complex step: f(x + i h x') = f(x) + i h f'(x)
/// x'. With h = 2⁻³⁰⁰ terms with h² vanish in the rounding, so the change is exact to rounding.
///
///     δx_next = δx + δθ iP      δv_next = δv + δω iP − ω δθ P
///     δ(F, N) = −K δ(x, θ) − D δ(v, ω) − (0, X·F) δθ + what is given
///
/// Source: W. Squire, G. Trapp, Using complex variables to estimate derivatives of real functions, SIAM Rev.
/// 40 (1998) 110–112.

#include <complex>
#include <vector>

#include "dynamics/effect_tangents.h"
#include "dynamics/evaluation.h"
#include "recursion/coupled.h"

namespace planar_chain {

/// Only the constructor allocates.
class MotionChange {
 public:
  /// No change yet. The chain must outlive this object.
  explicit MotionChange(const Chain& chain);

  // ---- What changes; set all that does ----------------------------------------------------------------

  Vec2d pin, velocity, acceleration;  ///< of the ground pin
  double turning = 0;                 ///< of the base's angular acceleration
  std::vector<double> turn, speed;    ///< of each body, θ and ω
  std::vector<double> N;              ///< moments about the inner pins
  std::vector<Vec2d> F;               ///< forces
  std::vector<double> held;           ///< q̈ of held joints

  /// Computes the results at an evaluation. hasForces: at.F acts.
  void find(const Evaluation& at, bool hasForces, const Couplings& couplings, const EffectTangents& tangents);

  // ---- The results ------------------------------------------------------------------------------------

  std::vector<double> alpha, moments;      ///< of the bodies and joints
  Vec2d pinForce;                          ///< of the base on the first body
  std::vector<Vec2d> pins, pinVelocities;  ///< of the inner pins

 private:
  using Nudged = std::complex<double>;
  void nudgeLoads(const Evaluation& at, bool hasForces, const EffectTangents& tangents);

  const Chain& chain_;
  Coupled<Nudged> recursion_;
  std::vector<Rotation<Nudged>> e_;
  std::vector<Nudged> omega_, N_, alpha_, moments_;
  std::vector<Vec2<Nudged>> F_;
  std::vector<Coupling<Nudged>> joints_;
};

}  // namespace planar_chain
