#pragma once

/// The state machine of joints with dry friction.
///
///     slips     μ = −c sign(q̇)           until q̇ passes 0
///     sticks    q̈ = 0                    until |μ| > breakaway torque + band
///     is loose  μ = 0 or ±c              until |q̇| > what rounding and the tolerance give
///
/// A joint is loose at rest in a dead centre of a closed chain, where no torque in it can hold it; or where
/// several could hold the chain together, and what each of them bears is not determined.
/// A joint that sticks keeps the angle at which it came to rest. Nothing here evaluates the chain.
///
/// The band keeps rounding from deciding. It is the largest of
///
///     `rounding` × breakaway torque      rounding of |μ| alone
///     a / Y                              a torque that would start the joint with less than a
///
/// where a = accuracy × tolerance/s, rad/s², ten times that for weak friction, of a prismatic joint times the
/// chain's reach; and Y = 1/I_i + 1/I_{i−1} is an upper bound of ∂q̈/∂μ: pins and rotors only make it smaller.
/// (I of a point mass: stick_slip.cpp.) So a joint that the band holds for T errs by less than a T²/2.
/// Between long stretches that stick, ∂q̈/∂μ may be 1e8 times smaller: a joint that breaks loose there and
/// starts with far less than a gets a wider band. If a joint breaks loose with less than 1000 a (or
/// 1000 roundings of q̈) and comes to rest again without its angle moving by more than rounding, its torque
/// was not known to be larger: its band becomes four times as wide. So rounding cannot make a joint
/// stick and slip by turns where it does not move, and a torque that clearly starts it does start it. A joint
/// that moves gets its own band back.
///
/// A joint whose breakaway torque changes no rate by more than a tenth of the tolerance in a second, c Y <
/// 0.1 tolerance/s, has no friction here: it would change the motion by less than the tolerance allows.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "planar_chain/chain.h"
#include "simd/snapshot.h"

namespace planar_chain {

/// True if the joint has dry friction, or a breakaway torque alone.
inline bool mayStick(const Joint& joint) {
  return joint.other("friction") > 0 || joint.other("breakaway") > 0;
}

/// Only the constructor and reserve() allocate.
class StickSlip {
 public:
  using Numbers = Eigen::ArrayXd;
  /// A share of the breakaway torque, or of the largest acceleration: a few thousand roundings, as both are
  /// sums over the bodies. Smaller, rounding decides what sticks in long chains; larger, weak starts are not
  /// seen.
  static constexpr double rounding = 1e-12;

  /// tolerance: of rates, per second; 0 without error control.
  StickSlip(const Chain& chain, double tolerance);
  /// Reserves memory for lists of all joints: call it after a copy. Allocates.
  void reserve();

  // ---- The joints ---------------------------------------------------------------------------------------

  /// The joints with friction. stuck() and loose() are those of them that stick, and that are loose.
  const std::vector<int>& joints() const { return joints_; }
  /// Joints whose friction is too weak for the tolerance.
  const std::vector<int>& leftOut() const { return leftOut_; }
  const std::vector<int>& stuck() const { return stuck_; }
  const std::vector<int>& loose() const { return loose_; }
  bool slips(int joint) const { return direction_[joint] != 0; }
  bool isLoose(int joint) const { return isLoose_[joint]; }
  /// The sign of q̇, 0: stuck, loose, or without friction.
  double direction(int joint) const { return direction_[joint]; }
  /// The angle of a stuck joint, rad.
  double angle(int joint) const { return angle_[joint]; }
  double friction(int joint) const { return sliding_[joint]; }
  double breakaway(int joint) const { return breakaway_[joint]; }
  /// True if a breakaway torque is larger than the friction.
  bool hasBreakaway() const { return hasBreakaway_; }
  /// The torque of friction in each joint, N m: −c sign(q̇) of those that slip, and what loose ones bear.
  auto torques() const { return -(direction_ + push_) * sliding_; }
  /// The torques of friction as moments on the bodies, N m.
  const Eigen::VectorXd& moments() const { return moments_; }

  // ---- What is due ---------------------------------------------------------------------------------------

