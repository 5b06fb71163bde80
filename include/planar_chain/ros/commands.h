#pragma once

/// The commands: topics in, checked as a whole, then handed to the simulation.

#include <planar_chain/JointTorque.h>
#include <planar_chain/LinkForce.h>
#include <planar_chain/SimStatus.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <std_msgs/Float64MultiArray.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/ros/command_log.h"
#include "planar_chain/simulation.h"

namespace planar_chain {

/// A message with any fault is refused whole: nothing changes, a throttled warning says why, and the
/// status counts it. An accepted one is in force from the simulation's present time on.
class Commands {
 public:
  /// How many timed commands may be in force at once.
  static constexpr int capacity = 256;

  /// Takes what take() is given, and nothing else.
  explicit Commands(Simulation& simulation);
  /// Subscribes to ~joint_torques, ~joint_torque and ~link_force under `node`; what is accepted goes into
  /// `log`.
  Commands(ros::NodeHandle& node, Simulation& simulation, CommandLog& log);

  /// A command that was recorded, from the simulation's present time on. @returns false: refused
  bool take(const CommandTaken& recorded);

  /// Ages and refusals; the rest of the status is left as it is.
  void describe(SimStatus& status) const;

 private:
  void takeJointTorques(const std_msgs::Float64MultiArray& message);
  void takeJointTorque(const JointTorque& message);
  void takeLinkForce(const LinkForce& message);

  bool refused(const std::vector<Fault>& faults);
  template <class Fill>
  void log(Fill&& fill);
  double heldUntil() const;

  static constexpr double never = -1;

  Simulation& simulation_;
  CommandLog* log_ = nullptr;
  std::map<std::string, int> joints_, links_;  ///< index by name
  double jointTorquesTaken_ = never;           ///< sim time of the last accepted message, s
  double jointTorqueTaken_ = never;
  double linkForceTaken_ = never;
  std::uint64_t rejected_ = 0;
  std::string lastRejection_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace planar_chain
