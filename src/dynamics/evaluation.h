#pragma once

/// The state of a chain whose joints may couple accelerations and whose base may move, and all that follows
/// from it: moments and forces of the effects, the motion of the bodies, moments in the joints, powers.
///
/// If the base turns by φ(t), y holds angles ψ = θ − φ and ψ̇, so that ψ_1 = q_1. The recursion has θ. With
/// M_0 the moment of the base on the chain about the ground pin, F_0 its force,
///
///     P_supplied = that of the effects + Σ (μ_i + J_i q̈_i) q̇_i of prescribed joints
///                  + F_0·v_base + M_0 φ̇ + λ·v_tip
///
/// Coordinates of prismatic joints are displacements; their N and μ are forces along the axis. Pins are the
/// own points of the bodies.
///
/// States are in chain order, whatever the length.

#include <algorithm>
#include <string>
#include <vector>

#include "dynamics/mechanism.h"
#include "effects/effects.h"
#include "lanes/general_chain.h"

namespace planar_chain {

/// A vector whose size never changes, so that assignment copies the values alone.
template <class T>
class Values : public std::vector<T> {
 public:
  Values() = default;
  Values(const Values&) = default;
  Values& operator=(const Values& other) {
    std::copy(other.begin(), other.end(), this->begin());
    return *this;
  }
};

/// Results at one state: a value. Vectors have ground components.
struct Evaluation {
  /// Has room for this chain, and no results yet. Allocates.
  Evaluation(const Mechanism& mechanism, const Effects& effects);

  /// True if it has the results of this state.
  bool isAt(double time, const double* state) const {
    return isKnown && time == t && std::equal(y.begin(), y.end(), state);
  }
  ChainState state() const {
    return {t, y.data(), y.data() + N.size(), e.data(), pinVelocity.data(), base.rate, pin.data()};
  }
  /// The rates of the bodies against the ground, rad/s.
  const double* omega() const { return bodyRates.empty() ? y.data() + N.size() : bodyRates.data(); }
  /// ÿ of the coordinates: ψ̈, rad/s², or m/s².
  const double* slopes() const { return slopesOnBase.empty() ? xdd.data() : slopesOnBase.data(); }

  bool isPlain;  ///< the base stands still, and the tip is free
  bool isKnown = false;
  bool hasMoments = false;                 ///< of a welded chain: then `moments` are known
  double t = 0;                            ///< s
  Values<double> y;                        ///< [ψ ψ̇]
  BaseState base;                          ///< at t
  Vec2d ground;                            ///< acceleration of the ground pin less gravity, m/s²
  double groundTurning = 0;                ///< angular acceleration of the base, rad/s²
  Values<Rotation<double>> e;              ///< exp(i θ_j) of the bodies
  Values<double> N;                        ///< moments of the effects about the own points, N m
  Values<double> xdd;                      ///< of the coordinates, angles against the ground
  Values<double> moments;                  ///< μ in the joints, N m
  Values<double> bodyRates;                ///< if a joint is prismatic or the base moves
  Values<double> slopesOnBase;             ///< if the base moves
  Values<Displacement<double>> displaced;  ///< of prismatic joints, if there are any
  EndForces<double> ends;                  ///< the wrench of the base only if it moves
  Values<Vec2d> F, pinVelocity;            ///< if forces act
  Values<Vec2d> pin;                       ///< positions of the pins, if a force depends on them
  Powers powers;                           ///< of effects, drives and base, W
};

/// Only the constructor allocates.
class Evaluator {
 public:
  /// The mechanism and the effects must outlive this object.
  Evaluator(const Mechanism& mechanism, const Effects& effects);

  /// Writes all results at the state y = [ψ ψ̇] at time t.
  void evaluate(double t, const double* y, Evaluation& to);
  /// The torques that give the bodies these q̈ under the forces and moments of an evaluation without those
  /// `less`. Writes μ of the joints, n values. The next evaluate() takes the couplings again.
  void invert(const Evaluation& at, const double* less, const double* qdd, double* moments);
  /// Call it if something couples otherwise than before, apart from what varies with time.
  void forgetCouplings() { hasCouplings_ = false; }
  std::string recursion() const { return recursion_.name(); }

 private:
  void takeCouplings(double t);
  void takeLaws();
  const double* pose(Evaluation& to);
  void findPins(Evaluation& to) const;
  void run(Evaluation& to, const double* angles);
  double couplingPower(const Evaluation& at);
  const Vec2d* forces(const Evaluation& at) const {
    return effects_.acting() == LoadKind::forces ? at.F.data() : nullptr;
  }

  const Mechanism& mechanism_;
  const Effects& effects_;
  int n_;
  GeneralChain recursion_;
  bool hasCouplings_ = false;
  bool anyIsGiven_ = false;  ///< a joint is prescribed, or the base moves: they may have power
  Couplings couplings_;
  Tip<double> tip_;  ///< at these couplings
  std::vector<double> torques_;
  std::vector<double> angles_;  ///< of the bodies, if a joint is prismatic
};

}  // namespace planar_chain
