#pragma once

/// When ticks are due and how they are stamped: wall time, a /clock of the node's own, or one that it
/// follows. Which, is chosen once. What the ticks do knows nothing of it, so the motion is the same by any
/// clock.
///
/// Tick k is stamped s_0 + (k − k_0)/rate, rounded to ns, with (k_0, s_0) where the stamps last began.

#include <ros/time.h>

#include <cstdint>
#include <memory>
#include <string>

#include "planar_chain/scene.h"

namespace planar_chain {

class Clock {
 public:
  explicit Clock(double rate) : rate_(rate) {}
  virtual ~Clock() = default;

  /// In words, such as "the wall clock".
  virtual std::string name() const = 0;
  /// Empty: it goes. Else why no tick can be due.
  virtual std::string standstill() const { return ""; }
  /// Whether it is known what time it is; nothing can be stamped before.
  virtual bool hasBegun() const { return true; }
  /// The first tick that may be stamped: time 0 never is.
  virtual long long firstTick() const { return 0; }

  /// Sim time goes on, after the start or a standstill: tick `next` is due at once.
  virtual void begin(long long next) = 0;
  /// The last tick whose time has come. Ticks from `next` on that are too far behind are given up: their
  /// times come later then.
  virtual long long due(long long next) = 0;
  /// s of wall time until tick `next` is due, as far as that can be told.
  virtual double untilDue(long long next) const = 0;
  /// s of wall time between stretches of ticks that are being made up for.
  virtual double breather() const { return 0; }
  /// s by which tick `done` is behind, given-up time included.
  virtual double lag(long long done) const = 0;
  /// Given up in all, s.
  virtual double givenUp() const { return 0; }

  /// What time it is by this clock.
  virtual ros::Time now() const = 0;
  /// Tells the time of a tick to all who listen, where this clock is their clock.
  virtual void tell(long long /*tick*/) {}
  /// The same time again, for those who came late.
  virtual void tellAgain() {}

  ros::Time stampOf(long long tick) const;
  std::int64_t ns(long long tick) const;  ///< the same in ns
  /// The tick k_0.
  long long stampsBegan() const { return tick0_; }

 protected:
  double rate() const { return rate_; }
  void beginStamps(long long tick, std::int64_t stamp);

 private:
  double rate_;
  long long tick0_ = 0;
  std::int64_t stamp0_ = 0;
};

/// The one that a scene asks for: with real_time_factor one of its own, else the one that /use_sim_time says.
std::unique_ptr<Clock> makeClock(const Scene& scene);

}  // namespace planar_chain
