#pragma once

/// The command topics, and the log of accepted commands.

#include <planar_chain/CommandTaken.h>
#include <planar_chain/JointTorque.h>
#include <planar_chain/LinkForce.h>
#include <planar_chain/SimStatus.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/subscriber.h>
#include <std_msgs/Float64MultiArray.h>

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/simulation.h"
#include "ros/messages/pace.h"

namespace planar_chain {

/// The topic ~commands_taken: every accepted input that changes the motion, with the tick before which it
/// came. From these the motion can be computed again.
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

/// Each message is checked as a whole, then passed to the simulation. A message with a fault is refused as a
/// whole: nothing changes, a throttled warning gives the reason, and the status counts it. An accepted
/// command acts from its start, or from the simulation's present time if that is later.
class CommandTopics {
 public:
  /// The most commands that can be timed or waiting.
  static constexpr int capacity = 1024;

  /// Converts the node's time to the simulation's, s. Returns infinity while the node's time is unknown.
  using SceneTime = std::function<double(ros::Time)>;

  /// The simulation must outlive this.
  CommandTopics(Simulation& simulation, SceneTime sceneTime);

  /// Subscribes to joint_torques, joint_torque and link_force under `node`. Adds accepted messages to `log`.
  void listen(ros::NodeHandle& node, CommandLog& log);
  void takeJointTorques(const std_msgs::Float64MultiArray& message);
  void takeJointTorque(const JointTorque& message);
  void takeLinkForce(const LinkForce& message);

  /// Takes a recorded torque, torques or force. @returns false if it is refused.
  bool take(const CommandTaken& recorded);
  /// Returns the faults of one torque per joint, held from now on.
  std::vector<Fault> faultsOf(const std::vector<double>& torques, const std::string& path) const;
  /// Holds torques without faults.
  void hold(const std::vector<double>& torques);
  /// Forgets the ages after a reset of the simulation. The count of refusals stays.
  void forget();

  /// Sets the ages and refusals in `status`. The other fields stay as they are.
  void describe(SimStatus& status) const;

 private:
  template <class Message>
  double startOf(std::vector<Fault>& faults, const std::string& topic, const Message& message) const;
  bool refused(const std::vector<Fault>& faults);
  bool refusedFull(const std::string& topic, bool isAccepted);
  double heldUntil(double start) const;
  template <class Fill>
  void log(std::uint8_t kind, Fill&& fill);

  static constexpr double never = -1;

  Simulation& simulation_;
  SceneTime sceneTime_;
  CommandLog* log_ = nullptr;
  Every warnings_{1.0};
  std::map<std::string, int> joints_, links_;  ///< index by name
  double jointTorquesTaken_ = never;           ///< scene time of the last accepted message, s
  double jointTorqueTaken_ = never;
  double linkForceTaken_ = never;
  std::uint64_t rejected_ = 0;
  std::string lastRejection_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace planar_chain
