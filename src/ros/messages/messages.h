#pragma once

/// What the simulation says, as messages. Sized once, filled again at each tick.

#include <geometry_msgs/TransformStamped.h>
#include <planar_chain/LinkStates.h>
#include <planar_chain/SimStatus.h>
#include <ros/time.h>
#include <sensor_msgs/JointState.h>
#include <tf2_msgs/TFMessage.h>

#include <vector>

#include "planar_chain/planar.h"
#include "planar_chain/simulation.h"
#include "ros/messages/frames.h"

namespace planar_chain {

class Messages {
 public:
  Messages(const Scene& scene, const Frames& frames);

  // Each fills the message from the simulation's present state and returns it; it stays valid until
  // the next call. The caller may set header.seq. Nothing is allocated.
  sensor_msgs::JointState& jointStates(const Simulation& simulation, ros::Time stamp);
  LinkStates& linkStates(const Simulation& simulation, ros::Time stamp);
  /// Each link in the frame of the link before (the first: in the base frame): moved to that link's
  /// outer pin, turned by q.
  tf2_msgs::TFMessage& transforms(const Simulation& simulation, ros::Time stamp);

  /// The base frame in the world: rolled by +π/2, so that the plane of motion stands upright.
  static geometry_msgs::TransformStamped baseInWorld(const Frames& frames, ros::Time stamp);

 private:
  sensor_msgs::JointState jointStates_;
  LinkStates linkStates_;
  tf2_msgs::TFMessage transforms_;
  std::vector<LinkMotion> motions_;
  std::vector<double> halfAngles_;
  std::vector<Rotation<double>> halfTurns_;
};

/// Why sim time stands still after a fault, in SimStatus.
inline constexpr const char* standstillByFault = "the integration has failed";

/// The simulation's part of the status; the rest is left as it is.
void describe(const Simulation& simulation, SimStatus& status);

}  // namespace planar_chain
