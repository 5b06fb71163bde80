#pragma once

/// When a tick is due, and its stamp. There are three kinds of clock: wall time, a /clock that the node
/// publishes, and an external /clock. The simulation does not depend on the kind, so the motion is the same
/// with each.
///
/// The stamp of tick k is s_0 + (k − k_0)/rate, rounded to ns. k_0 is the tick at which the stamps last
/// began. Tick k is due when the clock's reading is at least its stamp + the delay that was dropped.

#include <ros/time.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "planar_chain/scene.h"
#include "ros/messages/ticks.h"

namespace planar_chain {

class Clock {
 public:
  /// rate: ticks per s; speed: s of this clock per s of wall time, 0: unknown; name: in words, such as "the
  /// wall clock".
  Clock(double rate, double speed, std::string name) : speed_(speed), rate_(rate), name_(std::move(name)) {}
  virtual ~Clock() = default;

  const std::string& name() const { return name_; }
  /// Returns why no tick can become due. Empty while the clock runs.
  virtual std::string haltedBy() const { return ""; }
  /// False until the time is known. Nothing can be stamped before.
  virtual bool hasBegun() const { return true; }
  /// The first tick with a stamp. Its stamp is never 0.
  virtual long long firstTick() const { return 0; }

  /// Starts, or continues after a halt: tick `next` is due at once, or one tick after the last if that is
  /// later.
  virtual void begin(long long next);
  /// Returns the last tick that is due. If `next` is due for more than a second, drops the delay and warns.
  virtual long long due(long long next);
  /// Returns the wall time until tick `next` is due, s. Infinite if unknown.
  double untilDue(long long next) const;
  /// Returns the pause between two bursts of late ticks, s of wall time.
  double catchUpPause() const { return speed_ > 0 ? 1 / (rate_ * speed_) : 0; }
  /// Returns the delay of tick `done`, s, dropped time included. Negative if the tick is early.
  double lag(long long done) const;
  /// Returns how often a delay was dropped.
  std::uint64_t drops() const { return drops_; }
  /// Returns how often the stamps restarted because the clock jumped.
  std::uint64_t jumps() const { return jumps_; }

  virtual ros::Time now() const;
  /// Publishes the time of a tick, if the node owns /clock.
  virtual void publish(long long /*tick*/) {}
  /// Publishes the same time again, for late subscribers.
  virtual void publishAgain() {}

  ros::Time stampOf(long long tick) const;
  std::int64_t ns(long long tick) const;            ///< the same in ns
  long long stampOrigin() const { return tick0_; }  ///< k_0

 protected:
  virtual std::int64_t read() const = 0;  ///< ns
  /// Drops the delay of tick `next`, ns.
  virtual void drop(long long /*next*/, std::int64_t behind) { late_ += behind; }
  /// For the log: why a delay is dropped.
  virtual std::string whyLate() const { return "simulation time cannot keep up with " + name_; }
  /// Restarts the stamps: tick `next` has this one, in ns.
  void beginAt(long long next, std::int64_t stamp);
  /// Restarts the stamps at the present reading, after a jump of the clock.
  void restart(long long next);

  const double speed_;

 private:
  double rate_;
  std::string name_;
  long long tick0_ = 0;
  std::int64_t stamp0_ = 0, late_ = 0, lateAtBegin_ = 0;  ///< ns
  std::uint64_t drops_ = 0, jumps_ = 0;
  Every warnings_{5};
};

/// Returns a /clock of the node if the scene has a real_time_factor. Else /use_sim_time chooses between an
/// external /clock and the wall clock.
std::unique_ptr<Clock> makeClock(const Scene& scene);

}  // namespace planar_chain
