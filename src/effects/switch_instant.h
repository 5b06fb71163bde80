#pragma once

/// The search for the instant at which a joint with friction sticks, turns or breaks loose, in a stretch of a
/// step (ode/switches.h).
///
/// In chains of at most `short` joints with friction it is found as exactly as time allows. In longer ones
/// a switch may be late: its delay δ changes the rate in the joint by no more than
///
///     sliding     min(|q̇| then, 2 c Y δ)           f goes on as if it slid on
///     stuck       Y δ (c_0 − c + (|μ| − c_0)/2)     f goes on as if it held
///
/// with Y of stick_slip.h, and this may be `lateShare` of the error that the error control lets the step
/// make. Many joints of a front then switch together, and friction that changes nothing ends no step.

#include <array>
#include <optional>
#include <vector>

#include "effects/effect.h"
#include "effects/stick_slip.h"

namespace planar_chain {

/// Only the constructor allocates.
class SwitchInstant {
 public:
  explicit SwitchInstant(const StickSlip& joints, int n);
  void attach(Mechanics& mechanics) { mechanics_ = &mechanics; }
  /// Call it when the joints or what acts on them has changed: forgets what is known of states.
  void forget();

  // As ode::Switches.
  double due(double t, const double* y) const { return duesAt(t, y).maxCoeff(); }
  double nearest(const ode::Stretch& of) const;
  /// The joint is its `which`. `rest`: how far rounding may bring a joint past its rest, rad/s.
  std::optional<ode::Crossing> crossing(const ode::Stretch& of) const;
  /// A sliding joint past its rest by no more has come to rest there, rad/s. One beyond has gone on the other
  /// way: friction was too weak to stop it.
  double mostRest(const ode::Crossing& found) const;

  /// The moments in the joints at a state. Valid until forget(), or for some more states.
  const double* momentsAt(double t, const double* y) const;

 private:
  using Numbers = Eigen::ArrayXd;

  /// How much the change of each joint is due at a state. Valid as momentsAt().
  const Numbers& duesAt(double t, const double* y) const;
  /// The same of one joint at t within the stretch.
  double dueAt(int joint, double t, const ode::Stretch& of) const;
  /// The error of rates that late switches may make in the stretch, rad/s.
  double mostError(const ode::Stretch& of) const;
  /// The error of the rate if the joint, which is due by so much, switches late by δ.
  double lateError(int joint, double due, double delay) const;
  /// How due() of one joint runs through a stretch, and how far above 0 a step may end.
  struct Rise {
    double begin, half, end, beyond, precise;
  };
  Rise riseOf(int joint, const ode::Stretch& of) const;
  /// A time up to `last`, and behind the first one at which it is due by no more than its `beyond`.
  std::optional<ode::Crossing> crossingOf(int joint, const ode::Stretch& of, double last) const;

  const StickSlip& joints_;
  int n_;
  double lateShare_;
  Mechanics* mechanics_ = nullptr;

  /// What is known of the last few states; the oldest is replaced first. A cache alone: results depend on t
  /// and y, whatever was asked before.
  struct Seen {
    double t;
    Numbers y, moments, dues;
    bool hasMoments, hasDues;
  };
  Seen& seen(double t, const double* y) const;
  mutable std::array<Seen, 8> seen_;
  mutable std::size_t oldest_ = 0;
  mutable std::vector<int> due_;  ///< scratch of crossing()
};

}  // namespace planar_chain
