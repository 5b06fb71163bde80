#pragma once

/// Time cut into ticks, and how fast it goes.

#include <cstdint>
#include <vector>

namespace planar_chain {

/// Tick k belongs to time k/rate, computed from the index.
class Pace {
 public:
  explicit Pace(double rate) : rate_(rate) {}

  double timeOf(long long tick) const { return static_cast<double>(tick) / rate_; }
  /// The same, rounded to whole ns.
  std::int64_t nanosecondsOf(long long tick) const;

  /// Whether something that happens `frequency` times a second (at most rate) falls on this tick;
  /// tick 0 always does.
  bool falls(long long tick, double frequency) const;

 private:
  double rate_;
};

/// Something that is done now and then, by a clock of s.
class Every {
 public:
  explicit Every(double period) : period_(period) {}

  /// Whether it is time; at the first call it is. What was missed is not made up for.
  bool falls(double now);
  double next() const { return next_; }

 private:
  double period_;
  double next_ = 0;
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
