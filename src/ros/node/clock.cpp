#include "ros/node/clock.h"

#include <ros/console.h>
#include <ros/node_handle.h>
#include <ros/param.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "planar_chain/fault.h"
#include "ros/messages/pace.h"

namespace planar_chain {

namespace {

using Steady = std::chrono::steady_clock;

constexpr double longestLag = 1;     // s: a longer one is dropped
constexpr double haltsAfter = 1;     // s of wall time without a new time on an external /clock
constexpr double warningPeriod = 5;  // s
constexpr std::uint32_t queue = 100;

std::int64_t wallNow() {
  return static_cast<std::int64_t>(ros::WallTime::now().toNSec());
}

ros::Time timeOf(std::int64_t ns) {
  return ros::Time().fromNSec(static_cast<std::uint64_t>(ns));
}

double seconds(std::int64_t ns) {
  return static_cast<double>(ns) / 1e9;
}

double since(Steady::time_point then) {
  return std::chrono::duration<double>(Steady::now() - then).count();
}

/// A clock with a reading in ns. Tick k is due when the reading is at least the tick's stamp + late_.
class ReadClock : public Clock {
 public:
  /// speed: s of this clock per s of wall time; 0: unknown.
  ReadClock(double rate, double speed, std::string name) : Clock(rate, std::move(name)), speed_(speed) {}

  void begin(long long next) override { schedule(next); }

  long long due(long long next) override {
    const std::int64_t behind = read() - late_ - ns(next);
    if (seconds(behind) > longestLag * (speed_ > 0 ? speed_ : 1)) {
      dropped_ += behind;
      drop(next, behind);
    }
    return lastBy(read() - late_);
  }

  double untilDue(long long next) const override {
    return speed_ > 0 ? seconds(ns(next) + late_ - read()) / speed_ : std::numeric_limits<double>::infinity();
  }
  double catchUpPause() const override { return speed_ > 0 ? 1 / (rate() * speed_) : 0; }
  double lag(long long done) const override { return seconds(read() - lateAtBegin_ - ns(done)); }
  double dropped() const override { return seconds(dropped_); }
  ros::Time now() const override { return timeOf(read()); }

 protected:
  virtual std::int64_t read() const = 0;
  virtual void drop(long long /*next*/, std::int64_t behind) { late_ += behind; }
  /// Makes tick `next` due at once, or one tick after the last if that is later.
  void schedule(long long next) {
    const std::int64_t ahead = ns(next) - (read() - late_);
    late_ = read() - ns(next) + std::clamp(ahead, std::int64_t{0}, ns(next) - ns(next - 1));
    lateAtBegin_ = late_;
  }
  /// Restarts the stamps: tick `next` has this one.
  void beginAt(long long next, std::int64_t stamp) {
    beginStamps(next, stamp);
    late_ = 0;
    schedule(next);
  }

 private:
  /// The last tick with a stamp up to this reading.
  long long lastBy(std::int64_t reading) const {
    const long long origin = stampOrigin();
    auto last = origin + static_cast<long long>(std::floor(seconds(reading - ns(origin)) * rate()));
    while (ns(last) > reading) --last;
    while (ns(last + 1) <= reading) ++last;
    return last;
  }

  double speed_;
  std::int64_t late_ = 0, lateAtBegin_ = 0, dropped_ = 0;
};

/// The time of day at the last begin() plus steady time. It does not jump when the machine's clock is set.
class WallClock : public ReadClock {
 public:
  explicit WallClock(double rate) : ReadClock(rate, 1, "the wall clock") {}

  void begin(long long next) override {
    start_ = wallNow();
    steadyStart_ = Steady::now();
    beginAt(next, std::max(start_, ns(next)));
  }

 private:
  std::int64_t read() const override {
    return start_ + (Steady::now() - steadyStart_) / std::chrono::nanoseconds(1);
  }

  std::int64_t start_ = wallNow();
  Steady::time_point steadyStart_ = Steady::now();
};

/// A /clock that this node publishes: simulation time since the start, `factor` times as fast as wall time.
class OwnClock : public ReadClock {
 public:
  OwnClock(double rate, double factor, const std::string& pace)
      : ReadClock(rate, factor, "its own /clock, " + pace),
        factor_(factor),
        out_(ros::NodeHandle().advertise<rosgraph_msgs::Clock>("/clock", queue)) {}

  long long firstTick() const override { return 1; }
  ros::Time now() const override { return published_.clock; }
  void publish(long long tick) override {
    published_.clock = stampOf(tick);
    publishAgain();
  }
  void publishAgain() override {
    if (!published_.clock.isZero() && out_.getNumSubscribers() > 0) out_.publish(published_);
  }

 private:
  std::int64_t read() const override { return std::llround(since(start_) * factor_ * 1e9); }

  double factor_;
  Steady::time_point start_ = Steady::now();
  ros::Publisher out_;
  rosgraph_msgs::Clock published_;
};

/// The same as fast as possible: the next tick is always due.
class FreeClock : public OwnClock {
 public:
  explicit FreeClock(double rate) : OwnClock(rate, 0, "as fast as possible") {}

  void begin(long long /*next*/) override {}
  long long due(long long next) override { return next; }
  double untilDue(long long /*next*/) const override { return 0; }
  double lag(long long /*done*/) const override { return 0; }
};

/// A /clock that another node publishes.
class ExternalClock : public ReadClock {
 public:
  explicit ExternalClock(double rate)
      : ReadClock(rate, 0, "an external /clock"),
        subscriber_(ros::NodeHandle().subscribe("/clock", queue, &ExternalClock::onClock, this,
                                                ros::TransportHints().tcpNoDelay())) {
    // roscpp has its own subscriber, and may have received a time before this one.
    take(ros::Time::now());
  }

  bool hasBegun() const override { return reading_ > 0; }

  std::string haltedBy() const override {
    if (!hasBegun()) return "/clock has not begun";
    return since(changed_) < haltsAfter ? "" : "/clock stands still";
  }

  void begin(long long next) override {
    if (hasBegun() && !jumped_) beginAt(next, std::max(reading_, ns(next)));
  }

  long long due(long long next) override {
    if (!hasBegun()) return next - 1;
    if (jumped_) {
      if (reading_ < ns(next - 1) && warnings_.isDue(since(start_))) {
        ROS_INFO("/clock went back to %.3f s; the simulation continues from its present state",
                 seconds(reading_));
      }
      jumped_ = false;
      beginAt(next, reading_);
    }
    return ReadClock::due(next);
  }

  double lag(long long done) const override { return hasBegun() ? ReadClock::lag(done) : 0; }

 private:
  void onClock(const rosgraph_msgs::Clock& message) { take(message.clock); }

  void take(ros::Time time) {
    const auto reading = static_cast<std::int64_t>(time.toNSec());
    if (reading == reading_) return;
    jumped_ |= reading < reading_ || reading_ == 0;
    reading_ = reading;
    changed_ = Steady::now();
  }

  std::int64_t read() const override { return reading_; }

  void drop(long long next, std::int64_t /*behind*/) override { beginAt(next, reading_); }

  std::int64_t reading_ = 0;
  bool jumped_ = false;
  Steady::time_point start_ = Steady::now(), changed_ = start_;
  Every warnings_{warningPeriod};
  ros::Subscriber subscriber_;
};

}  // namespace

std::int64_t Clock::ns(long long tick) const {
  return stamp0_ + Pace(rate_).nanosecondsOf(tick - tick0_);
}

ros::Time Clock::stampOf(long long tick) const {
  return timeOf(ns(tick));
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
