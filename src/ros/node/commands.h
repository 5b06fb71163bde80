#pragma once

/// The commands: topics in, checked as a whole, then handed to the simulation.

#include <planar_chain/JointTorque.h>
#include <planar_chain/LinkForce.h>
#include <planar_chain/SimStatus.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <std_msgs/Float64MultiArray.h>

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/simulation.h"
#include "ros/messages/pace.h"
#include "ros/node/command_log.h"

namespace planar_chain {

/// A message with any fault is refused whole: nothing changes, a throttled warning says why, and the
/// status counts it. An accepted one is in force from its start on, or from the simulation's present time on.
class Commands {
 public:
  /// How many commands may be timed or wait for their start.
  static constexpr int capacity = 1024;

  /// From the node's time to that of the simulation, s; infinite while the node does not know its time.
  using SceneTime = std::function<double(ros::Time)>;

  Commands(Simulation& simulation, SceneTime sceneTime);

  /// Subscribes to ~joint_torques, ~joint_torque and ~link_force under `node`; what is accepted goes into
  /// `log`.
  void listen(ros::NodeHandle& node, CommandLog& log);
  void takeJointTorques(const std_msgs::Float64MultiArray& message);
  void takeJointTorque(const JointTorque& message);
  void takeLinkForce(const LinkForce& message);

  /// One that was recorded: a torque, torques or a force. @returns false: refused
  bool take(const CommandTaken& recorded);
  /// What is wrong with one torque per joint, to be held from now on.
  std::vector<Fault> faultsOf(const std::vector<double>& torques, const std::string& path) const;
  /// Holds them; they must have no faults.
  void hold(const std::vector<double>& torques);
  /// The simulation was reset: as if no command had ever come. Refusals count on.
  void forget();

  /// Ages and refusals; the rest of the status is left as it is.
  void describe(SimStatus& status) const;

 private:
  struct Window {
    double start, duration;
  };

  Window windowOf(std::vector<Fault>& faults, const std::string& topic, ros::Time start,
                  double duration) const;
  bool refused(const std::vector<Fault>& faults);
  double heldFrom(double start) const;
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
