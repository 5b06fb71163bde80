#pragma once

/// Tick times, periodic actions and the real-time factor.

#include <chrono>
#include <cmath>
#include <cstdint>
#include <deque>

namespace planar_chain {

/// Tick times, computed from the index: tick k is at k/rate.
class Pace {
 public:
  /// rate: Hz.
  explicit Pace(double rate) : rate_(rate) {}

  double timeOf(long long tick) const { return static_cast<double>(tick) / rate_; }  ///< s
  /// Rounded.
  std::int64_t nanosecondsOf(long long tick) const {
    return std::llround(static_cast<long double>(tick) * 1e9L / static_cast<long double>(rate_));
  }

  /// True if an action at `frequency` (Hz, at most rate) is due at this tick. Tick 0 is always due.
  bool isDue(long long tick, double frequency) const {
    // The millionth of a period covers the rounding of the quotient.
    const auto happened = [&](long long k) {
      return std::floor(static_cast<double>(k) * frequency / rate_ + 1e-6);
    };
    return tick == 0 || happened(tick) > happened(tick - 1);
  }

 private:
  double rate_;
};

/// The ticks of a node, counted from its start.
struct Ticks {
  Pace pace;
  long long next = 0;    ///< the next tick
  long long origin = 0;  ///< the tick of scene time 0

  /// True if an action at `frequency` (Hz) is due at this tick. The tick of scene time 0 is always due.
  bool isDue(long long tick, double frequency) const { return tick == origin || pace.isDue(tick, frequency); }
  double sceneTime(long long tick) const { return pace.timeOf(tick - origin); }       ///< s
  double simTime(double sceneTime) const { return pace.timeOf(origin) + sceneTime; }  ///< since the start, s
};

/// A periodic action in wall time.
class Every {
 public:
  /// period: s.
  explicit Every(double period) : period_(period) {}

  /// True once per period, first at the first call. Missed periods are skipped.
  bool isDue() {
    const double now =
        std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    if (now < next_) return false;
    next_ += period_;
    if (next_ <= now) next_ = now + period_;
    return true;
  }

 private:
  double period_;
  double next_ = 0;
};

/// Simulation time per wall time over the last few seconds.
class RealTimeFactor {
 public:
  /// samples: how many calls of sample() to look back.
  explicit RealTimeFactor(std::size_t samples) : most_(samples + 1) {}

  /// Returns the factor since the oldest sample kept. The first call returns 0. Times in s.
  double sample(double simTime, double wallTime) {
    samples_.push_back({simTime, wallTime});
    if (samples_.size() > most_) samples_.pop_front();
    const auto [sim, wall] = samples_.front();
    return wallTime > wall ? (simTime - sim) / (wallTime - wall) : 0;
  }

 private:
  struct Sample {
    double sim, wall;
  };
  std::size_t most_;
  std::deque<Sample> samples_;
};

}  // namespace planar_chain
