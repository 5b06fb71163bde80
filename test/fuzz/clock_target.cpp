/// Whatever /clock tells, who follows it stamps no tick with 0, none ahead of it, and each later than the one
/// before unless the clock went back. Needs a master: see own_master.py.

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/param.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>

#include "bytes.h"
#include "planar_chain/scene_reader.h"
#include "ros/node/clock.h"
#include "ros_begun.h"

namespace planar_chain {
namespace {

constexpr int mostTicks = 5;  // at a stretch

/// The publisher of /clock, in this very process: what it says is heard at the next look.
ros::Publisher& foreigner() {
  static ros::Publisher one = [] {
    beginRos("fuzz_clock");
    static ros::NodeHandle node;
    ros::param::set("/use_sim_time", true);
    return node.advertise<rosgraph_msgs::Clock>("/clock", 10);
  }();
  return one;
}

Clock& follower() {
  static const std::unique_ptr<Clock> one = [] {
    auto made = makeClock(readSceneText(
        "{chain: [a], links: {a: {mass: 1, inertia: 1, com: [0, 0], pin: [1, 0]}}, publish: {rate: 200}}"));
    while (foreigner().getNumSubscribers() == 0) ros::WallDuration(0.01).sleep();
    return made;
  }();
  return *one;
}

/// A little further than before, or any time at all. Returns what its follower takes it for.
ros::Time told(Bytes& bytes, ros::Time before) {
  rosgraph_msgs::Clock message;
  const auto much = bytes.take<std::uint8_t>();
  if (much < 128) {
    message.clock.fromNSec(
        std::min(before.toNSec() + std::uint64_t{much} * 1000000, std::uint64_t{ros::TIME_MAX.toNSec()}));
  } else {
    message.clock.sec = bytes.take<std::uint32_t>();
    message.clock.nsec = bytes.take<std::uint32_t>() % 1000000000;
  }
  // By pointer: it is handed over at once.
  foreigner().publish(boost::make_shared<rosgraph_msgs::Clock>(message));
  ros::getGlobalCallbackQueue()->callAvailable();
  return message.clock.isZero() ? message.clock : std::min(message.clock, follower().now());
}

}  // namespace
}  // namespace planar_chain

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planar_chain;
  foreigner();
  static long long next = follower().firstTick();
  static ros::Time now = follower().now();
  Bytes bytes(data, size);
  ros::Time last;
  while (!bytes.empty()) {
    const ros::Time before = now;
    now = told(bytes, before);
    if (now < before) last = ros::Time();
    require(follower().hasBegun() == !now.isZero());
    const long long due = follower().due(next);
    require(due >= next || now.isZero() || now >= before);  // after a jump back it goes on at once
    for (int k = 0; next <= due && k < mostTicks; ++k) {
      const ros::Time stamp = follower().stampOf(next++);
      require(!stamp.isZero() && stamp <= now && stamp > last);
      last = stamp;
    }
    require(std::isfinite(follower().lag(next - 1)) && !std::isnan(follower().untilDue(next)));
  }
  return 0;
}
