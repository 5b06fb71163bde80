#include "ros/node/clock.h"

#include <ros/console.h>
#include <ros/node_handle.h>
#include <ros/param.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "planar_chain/fault.h"
#include "ros/view/messages.h"

namespace planar_chain {

namespace {

constexpr double longestLag = 1;     // s: a longer one is dropped
constexpr double leastJump = 0.1;    // s by which the wall clock is set; a smaller one is caught up with
constexpr double mostSlewed = 1e-3;  // s per s by which it is slewed
constexpr double haltsAfter = 1;     // s of wall time without a new time on an external /clock
constexpr double beginsWithin = 2;   // s of wall time, without a warning
constexpr double warningPeriod = 30, messagePeriod = 5;  // s
constexpr std::uint32_t queue = 100;

std::int64_t wallTime() {
  return static_cast<std::int64_t>(ros::WallTime::now().toNSec());
}

double seconds(std::int64_t ns) {
  return static_cast<double>(ns) / 1e9;
}

/// A clock that others set. When it jumps, the simulation continues from its present state, and the stamps
/// restart at the clock's time: back too, as ros::Time::now() goes back for every other node then.
class FollowedClock : public Clock {
 public:
  using Clock::Clock;

  void begin(long long next) override {
    if (!follow(next) && hasBegun()) beginAt(next, std::max(read(), ns(next)));
  }

  long long due(long long next) override {
    follow(next);
    return hasBegun() ? Clock::due(next) : next - 1;
  }

 private:
  /// True if the clock has been set since the last call.
  virtual bool hasJumped() = 0;

  bool follow(long long next) {
    const bool jumped = hasJumped();
    if (jumped) restart(next);
    return jumped;
  }
};

/// The time of day.
class WallClock : public FollowedClock {
 public:
  explicit WallClock(double rate) : FollowedClock(rate, 1, "the wall clock") {}

 private:
  /// Compares the clock with the steady one since the last call. Both are read at once: a pause in between
  /// must not look like a jump.
  bool hasJumped() override {
    const std::int64_t wallBefore = wall_;
    const double steadyBefore = steady_;
    do {
      steady_ = steadyTime();
      wall_ = read();
    } while (steadyTime() - steady_ > leastJump / 10);
    const double elapsed = steady_ - steadyBefore;
    const double jump = seconds(wall_ - wallBefore) - elapsed;
    if (std::fabs(jump) <= leastJump + mostSlewed * elapsed) return false;
    ROS_WARN("the wall clock jumped by %+.3f s: the simulation continues from its present state", jump);
    return true;
  }

  std::int64_t read() const override { return wallTime(); }

  std::int64_t wall_ = read();
  double steady_ = steadyTime();  ///< s
};

/// A /clock that another node publishes.
class ExternalClock : public FollowedClock {
 public:
  explicit ExternalClock(double rate)
      : FollowedClock(rate, 0, "an external /clock"),
        subscriber_(ros::NodeHandle().subscribe("/clock", queue, &ExternalClock::onClock, this,
                                                ros::TransportHints().tcpNoDelay())) {
    // roscpp has its own subscriber, and may have received a time before this one.
    take(ros::Time::now());
  }

  bool hasBegun() const override { return reading_ > 0; }

  std::string haltedBy() const override {
    if (!hasBegun()) return "/clock has not begun";
    if (reading_ == latest) return "/clock is within a day of 2^32 s, where the stamps of ROS end";
    return steadyTime() - changed_ < haltsAfter ? "" : "/clock stands still";
  }

  /// Wall time before the clock begins, so that ~status can be sent.
  ros::Time now() const override { return hasBegun() ? Clock::now() : timeOf(wallTime()); }

 private:
  bool hasJumped() override {
    if (!hasBegun() && steadyTime() - start_ > beginsWithin && warnings_.isDue()) {
      ROS_WARN(
          "/use_sim_time is true, but no time has come on /clock for %.0f s: nothing moves. Start the node "
          "that "
          "publishes /clock, or set /use_sim_time to false and start this node again",
          steadyTime() - start_);
    }
    return std::exchange(jumped_, false);
  }

  void onClock(const rosgraph_msgs::Clock& message) { take(message.clock); }

  void take(ros::Time time) {
    const auto reading = std::min(static_cast<std::int64_t>(time.toNSec()), latest);
    if (reading == reading_) return;
    jumped_ = jumped_ || reading < reading_ || reading_ == 0;
    if (reading < reading_ && messages_.isDue()) {
      ROS_INFO("/clock went back to %.3f s: the simulation continues from its present state",
               seconds(reading));
    }
    reading_ = reading;
    changed_ = steadyTime();
  }

