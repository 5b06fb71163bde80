#include "ros/node/clock.h"

#include <ros/console.h>
#include <ros/node_handle.h>
#include <ros/param.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "planar_chain/value.h"
#include "ros/messages/pace.h"

namespace planar_chain {

namespace {

using Steady = std::chrono::steady_clock;

constexpr double patience = 1;       // s of lag that are made up for
constexpr double standsAfter = 1;    // s of wall time without a word of the clock that is followed
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

/// A clock that can be read, in ns: tick k is due when it has come to the tick's stamp + late.
class ReadClock : public Clock {
 public:
  /// speed: s of it per s of wall time, 0 where nobody knows.
  ReadClock(double rate, double speed) : Clock(rate), speed_(speed) {}

  void begin(long long next) override { wait(next); }

  long long due(long long next) override {
    const std::int64_t behind = read() - late_ - ns(next);
    if (seconds(behind) > patience * (speed_ > 0 ? speed_ : 1)) {
      givenUp_ += behind;
      giveUp(next, behind);
    }
    return lastBy(read() - late_);
  }

  double untilDue(long long next) const override {
    return speed_ > 0 ? seconds(ns(next) + late_ - read()) / speed_ : std::numeric_limits<double>::infinity();
  }
  double breather() const override { return speed_ > 0 ? 1 / (rate() * speed_) : 0; }
  double lag(long long done) const override { return seconds(read() - lateAtBegin_ - ns(done)); }
  double givenUp() const override { return seconds(givenUp_); }
  ros::Time now() const override { return timeOf(read()); }

 protected:
  virtual std::int64_t read() const = 0;
  virtual void giveUp(long long /*next*/, std::int64_t behind) { late_ += behind; }
  /// Tick `next` is due at once, but no sooner than a tick after the one before it.
  void wait(long long next) {
    const std::int64_t ahead = ns(next) - (read() - late_);
    late_ = read() - ns(next) + std::clamp(ahead, std::int64_t{0}, ns(next) - ns(next - 1));
    lateAtBegin_ = late_;
  }
  /// Stamps begin anew: tick `next` bears this one.
  void beginAt(long long next, std::int64_t stamp) {
    beginStamps(next, stamp);
    late_ = 0;
    wait(next);
  }

 private:
  long long lastBy(std::int64_t reading) const {
    const long long began = stampsBegan();
    auto last = began + static_cast<long long>(std::floor(seconds(reading - ns(began)) * rate()));
    while (ns(last) > reading) --last;
    while (ns(last + 1) <= reading) ++last;
    return last;
  }

  double speed_;
  std::int64_t late_ = 0, lateAtBegin_ = 0, givenUp_ = 0;
};

/// Steady: it does not jump when the machine's clock is set.
class WallClock : public ReadClock {
 public:
  explicit WallClock(double rate) : ReadClock(rate, 1) {}

  std::string name() const override { return "the wall clock"; }

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

/// Publishes /clock.
class ClockPublisher {
 public:
  ClockPublisher() : out_(ros::NodeHandle().advertise<rosgraph_msgs::Clock>("/clock", queue)) {}

  void tell(ros::Time time) {
    message_.clock = time;
    if (!time.isZero() && out_.getNumSubscribers() > 0) out_.publish(message_);
  }
  ros::Time told() const { return message_.clock; }

 private:
  ros::Publisher out_;
  rosgraph_msgs::Clock message_;
};

/// Sim time since the start, `factor` times as fast as wall time.
class OwnClock : public ReadClock {
 public:
  OwnClock(double rate, double factor) : ReadClock(rate, factor), factor_(factor) {}

  std::string name() const override { return "its own /clock, real_time_factor " + toText(factor_); }
  long long firstTick() const override { return 1; }
  ros::Time now() const override { return publisher_.told(); }
  void tell(long long tick) override { publisher_.tell(stampOf(tick)); }
  void tellAgain() override { publisher_.tell(publisher_.told()); }

 private:
  std::int64_t read() const override { return std::llround(since(start_) * factor_ * 1e9); }

  double factor_;
  Steady::time_point start_ = Steady::now();
  ClockPublisher publisher_;
};

/// Sim time as fast as it goes: the next tick is always due.
class FreeClock : public Clock {
 public:
  explicit FreeClock(double rate) : Clock(rate) {}

  std::string name() const override { return "its own /clock, as fast as it goes"; }
  long long firstTick() const override { return 1; }
  void begin(long long /*next*/) override {}
  long long due(long long next) override { return next; }
  double untilDue(long long /*next*/) const override { return 0; }
  double lag(long long /*done*/) const override { return 0; }
  ros::Time now() const override { return publisher_.told(); }
  void tell(long long tick) override { publisher_.tell(stampOf(tick)); }
  void tellAgain() override { publisher_.tell(publisher_.told()); }

 private:
  ClockPublisher publisher_;
};

/// Somebody else's /clock.
class ForeignClock : public ReadClock {
 public:
  explicit ForeignClock(double rate)
      : ReadClock(rate, 0),
        subscriber_(ros::NodeHandle().subscribe("/clock", queue, &ForeignClock::hear, this,
                                                ros::TransportHints().tcpNoDelay())) {
    // What was told before there was a subscriber: roscpp has one of its own.
    take(ros::Time::now());
  }

  std::string name() const override { return "/clock, which it follows"; }
  bool hasBegun() const override { return reading_ > 0; }

  std::string standstill() const override {
    if (!hasBegun()) return "/clock has not begun";
    const double silence = since(changed_);
    if (silence < standsAfter) return "";
    return "/clock stands still";
  }

  void begin(long long next) override {
    if (hasBegun() && !jumped_) beginAt(next, std::max(reading_, ns(next)));
  }

  long long due(long long next) override {
    if (!hasBegun()) return next - 1;
    if (jumped_) {
      if (reading_ < ns(next - 1) && warnings_.falls(since(start_))) {
        ROS_INFO("/clock went back to %.3f s; the simulation goes on from its state", seconds(reading_));
      }
      jumped_ = false;
      beginAt(next, reading_);
    }
    return ReadClock::due(next);
  }

  double lag(long long done) const override { return hasBegun() ? ReadClock::lag(done) : 0; }

 private:
  void hear(const rosgraph_msgs::Clock& message) { take(message.clock); }

  void take(ros::Time time) {
    const auto reading = static_cast<std::int64_t>(time.toNSec());
    if (reading == reading_) return;
    jumped_ |= reading < reading_ || reading_ == 0;
    reading_ = reading;
    changed_ = Steady::now();
  }

  std::int64_t read() const override { return reading_; }

  /// Stamps follow the clock anew.
  void giveUp(long long next, std::int64_t /*behind*/) override { beginAt(next, reading_); }

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

void Clock::beginStamps(long long tick, std::int64_t stamp) {
  tick0_ = tick;
  stamp0_ = stamp;
}

ros::Time Clock::stampOf(long long tick) const {
  return timeOf(ns(tick));
}

std::unique_ptr<Clock> makeClock(const Scene& scene) {
  const double rate = scene.publish.rate;
  if (scene.realTimeFactor) {
    if (*scene.realTimeFactor > 0) return std::make_unique<OwnClock>(rate, *scene.realTimeFactor);
    return std::make_unique<FreeClock>(rate);
  }
  if (ros::param::param("/use_sim_time", false)) return std::make_unique<ForeignClock>(rate);
  return std::make_unique<WallClock>(rate);
}

}  // namespace planar_chain
