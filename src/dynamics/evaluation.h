#pragma once

/// The state of a chain whose joints may couple accelerations and whose base may move, and all that follows
/// from it: moments and forces of the effects, the motion of the bodies, moments in the joints, powers.
///
/// If the base turns by φ(t), y holds ψ = θ − φ and ψ̇, so that ψ_1 = q_1. The recursion has θ. With τ_1 the
/// torque of the effects in joint 1,
///
///     P_supplied = that of the effects + Σ (μ_i + J_i q̈_i) q̇_i of held joints + F_pin·v_base + (μ_1 + τ_1) φ̇
///     + λ·v_tip
///
/// In the arrays the slides come first: their positions, their rates in ω, s̈ in α, forces along the rails in
/// N and μ; e of the base; and as pins their own points. Joint 1 is then the first one behind them, and the
/// moment of the base on what slides counts too (inner_end.h).
///
/// States are in chain order, whatever the length.

#include <algorithm>
#include <string>
#include <vector>

#include "dynamics/mechanism.h"
#include "dynamics/rails.h"
#include "effects/effects.h"
#include "lanes/coupled_chain.h"

namespace planar_chain {

/// Results at one state: a value. Vectors have ground components.
struct Evaluation {
  /// Of no state yet, with room for this chain. Allocates.
  Evaluation(const Mechanism& mechanism, const Effects& effects);

  /// True if it has the results of this state.
  bool isAt(double time, const double* state) const {
    return isKnown && time == t && std::equal(y.begin(), y.end(), state);
  }
  ChainState state() const {
    return {t, y.data(), y.data() + N.size(), e.data(), pinVelocity.data(), base.rate, pin.data()};
  }
  /// The rates of the bodies against the ground, rad/s.
  const double* omega() const { return turning.empty() ? y.data() + N.size() : turning.data(); }
  /// How the base turns the slides.
  BaseTurn<double> turn() const { return {e.front(), base.rate, groundTurning}; }
  bool turnsRails() const { return base.angle != 0 || base.rate != 0 || groundTurning != 0; }
  /// ψ̈, rad/s².
  const double* slopes() const { return slopesOnBase.empty() ? alpha.data() : slopesOnBase.data(); }

  bool isPlain;  ///< the base stands still, and the chain has no ends
  bool isKnown = false;
  bool hasMoments = false;                    ///< of a welded chain: then `moments` are known
  double t = 0;                               ///< s
  std::vector<double> y;                      ///< [ψ ψ̇]
  BaseState base;                             ///< at t
  Vec2d ground;                               ///< acceleration of the ground pin less gravity, m/s²
  double groundTurning = 0;                   ///< angular acceleration of the base, rad/s²
  Vec2d pinForce;                             ///< of the base on the chain, N
  double slidesMoment = 0;                    ///< of the base on slides, about the ground pin, N m
  std::vector<Rotation<double>> e;            ///< exp(i θ_j)
  std::vector<double> N;                      ///< moments of the effects about the inner pins, N m
  std::vector<double> alpha;                  ///< against the ground, rad/s²
  std::vector<double> moments;                ///< μ in the joints, N m
  std::vector<double> turning, slopesOnBase;  ///< if the base moves
  EndsMotion<double> ends;                    ///< if the chain has ends
  std::vector<Vec2d> F, pinVelocity;          ///< if forces act
  std::vector<Vec2d> pin;                     ///< places of the inner pins, if a force depends on them
  Powers powers;                              ///< of effects, drives and base, W
};

/// Only the constructor allocates.
class Evaluator {
 public:
  /// The mechanism and the effects must outlive this object.
  Evaluator(const Mechanism& mechanism, Effects& effects);

  /// Writes all results at the state y = [ψ ψ̇] at time t.
  void evaluate(double t, const double* y, Evaluation& to);
  /// The torques that give the bodies these q̈ under the forces and moments of an evaluation without those
  /// `less`. Writes μ of the joints, n values. The next evaluate() takes the couplings again.
  void invert(const Evaluation& at, const double* less, const double* qdd, double* moments);
  /// Call it if something couples otherwise than before, apart from what varies with time.
  void forgetCouplings() { hasCouplings_ = false; }
  std::string recursion() const {
    return recursion_.name() + (mechanism_.hasEnds() ? ", slides and held tips" : "");
  }

 private:
  void takeCouplings(double t);
  void coupleRecursion();
  const double* turn(Evaluation& to) const;
  void placePins(Evaluation& to) const;
  void run(Evaluation& to, const double* theta);
  void runBetweenEnds(Evaluation& to, const double* theta);
  void runOnRails(Evaluation& to, const double* theta);
  void sweepBetweenEnds(Evaluation& to, const double* theta, Vec2d ground);
  double couplingPower(const Evaluation& at);
  const Vec2d* forces(const Evaluation& at) const {
    return effects_.acting() == LoadKind::forces ? at.F.data() : nullptr;
  }

  const Mechanism& mechanism_;
  Effects& effects_;
  int n_;
  CoupledChain recursion_;
  bool hasCouplings_ = false;
  bool anyIsGiven_ = false;  ///< a joint is held, or the base moves: they may have power
  Couplings couplings_;
  InnerEnd<double> inner_;  ///< at these couplings
  Tip<double> tip_;
  std::vector<double> torques_;
};

}  // namespace planar_chain
