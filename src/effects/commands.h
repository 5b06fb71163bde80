#pragma once

/// What a user commands while the chain moves: torques in joints, forces and moments on links.
///
/// Held commands act until the next one for the same joint or link replaces them, or until their window ends.
/// Timed commands add up. A command that starts later than now waits. timed_terms.h has what they do.

#include <vector>

#include "effects/timed_terms.h"

namespace planar_chain {

class CommandEffect : public TimedTerms {
 public:
  /// For a chain of n links. capacity: how many commands may be timed, or wait for their start. Allocates;
  /// nothing else does but inForce().
  CommandEffect(int n, int capacity);

  struct Torque {
    int index = 0;  ///< of the joint
    double torque = 0;
    Window window;
  };
  struct Force {
    int index = 0;  ///< of the link
    Vec2d point, force;
    double moment = 0;
    Window window;
  };

  // A command that has started is in force from the next enter() on. One that starts after `now` shortens
  // until() and changes nothing else.
  /// @returns false, and nothing changes, when there is no room for one more that waits or is timed
  bool hold(const Torque& command, double now) { return hold(torques_, command, now); }
  bool hold(const Force& command, double now) { return hold(forces_, command, now); }
  bool add(const Torque& command, double now) { return add(torques_, command, now); }
  bool add(const Force& command, double now) { return add(forces_, command, now); }
  void clear();
  /// Returns those that are in force at t, as loads of a scene would say it.
  std::vector<Load> inForce(double t) const;

 private:
  /// Held: one each joint or link. Waiting: in order of their starts, to be held from then on.
  template <class Command>
  struct Lists {
    std::vector<Command> held, waiting, timed;
  };

  void list(double t) override;
  template <class Command>
  void bringForward(Lists<Command>& commands, double t);
  template <class Command>
  bool hold(Lists<Command>& commands, const Command& command, double now);
  template <class Command>
  bool add(Lists<Command>& commands, const Command& command, double now);
  bool hasRoom() const;

  std::size_t capacity_;
  Lists<Torque> torques_;
  Lists<Force> forces_;
};

}  // namespace planar_chain
