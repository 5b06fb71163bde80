#pragma once

#include <chrono>
#include <thread>

namespace planar_chain {

/// For messages that are recorded: rosbag keeps 100 of a topic until it has written them, and loses others.
/// So many are published at once, and then no more until the time for these has passed.
class Rests {
 public:
  /// seconds: of wall time.
  Rests(int atOnce, double seconds) : atOnce_(atOnce), time_(seconds) {}

  /// True if one more message may be published now; it counts then.
  bool allowOne() {
    const auto now = Clock::now();
    if (now >= until_) {
      until_ = now + std::chrono::duration_cast<Clock::duration>(time_);
      count_ = 0;
    }
    return count_ < atOnce_ && ++count_ > 0;
  }
  /// Sleeps until it is, and counts one.
  void waitForOne() {
    while (!allowOne()) std::this_thread::sleep_until(until_);
  }

 private:
  using Clock = std::chrono::steady_clock;

  int atOnce_, count_ = 0;
  std::chrono::duration<double> time_;
  Clock::time_point until_{};
};

}  // namespace planar_chain
