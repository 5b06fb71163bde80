#pragma once

/// Commands of a user while the chain moves: torques in joints, forces and moments on links.
///
/// Held commands act until the next one for the same joint or link replaces them, or until they end. Timed
/// commands add up. A command that starts later than now waits. timed_terms.h has what they do.
///
/// Where a joint has a dead time (`command_delay`), a torque in it starts and stops that much later. Where a
/// joint has an effort limit, the sum of the commanded torques in it is cut off there. A joint with a motor
/// is moved by the motor alone (motors.h), which takes this sum.

#include <limits>
#include <vector>

#include "effects/effect_kind.h"
#include "effects/timed_terms.h"
#include "planar_chain/linear_motor.h"

namespace planar_chain {

/// Acts in a joint or on a link, as a Load, in start ≤ t < stop.
struct Command {
  int link = Load::none;
  Vec2d force, point;
  double moment = 0;
  int joint = Load::none;
  double torque = 0;
  double start = 0, stop = -std::numeric_limits<double>::infinity();
};

class CommandEffect : public TimedTerms {
 public:
  /// capacity: how many commands may be timed, or wait for a start that is given. Commands that wait for a
  /// dead time alone are not counted. Allocates; inForce() does too, and hold() if more commands than ever
  /// before are in their dead time.
  CommandEffect(const Chain& chain, int capacity);

  // A command that has started is in force from the next enter() on. One that starts after `now` shortens
  // until() and changes nothing else.
  /// @returns false, and nothing changes, when there is no room for one more that waits or is timed
  bool hold(const Command& command, double now);
  bool add(const Command& command, double now);
  void clear();
  /// Returns what acts at t, as loads of a scene would say it. omega: the rates ω, in chain order; nullptr:
  /// at rest, with motors that have reached what is commanded.
  virtual std::vector<Load> inForce(double t, const double* omega) const;
  /// Returns the joints whose commanded torques do not act as they are: cut off, or through a motor.
  virtual std::vector<LinearMotor> motorsAt(double t, const double* omega) const;
  /// Lets motors reach what is commanded at t at once.
  virtual void finish(double /*t*/) {}
  /// True if a command for this joint acts from its start on; `none`: for a link.
  bool isPrompt(int joint) const { return delayOf(joint) == 0; }
  /// The dead time of commands for this joint, s; `none`: of those for a link.
  double delayOf(int joint) const { return joint == Load::none ? 0 : delays_[index(joint)]; }
  /// The torque in a joint per torque that is commanded in it and has acted for so many s.
  double shareOf(int joint, double acting) const { return isCutOff(joint) ? 0 : passedOn(joint, acting); }
  /// The torque in a joint per torque that was in the lag of its motor so many s before.
  virtual double shareOfLag(int /*joint*/, double /*since*/) const { return 0; }
  /// The torque in the lag of a joint's motor at t, N m; without a lag the commanded one, cut off at its
  /// limit.
  virtual double motorTorque(double t, int joint) const { return torqueAt(t, index(joint)); }
  /// Sets it, if there is a lag.
  virtual void setMotorTorque(double /*t*/, int /*joint*/, double /*torque*/) {}
  void remember() override { remembered_ = cut_; }
  void recall() override { cut_ = remembered_; }
  void saveOrRestore(Snapshot& snapshot) override {
    TimedTerms::saveOrRestore(snapshot);
    snapshot(held_, waiting_, timed_, cut_.sides, cut_.counts);
  }
  /// Returns how often the torque in each joint came to be cut off.
  const std::vector<long long>& cutOffs() const { return cut_.counts; }

 protected:
  void list(double t) override;
  /// The sum of the torques commanded in a joint at t, N m, cut off at its limit.
  double torqueAt(double t, std::size_t joint) const;

 private:
  /// True if a motor gives the joint's commanded torques.
  virtual bool hasMotor(int /*joint*/) const { return false; }
  /// As shareOf(), without the limit.
  virtual double passedOn(int /*joint*/, double /*acting*/) const { return 1; }
  bool hasRoom(double now) const;
  /// The command as it acts: after its dead time.
  Command delayed(Command command, double now) const;
  /// The index in held_ for commands of the same joint or link.
  std::size_t slotOf(const Command& command) const;
  /// The sum of the torques in a joint at t.
  double sumAt(double t, std::size_t joint) const;
  /// ±1 if that is above or below the limit, else 0.
  int sideAt(double t, std::size_t joint) const;
  /// Notes where that is so, and lists the limit in place of the commands.
  void cutOff(double t);
  bool isCutOff(int joint) const { return joint != Load::none && cut_.sides[index(joint)] != 0; }

  std::size_t capacity_;
  std::vector<Command> held_;     ///< of each joint, then of each link
  std::vector<Command> waiting_;  ///< to be held, in the order in which they will act
  std::vector<Command> timed_;
  std::vector<double> limits_;  ///< N m; infinite: no limit
  std::vector<double> delays_;  ///< s
  struct Cut {
    std::vector<int> sides;         ///< ±1 above or below the limit; 0: not cut off
    std::vector<long long> counts;  ///< how often it came to be
  } cut_, remembered_;              ///< of each joint
};

/// Key `effort_limit` of a joint.
const EffectKind& effortKind();

}  // namespace planar_chain
