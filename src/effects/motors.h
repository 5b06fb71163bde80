#pragma once

/// Motors: what becomes of the torques that are commanded in a joint.
///
///     commands, after their dead time → sum u, cut off at ± L → lag → x → torque–speed line → torque τ
///
///     T ẋ = u − x         x(t) = u + (x_0 − u) exp(−(t − t_0)/T)        t_0: the last change of u; x(t_0) =
///     x_0 |τ| ≤ L (1 − s q̇/ω_0)     s = sign x                              L: effort_limit, ω_0:
///     no_load_speed
///
/// u is constant from one command to the next, so x is exact. The line comes last. It is a function of q̇
/// alone and leaves x as it is. With m = s x ≥ 0 and l = L (1 − s q̇/ω_0), a motor is
///
///     free      m < l            τ = x
///     on the line      0 < l < m        τ = s l = s L − (L/ω_0) q̇: a damper
///     idle      l < 0, m > 0     τ = 0: faster than ω_0 it does not drive, and does not brake
///
/// Where it brakes, s q̇ < 0, the line is above L, and the cut off of u holds: |τ| ≤ L. τ is continuous. It
/// has a corner at each change, where the integrator lands (ode/switches.h).
///
/// x is part of the state of a simulation: 0 at the start and after a reset. It stays if a state is set.

#include <memory>
#include <vector>

#include "effects/commands.h"

namespace planar_chain {

/// Keys of a joint; the first two stand in the map `motor`.
inline constexpr const char* noLoadSpeed = "motor/no_load_speed";
inline constexpr const char* timeConstant = "motor/time_constant";

/// True if the joint has a motor or a dead time: a linear model has neither.
bool changesCommands(const Joint& joint);

/// The motor of one joint.
class Motor {
 public:
  Motor(const Coordinates& coordinates, int joint, const Joint& values);

  Coordinate q;  ///< of the joint

  // ---- The lag --------------------------------------------------------------------------------------

  /// u from t on.
  void command(double t, double u);
  void finish() {
    x0_ = u_;
    isNew_ = true;
  }
  /// x at t, N m.
  double lagged(double t) const;
  double rate(double t) const { return lag_ > 0 ? (u_ - lagged(t)) / lag_ : 0; }
  /// True if x changes from t on.
  bool isLagging(double t) const { return lag_ > 0 && lagged(t) != u_; }
  bool hasLag() const { return lag_ > 0; }
  /// Returns the coefficient k > 0 of the Taylor series of x around t. Call it for 1, 2, … in turn.
  double order(int k, double t);

  // ---- The line --------------------------------------------------------------------------------------

  bool hasLine() const { return slope_ > 0; }
  /// The torque for x at the rate q̇, whatever the place.
  double torqueOf(double x, double rate) const;
  /// The torque in the present place.
  double torque(double t, const double* omega) const;
  /// −∂τ/∂q̇ in the present place.
  double damping() const { return place_ == Place::line ? slope_ : 0; }
  bool isFree() const { return place_ == Place::free; }

  /// Chooses the place. At its edge, the line acts.
  void choose(double t, const double* omega);
  /// How far another place is due, N m; ≤ 0: it is not.
  double due(double t, const double* omega) const;
  bool isDue(double t, const double* omega) const { return isNew_ || due(t, omega) > 0; }
  /// The time within a stretch at which a change may hide, or −1. n: of joints.
  double hidden(const ode::Stretch& of, int n) const;

 private:
  enum class Place { free, line, idle };

  /// l
  double limitAt(double side, double rate) const { return limit_ - side * slope_ * rate; }
  double signOf(double x) const { return x < 0 || (x == 0 && u_ < 0) ? -1 : 1; }
  /// Two functions of x and q̇, N m. A change is due where one is positive; from `free` only if s x is, too.
  double gap(int which, double x, double rate) const;

  double limit_, slope_, lag_;  ///< L, N m; L/ω_0, N m s/rad, 0: no line; T, s, 0: no lag
  double u_ = 0, x0_ = 0, t0_ = 0;
  double coefficient_ = 0;  ///< of the last order
  Place place_ = Place::free;
  double side_ = 1;     ///< s, unless it is free
  bool isNew_ = false;  ///< u has changed since choose()
};

/// Commands in a chain with motors.
class MotorCommands final : public CommandEffect, public Switching {
 public:
  MotorCommands(const Chain& chain, int capacity);

  std::vector<Load> inForce(double t, const double* omega) const override;
  void finish(double t) override;

  LoadKind acting() const override;
  bool variesWithTime() const override { return isLagging_ || CommandEffect::variesWithTime(); }
  Powers apply(const ChainState& at, const Actions& to) override;
  void addTorques(const ChainState& at, double* tau) override;
  void addStiffness(double* k, double* d) const override;
  Powers powersAlong(const ChainState& at, const StateChange& along) override;
  Powers applyRates(const ChainState& at, const Actions& to) override;
  void addOrder(int k, const Series& known, const Actions& to) override;

  Switching* switching() override { return hasLines_ ? this : nullptr; }
  void enterState(double t, const double* y) override;
  void change(double t, double* y, const ode::Crossing& found) override;
  double due(double t, const Eigen::VectorXd& y) const override;
  double nearest(const ode::Stretch& of) const override;

 private:
  void list(double t) override;
  bool hasMotor(int joint) const override {
    return joint != Load::none && has_[static_cast<std::size_t>(joint)];
  }

  Coordinates coordinates_;
  int n_;
  std::vector<Motor> motors_;
  std::vector<bool> has_;  ///< of each joint: a motor
  bool hasLines_ = false, isLagging_ = false, act_ = false;
};

/// The effect of commands in this chain; nullptr if there may be none.
std::unique_ptr<CommandEffect> makeCommands(const Chain& chain, int capacity);

/// Keys `motor` and `command_delay` of a joint.
const EffectKind& motorKind();

}  // namespace planar_chain
