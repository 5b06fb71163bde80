#pragma once

/// The part of an effect that couples the accelerations of neighbouring bodies, or moves the base
/// (recursion/general.h): it gives q̈ of joints, rotors, or the motion of the ground pin.

#include <vector>

#include "planar_chain/motion_law.h"
#include "planar_chain/planar.h"
#include "recursion/general.h"
#include "recursion/tip_constraint.h"

namespace planar_chain {

class Mechanics;

/// The ground pin, m and m/s, and the angle that joint 1 is measured from, rad and rad/s.
struct BaseState {
  Vec2d pin, velocity;
  double angle = 0, rate = 0;

  BaseState atRest() const { return {pin, {}, angle, 0}; }
};
inline BaseState stateOf(const BaseLaws& laws, double t) {
  const GivenMotion x = laws.x.at(t), y = laws.y.at(t), angle = laws.angle.at(t);
  return {{x.value, y.value}, {x.rate, y.rate}, angle.value, angle.rate};
}

/// The prescribed motions at one time, or one order of their Taylor series: of each joint and of the base.
struct Couplings {
  /// No couplings of n joints, on a base at rest. Allocates.
  explicit Couplings(int n) : joints(static_cast<std::size_t>(n)), prescribed(joints.size()) {}

  BaseState base() const { return {{x.value, y.value}, {x.rate, y.rate}, angle.value, angle.rate}; }
  Vec2d pinAcceleration() const { return {x.acceleration, y.acceleration}; }
  /// Sets relative angles and rates of prescribed joints to the prescribed ones; n each.
  void hold(double* q, double* qd) const {
    for (std::size_t i = 0; i < joints.size(); ++i) {
      if (!joints[i].isPrescribed) continue;
      q[i] = prescribed[i].value;
      qd[i] = prescribed[i].rate;
    }
  }

  std::vector<JointLaw<double>> joints;
  std::vector<GivenMotion> prescribed;  ///< the motion of each prescribed joint
  GivenMotion x, y, angle;              ///< of the base
  Tip<double> tip{};                    ///< its constraint; the acceleration as given
  Vec2d tipPosition, tipVelocity;       ///< as given
};

class JointConstraint {
 public:
  virtual ~JointConstraint() = default;
  /// Writes order k of the Taylor series around t of its own couplings, and nothing else. Order 0 are the
  /// couplings at t. A law keeps the piece that enter() chose. Allocates nothing.
  virtual void couple(double t, int k, Couplings& to) const = 0;
  /// True if it never does more than hold joints at rest, at the angles that they have. Their bodies may then
  /// be welded.
  virtual bool onlyHolds() const { return false; }
  /// Replaces the law of a joint that it drives.
  virtual void follow(int /*joint*/, const MotionLaw& /*law*/) {}
  /// The laws of the base, or nullptr if it does not move the base. Valid as long as the effect.
  virtual const BaseLaws* base() const { return nullptr; }
  /// True if it holds the tip.
  virtual bool holdsTip() const { return false; }
  /// Replaces the laws of the base.
  virtual void followBase(const BaseLaws& /*laws*/) {}
  /// Called once, by the dynamics that has the effect. `mechanics` outlives the effect's last call.
  virtual void attach(Mechanics& /*mechanics*/) {}
};

}  // namespace planar_chain
