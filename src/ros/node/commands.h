#pragma once

/// Every input that changes the motion: the command topics, the services, and those of a recorded run.

#include <planar_chain/CommandTaken.h>
#include <planar_chain/SimStatus.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/subscriber.h>
#include <std_msgs/Float64MultiArray.h>
#include <trajectory_msgs/JointTrajectory.h>
#include <trajectory_msgs/MultiDOFJointTrajectory.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/simulation.h"
#include "ros/messages/rests.h"
#include "ros/messages/ticks.h"

namespace planar_chain {

using trajectory_msgs::JointTrajectory;
using trajectory_msgs::MultiDOFJointTrajectory;

/// Returns an input without the fields of its kind.
inline CommandTaken inputOf(std::uint8_t kind) {
  CommandTaken input;
  input.kind = kind;
  return input;
}

/// An input is a CommandTaken. It is checked as a whole, then passed to the simulation and published on
/// ~commands_taken, from which the motion can be computed again. An input with a fault is refused as a whole:
/// nothing changes. An accepted command acts from its start, or from the simulation's present time if that is
/// later.
class Commands {
 public:
  /// The most commands that can be timed or waiting.
  static constexpr int capacity = 1024;

  /// Converts the node's time to the simulation's, s. Returns infinity while the node's time is unknown.
  using SceneTime = std::function<double(ros::Time)>;

  /// Call moveTo() before all others. The ticks must outlive this.
  Commands(Ticks& ticks, SceneTime sceneTime) : ticks_(ticks), sceneTime_(std::move(sceneTime)) {}

  /// From now on passes inputs to this simulation, which must outlive this. A second call counts as an input
  /// that is not published: the recorded run is then incomplete, as one scene alone does not give its motion.
  void moveTo(Simulation& simulation);

  /// Subscribes to joint_torques, joint_torque, link_force, joint_trajectory and base_trajectory under
  /// `node`, and advertises commands_taken. Messages come with serve(), or wait for it.
  void listen(ros::NodeHandle node);
  /// Takes the messages that have arrived, in their order.
  void serve();
  /// As serve(), between two ticks. While commands are recorded, it takes no more than rosbag can record. The
  /// others wait.
  void serveAtItsPace();
  /// True if messages wait, outside ticks too.
  bool haveWaiting() const { return !waiting_.empty(); }
  /// During a long tick: messages that have arrived wait for serve(). roscpp would drop the oldest without a
  /// word; here those that do not fit into 64 MiB are refused.
  void collect();
  /// Drops the messages that wait.
  void dropWaiting();
  void onJointTorques(const std::vector<double>& torques);
  void onJointTorque(const JointTorque& message);
  void onLinkForce(const LinkForce& message);
  void onJointTrajectory(const JointTrajectory& message);
  void onBaseTrajectory(const MultiDOFJointTrajectory& message);

  /// Takes an input before the next tick. Its number, tick and scene time are set here.
  /// @returns why it is refused; empty: it is accepted
  std::string take(CommandTaken input);
  /// As take(). A refusal is also counted in the status, and a throttled warning gives the reason.
  std::string takeOrWarn(const CommandTaken& input);
  /// Counts a refusal and gives its reason, as takeOrWarn().
  void refuse(const std::string& reason);
  /// Call this about once a second. Logs the last refusal with the number of those since the line before, if
  /// there are any.
  void warnOfRefusals();
  /// Returns the faults of a STEP. isRecorded: it may lack n.
  std::vector<Fault> faultsOf(const CommandTaken& step, bool isRecorded = false) const;

  bool areRecorded() const { return log_.getNumSubscribers() > 0; }

  /// Sets the ages and refusals in `status`. The other fields stay as they are.
  void describe(SimStatus& status) const;

 private:
  void takeNext();
  std::vector<Fault> apply(const CommandTaken& input);
  std::vector<Fault> applyTorque(const CommandTaken& input);
  std::vector<Fault> applyForce(const CommandTaken& input);
  std::vector<Fault> applyTrajectory(const CommandTaken& input);
  std::vector<Fault> applyBaseTrajectory(const CommandTaken& input);
  template <class Message, class Add, class Hold>
  std::vector<Fault> start(std::vector<Fault> faults, const std::string& topic, const CommandTaken& input,
                           const Message& command, Add add, Hold hold);
  std::vector<Fault> faultsOf(const std::vector<double>& torques, const std::string& path) const;
  std::vector<Fault> applyStep(const CommandTaken& input);
  BaseLaws baseLawsOf(const CommandTaken& step) const;
  void hold(const std::vector<double>& torques);
  double heldUntil(double start) const;
  double sceneTimeOf(ros::Time start) const;

  Simulation* simulation_ = nullptr;
  Ticks& ticks_;
  SceneTime sceneTime_;
  std::map<std::string, int> joints_, links_;  ///< index by name
  std::vector<bool> isDriven_;                 ///< of each joint
  Every warnings_{1.0};
  std::map<std::uint8_t, double> taken_;  ///< scene time of the last of each kind, s
  std::uint64_t accepted_ = 0, rejected_ = 0;
  std::uint64_t warned_ = 0;  ///< of those rejected
  std::string lastRejection_;
  ros::CallbackQueue queue_;  ///< outlives the subscribers
  ros::Publisher log_;
  Rests rests_{40, 5e-3};  ///< of the log
  struct Waiting {
    std::size_t bytes;
    std::function<void()> take;
  };
  bool isCollecting_ = false;
  std::deque<Waiting> waiting_;
  std::size_t waitingBytes_ = 0;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace planar_chain
