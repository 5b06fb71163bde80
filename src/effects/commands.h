#pragma once

/// What a user commands while the chain moves: torques in joints, forces and moments on links.
///
/// Held commands act until the next one for the same joint or link replaces them, or until they end. Timed
/// commands add up. A command that starts later than now waits. timed_terms.h has what they do.
///
/// Where a joint has an effort limit, the sum of the commanded torques in it is cut off there.

#include <limits>
#include <vector>

#include "effects/effect_kind.h"
#include "effects/timed_terms.h"

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
  /// capacity: how many commands may be timed, or wait for their start. Allocates; nothing else does but
  /// inForce().
  CommandEffect(const Chain& chain, int capacity);

  // A command that has started is in force from the next enter() on. One that starts after `now` shortens
  // until() and changes nothing else.
  /// @returns false, and nothing changes, when there is no room for one more that waits or is timed
  bool hold(const Command& command, double now);
  bool add(const Command& command, double now);
  void clear();
  /// Returns those that are in force at t, as loads of a scene would say it.
  std::vector<Load> inForce(double t) const;
  /// Returns how often the torque in each joint came to be cut off.
  const std::vector<long long>& cutOffs() const { return cutOffs_; }

 private:
  void list(double t) override;
  bool hasRoom() const { return waiting_.size() + timed_.size() < capacity_; }
  /// The place for held commands of the same joint or link.
  Command& placeOf(const Command& command);
  /// What the sum of the torques in a joint at t is beyond its limit by, N m.
  double overAt(double t, std::size_t joint) const;
  /// Takes that off.
  void cutOff(double t);

  std::size_t capacity_;
  std::vector<Command> held_;     ///< of each joint, then of each link
  std::vector<Command> waiting_;  ///< to be held, in the order of their starts
  std::vector<Command> timed_;
  std::vector<double> limits_;    ///< N m; infinite: no limit
  std::vector<int> sidesCutOff_;  ///< ±1 above or below the limit; 0: not cut off
  std::vector<long long> cutOffs_;
};

/// Key `effort_limit` of a joint.
const EffectKind& effortKind();

}  // namespace planar_chain