  /// |x_i| + |x_k|: the rounding of the coordinate q_i = x_i − x_k, or of its rate, counts by it.
  double sumOfSizes(int joint, const double* x) const {
    const int inner = coordinates_.inner(joint);
    return std::abs(x[joint]) + (inner >= 0 ? std::abs(x[inner]) : 0);
  }
  /// How far a slipping joint is past its rest, rad/s. ≤ 0: it slips on. Far below 0 unless it slips.
  double slipPastRest(int joint, const double* omega) const;
  /// slipPastRest() of all joints.
  void findSlipPastRest(const double* omega, double* due) const;
  /// Their derivatives, but for rounding, rad/s².
  void findSlipSlope(const double* alpha, double* slope) const;
  /// True if the rate is rounding.
  bool isAtRest(int joint, const double* omega) const;
  /// How far a loose joint has come to slip, rad/s.
  double looseDue(int joint, const double* omega) const;
  /// The derivative of that, rad/s².
  double looseSlope(int joint, const double* omega, const double* alpha) const;
  /// The least |q̇| of a loose joint that counts, rad/s, of a prismatic joint m/s.
  double looseRate(int joint) const;
  /// |μ| that releases a stuck joint, N m.
  double limit(int joint) const { return breakaway_[joint] + band_[joint]; }
  double stickDue(int joint, const double* moments) const { return std::abs(moments[joint]) - limit(joint); }

  /// a of the band: the least |q̈| that counts, rad/s².
  double leastStart(int joint) const { return ownBand(joint) * mostYield_[joint]; }

  // ---- Transitions: take() ends them ---------------------------------------------------------------------

  /// Sets a joint by its rate. One at rest sticks.
  void enter(int joint, const double* y);
  /// A slipping joint has come to rest at the state y. It sticks, or reverses if `passes`.
  void rest(int joint, const double* y, bool passes);
  /// A joint is exactly at rest at the state y, whether it has moved or not. It sticks.
  void stay(int joint, const double* y);
  /// A joint at rest starts in this direction; 0: it sticks.
  void start(int joint, double direction);
  /// All joints stick, slip and are loose as those of another chain of this kind.
  void takeFrom(const StickSlip& other) {
    direction_ = other.direction_;
    isLoose_ = other.isLoose_;
    push_ = other.push_;
    angle_ = other.angle_;
  }
  /// A joint starts with this |q̈|, of which rounding may give `rounded`, rad/s².
  void startWith(int joint, double start, double rounded);
  /// A stuck joint gets loose. push: the direction against which its friction acts; 0: none.
  void loosen(int joint, double push);
  /// A loose joint slips as it moves.
  void slip(int joint, const double* omega);
  /// Widens the band of a stuck joint to so many times what this torque asks for.
  void holdAt(int joint, double moment, double widening);
  /// Lists the stuck and the loose joints, and sums the moments. Returns true if other joints stick than
  /// before.
  bool take();

  void saveOrRestore(Snapshot& snapshot) {
    snapshot(stuck_, before_, loose_, band_, direction_, never_, isLoose_, startsClearly_, push_, angle_,
             moments_);
  }

 private:
  struct Rate {
    double value;     ///< q̇, rad/s
    double rounding;  ///< of it, rad/s
  };

  Rate rateOf(int joint, const double* omega) const;
  double ownBand(int joint) const;

  Coordinates coordinates_;
  int n_;
  double tolerance_;
  bool hasBreakaway_ = false;
  std::vector<int> joints_, leftOut_, stuck_, before_, loose_;
  // One number for each joint:
  Numbers sliding_, breakaway_;  ///< torques, N m
  Numbers mostYield_;            ///< Y
  Numbers unit_;                 ///< of the tolerance: 1, or the reach, m, of a prismatic joint
  Numbers band_;                 ///< N m
  Numbers direction_;            ///< of q̇; 0: stuck, or no friction
  Numbers never_;                ///< 0 if it slips, else far below 0
  Eigen::Array<bool, Eigen::Dynamic, 1> isLoose_, startsClearly_;
  Numbers push_;             ///< of a loose joint, else 0
  Numbers angle_;            ///< where it was at rest last, from body to body
  Eigen::VectorXd moments_;  ///< on the bodies, N m
};

}  // namespace planar_chain