  std::int64_t read() const override { return reading_; }
  void drop(long long next, std::int64_t /*behind*/) override { restart(next); }
  // Times on /clock may be lost while a tick takes long, so a jump looks like a delay.
  std::string whyLate() const override {
    return "/clock jumped forward, or simulation time cannot keep up with it";
  }

  static constexpr std::int64_t latest = endOfTime - 86'400'000'000'000;  // stamps may be ahead of it
  std::int64_t reading_ = 0;
  bool jumped_ = false;
  double start_ = steadyTime(), changed_ = start_;  ///< s
  Every warnings_{warningPeriod}, messages_{messagePeriod};
  ros::Subscriber subscriber_;
};

/// A /clock that this node publishes: simulation time since the start, `factor` times as fast as wall time.
class OwnClock : public Clock {
 public:
  OwnClock(double rate, double factor, const std::string& speed)
      : Clock(rate, factor, "its own /clock, " + speed),
        out_(ros::NodeHandle().advertise<rosgraph_msgs::Clock>("/clock", queue)) {}

  long long firstTick() const override { return 1; }
  ros::Time now() const override { return published_.clock; }
  void publish(long long tick) override {
    published_.clock = stampOf(tick);
    publishAgain();
  }
  void publishAgain() override {
    if (!published_.clock.isZero() && hasSubscribers(out_)) out_.publish(published_);
  }

 private:
  std::int64_t read() const override { return std::llround((steadyTime() - start_) * speed_ * 1e9); }

  double start_ = steadyTime();  ///< s
  ros::Publisher out_;
  rosgraph_msgs::Clock published_;
};

/// A /clock of this node that runs as fast as possible: the next tick is always due.
class FreeClock : public OwnClock {
 public:
  explicit FreeClock(double rate)
      : OwnClock(rate, std::numeric_limits<double>::infinity(), "as fast as possible") {}

  void begin(long long /*next*/) override {}
  long long due(long long next) override { return next; }

 private:
  std::int64_t read() const override { return 0; }
};

}  // namespace

void Clock::begin(long long next) {
  const std::int64_t ahead = ns(next) - (read() - late_);
  late_ = read() - ns(next) + std::clamp(ahead, std::int64_t{0}, ns(next) - ns(next - 1));
  lateAtBegin_ = late_;
}

void Clock::beginAt(long long next, std::int64_t stamp) {
  tick0_ = next;
  stamp0_ = stamp;
  late_ = 0;
  Clock::begin(next);
}

void Clock::restart(long long next) {
  if (ns(tick0_) > 0) ++jumps_;
  beginAt(next, read());
}

long long Clock::due(long long next) {
  const std::int64_t behind = read() - late_ - ns(next);
  if (seconds(behind) > longestLag * (speed_ > 0 ? speed_ : 1)) {
    if (warnings_.isDue()) {
      ROS_WARN("%s at %g Hz: dropped %.3f s", whyLate().c_str(), rate_, seconds(behind));
    }
    drop(next, behind);
    ++drops_;
  }

  // Find the last tick with a stamp up to this reading.
  const std::int64_t reading = read() - late_;
  auto last = tick0_ + static_cast<long long>(std::floor(seconds(reading - stamp0_) * rate_));
  while (ns(last) > reading) --last;
  while (ns(last + 1) <= reading) ++last;
  return last;
}

double Clock::untilDue(long long next) const {
  return speed_ > 0 ? seconds(ns(next) + late_ - read()) / speed_ : std::numeric_limits<double>::infinity();
}

double Clock::lag(long long done) const {
  return seconds(read() - lateAtBegin_ - ns(done));
}

ros::Time Clock::now() const {
  return timeOf(read());
}

std::int64_t Clock::ns(long long tick) const {
  return stamp0_ + Ticks{rate_}.nanosecondsOf(tick - tick0_);
}

ros::Time Clock::stampOf(long long tick) const {
  return timeOf(std::max<std::int64_t>(ns(tick), 0));  // a /clock that went back to 0 has no earlier stamp
}

std::unique_ptr<Clock> makeClock(const Scene& scene) {
  const double rate = scene.publish.rate;
  if (scene.realTimeFactor) {
    const double factor = *scene.realTimeFactor;
    if (factor == 0) return std::make_unique<FreeClock>(rate);
    return std::make_unique<OwnClock>(rate, factor, "real_time_factor " + toText(factor));
  }
  if (ros::param::param("/use_sim_time", false)) return std::make_unique<ExternalClock>(rate);
  return std::make_unique<WallClock>(rate);
}

}  // namespace planar_chain
