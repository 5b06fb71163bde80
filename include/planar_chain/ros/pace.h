#pragma once

/// Wall time cut into ticks. Times are s on a steady clock since the start; tick k belongs to sim time
/// k/rate, computed from the index.

#include <cstdint>
#include <vector>

namespace planar_chain {

class Pace {
 public:
  explicit Pace(double rate) : rate_(rate) {}

  double timeOf(long long tick) const { return static_cast<double>(tick) / rate_; }
  /// The same, rounded to whole ns.
  std::int64_t nanosecondsOf(long long tick) const;

  /// The last tick whose time has come at `now`.
  long long due(double now) const;

  /// When `next` is more than `patience` late, shifts the clock so that it is due at `now`: what was
  /// missed is not made up for.
  /// @returns s given up; 0: none.
  double giveUp(double now, long long next, double patience);

  /// Given up since the start, s.
  double givenUp() const { return givenUp_; }

  /// Whether something that happens `frequency` times a second (at most rate) falls on this tick;
  /// tick 0 always does.
  bool falls(long long tick, double frequency) const;

 private:
  double rate_;
  double givenUp_ = 0;
};

/// Sim time per wall time over the last few seconds.
class RealTimeFactor {
 public:
  /// Looks back over `samples` calls of sample().
  explicit RealTimeFactor(int samples) : ring_(static_cast<std::size_t>(samples)) {}

  /// @returns the factor since the oldest sample that is kept; 0 for the first.
  double sample(double simTime, double wallTime);

 private:
  struct Sample {
    double sim = 0;
    double wall = 0;
  };
  std::vector<Sample> ring_;
  std::size_t taken_ = 0;
};

}  // namespace planar_chain
