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
/// Chains with ends run on dual numbers (recursion/dual.h): their recursion compares numbers.
///
/// Source: W. Squire, G. Trapp, Using complex variables to estimate derivatives of real functions, SIAM Rev.
/// 40 (1998) 110–112.

#include <complex>
#include <variant>
#include <vector>

#include "dynamics/effect_tangents.h"
#include "dynamics/evaluation.h"
#include "recursion/coupled.h"
#include "recursion/dual.h"
#include "recursion/ended.h"

namespace planar_chain {

/// Only the constructor allocates.
class MotionChange {
 public:
  /// No change yet. hasEnds: as Mechanism's. The chain must outlive this object.
  explicit MotionChange(const Chain& chain, bool hasEnds);

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
  Vec2d pinForce;                          ///< of the base on the first body
  Vec2d tipForce;                          ///< on the tip
  std::vector<Vec2d> pins, pinVelocities;  ///< of the inner pins

 private:
  /// Numbers that change, and their recursion.
  template <class Nudged, class Recursion>
  struct Run {
    explicit Run(const Chain& bodies, int n);

    Recursion recursion;
    std::vector<Rotation<Nudged>> e;
    std::vector<Nudged> omega, N, alpha, moments;
    std::vector<Vec2<Nudged>> F;
    std::vector<Coupling<Nudged>> joints;
  };
  using Pinned = Run<std::complex<double>, Coupled<std::complex<double>>>;
  using WithEnds = Run<Dual, Ended<Dual>>;

  template <class AnyRun>
  void nudge(const Evaluation& at, bool hasForces, const Couplings& couplings, const EffectTangents& tangents,
             AnyRun& run);
  template <class AnyRun>
  void nudgeLoads(const Evaluation& at, bool hasForces, const EffectTangents& tangents, AnyRun& run);
  template <class AnyRun>
  void takeResults(const AnyRun& run);
  Vec2<std::complex<double>> accelerate(const Evaluation& at, Pinned& run);
  Tip<Dual> nudgedTip(const Evaluation& at) const;
  Vec2<Dual> accelerate(const Evaluation& at, WithEnds& run);

  const Chain& chain_;
  std::variant<Pinned, WithEnds> run_;
};

}  // namespace planar_chain
