#pragma once

/// The search for the instant at which a joint with friction sticks, turns or breaks loose, in a stretch of a
/// step (ode/switches.h).
///
/// It is found as exactly as time and the rounding of rates and moments allow.

#include <array>
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
  /// The joint is its `which`.
  ode::Crossing crossing(const ode::Stretch& of) const;

  /// The moments in the joints at a state. Valid until forget(), or for some more states.
  const double* momentsAt(double t, const double* y) const;

 private:
  using Numbers = Eigen::ArrayXd;

  /// How much the change of each joint is due at a state. Valid as momentsAt().
  const Numbers& duesAt(double t, const double* y) const;
  /// The same of one joint at t within the stretch.
  double dueAt(int joint, double t, const ode::Stretch& of) const;
  /// How far above 0 due() of a joint may be where a step ends, of which it has these values at the begin, in
  /// the middle and at the end.
  double mostBeyond(int joint, const ode::Stretch& of, double begin, double half, double end) const;
  /// The first time up to `last` at which due() of a joint is above 0, by no more than that; or one so near
  /// behind it that rounding hides which is first: then the joint is not told.
  ode::Crossing crossingOf(int joint, const ode::Stretch& of, double last) const;

  const StickSlip& joints_;
  int n_;
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
