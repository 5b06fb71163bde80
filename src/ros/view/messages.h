#pragma once

/// The state of a simulation as ROS messages.

#include <planar_chain/LinkStates.h>
#include <planar_chain/SimStatus.h>
#include <ros/publisher.h>
#include <ros/time.h>
#include <sensor_msgs/JointState.h>
#include <tf2_msgs/TFMessage.h>

#include <vector>

#include "planar_chain/planar.h"
#include "planar_chain/simulation.h"
#include "ros/messages/frames.h"

namespace planar_chain {

/// Sets x and y of a point, vector or pose.
template <class Message>
void copy(Vec2d from, Message& to) {
  to.x = from.x;
  to.y = from.y;
}

/// False also for a topic that the scene does not publish.
inline bool hasSubscribers(const ros::Publisher& topic) {
  return topic.getNumSubscribers() > 0;
}

class Messages {
 public:
  /// Allocates every message in full length.
  Messages(const Scene& scene, const Frames& frames);

  // Each returns the message for the simulation's present state. It is valid until the next call of the same
  // function. The caller may set header.seq. Allocates nothing.
  sensor_msgs::JointState& jointStates(Simulation& simulation, ros::Time stamp);
  LinkStates& linkStates(Simulation& simulation, ros::Time stamp);
  /// The pose of each link that has a frame, in the frame before, or in the base frame for the first. Between
  /// neighbours the origin is the outer pin of the link before, the rotation is q about z.
  tf2_msgs::TFMessage& transforms(Simulation& simulation, ros::Time stamp);

  /// The pose of the base frame in the world: a roll of +π/2, so that the plane of motion is vertical.
  tf2_msgs::TFMessage& baseInWorld(ros::Time stamp);

 private:
  sensor_msgs::JointState jointStates_;
  LinkStates linkStates_;
  tf2_msgs::TFMessage transforms_, baseInWorld_;
  std::vector<LinkMotion> motions_;
  std::vector<int> framed_;  ///< the link of each transform
};

/// SimStatus::standstill after a fault.
inline constexpr const char* standstillByFault = "the integration has failed";

/// Sets the fields of `status` that the simulation determines. The others stay as they are. Before the first
/// step, the method is that of a status before, or else found by a copy of the simulation.
void describe(const Simulation& simulation, SimStatus& status);

}  // namespace planar_chain
