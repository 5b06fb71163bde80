#pragma once

/// The topic ~commands_taken: every accepted input that changes the motion, with the tick before which it
/// came. From these the motion can be computed again.

#include <planar_chain/CommandTaken.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <cstdint>
#include <functional>
#include <utility>

namespace planar_chain {

class CommandLog {
 public:
  struct Instant {
    long long nextTick;
    double sceneTime;  ///< s
  };

  /// now: returns the simulation's present instant.
  CommandLog(ros::NodeHandle& node, std::function<Instant()> now)
      : out_(node.advertise<CommandTaken>("commands_taken", queueSize)), now_(std::move(now)) {}

  /// Counts an input. If there are subscribers, publishes it; `fill` sets the fields of its kind.
  template <class Fill>
  void add(std::uint8_t kind, Fill&& fill) {
    ++count_;
    if (out_.getNumSubscribers() == 0) return;
    const Instant now = now_();
    CommandTaken taken;
    taken.number = count_;
    taken.tick = static_cast<std::uint64_t>(now.nextTick);
    taken.scene_time = now.sceneTime;
    taken.kind = kind;
    fill(taken);
    out_.publish(taken);
  }
  void add(std::uint8_t kind) {
    add(kind, [](CommandTaken&) {});
  }

 private:
  static constexpr std::uint32_t queueSize = 10000;  // a lost message would make the others useless

  ros::Publisher out_;
  std::function<Instant()> now_;
  std::uint64_t count_ = 0;
};

}  // namespace planar_chain
