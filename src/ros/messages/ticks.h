#pragma once

/// Stamps, tick times and periodic actions.

#include <ros/time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace planar_chain {

/// The end of ros::Time, ns.
inline constexpr std::int64_t endOfTime = (std::int64_t{1} << 32) * 1'000'000'000;

/// @throws std::range_error beyond the end of ros::Time
inline ros::Time timeOf(std::int64_t ns) {
  if (ns >= endOfTime) throw std::range_error("time has passed 2^32 s, where the stamps of ROS end");
  return ros::Time().fromNSec(static_cast<std::uint64_t>(ns));
}

/// The ticks of a node, counted from its start. Times are computed from the index: tick k is at k/rate.
struct Ticks {
  double rate;             ///< Hz
  long long first = 0;     ///< the first tick with a stamp
  long long next = first;  ///< the next tick
  long long origin = 0;    ///< the tick of scene time 0
  long long set = 0;  ///< the tick that shows the initial state, or the last one that ~reset or ~settle set

  double timeOf(long long tick) const { return static_cast<double>(tick) / rate; }  ///< s
  /// Rounded.
  std::int64_t nanosecondsOf(long long tick) const {
    return std::llround(
        std::min(static_cast<long double>(tick) * 1e9L / static_cast<long double>(rate), 9e18L));
  }
  double sceneTime(long long tick) const { return timeOf(tick - origin); }       ///< s
  double simTime(double sceneTime) const { return timeOf(origin) + sceneTime; }  ///< since the start, s

  /// True if an action at `frequency` (Hz, at most rate) is due at this tick. Tick 0 and the tick of a
  /// state that was set are always due.
  bool isDue(long long tick, double frequency) const {
    constexpr double rounding = 1e-6;  // of a period: covers that of the quotient up to 1e9 periods
    const auto happened = [&](long long k) {
      return std::floor(static_cast<double>(k) * frequency / rate + rounding);
    };
    return tick == set || tick == 0 || frequency == rate || happened(tick) > happened(tick - 1);
  }
};

/// The time of the steady clock, s.
inline double steadyTime() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A periodic action in steady time.
class Every {
 public:
  /// period: s.
  explicit Every(double period) : period_(period) {}

  /// True once per period, first at the first call. Missed periods are skipped.
  bool isDue() {
    const double now = steadyTime();
    if (now < next_) return false;
    next_ += period_;
    if (next_ <= now) next_ = now + period_;
    return true;
  }

 private:
  double period_;
  double next_ = 0;
};

}  // namespace planar_chain
