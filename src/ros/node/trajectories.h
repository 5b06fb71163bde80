#pragma once

/// Trajectories of driven joints and of the base.

#include <geometry_msgs/Pose2D.h>
#include <geometry_msgs/Twist.h>
#include <trajectory_msgs/JointTrajectory.h>
#include <trajectory_msgs/MultiDOFJointTrajectory.h>

#include <map>
#include <string>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/simulation.h"

namespace planar_chain {

constexpr double farthestStart = 86400;  ///< s: a start farther ahead is a time of another clock

/// Returns the law of each joint that the message names: the present one until `start` (s of scene time), or
/// until now if that is later, and then through the points. Points that are over by then are left out. Adds
/// the faults of the message; with faults the laws are of no use. joints: index by name.
std::vector<Drive> lawsOf(const trajectory_msgs::JointTrajectory& message, double start,
                          const Simulation& simulation, const std::map<std::string, int>& joints,
                          std::vector<Fault>& faults);

/// Returns the laws of the base's position and angle. Each angle is the rotation about z that is nearest to
/// that of the point before.
BaseLaws lawsOf(const trajectory_msgs::MultiDOFJointTrajectory& message, double start,
                const Simulation& simulation, std::vector<Fault>& faults);

/// Adds the faults of the base's pose and twist in a ~step: one of each, or neither.
void checkBase(const std::vector<geometry_msgs::Pose2D>& pose, const std::vector<geometry_msgs::Twist>& twist,
               const Simulation& simulation, std::vector<Fault>& faults);
/// Returns the cubics from the base's present motion to these at scene time `end`, without faults. The
/// whole turns of theta are those nearest to what the mean of the rates gives.
BaseLaws lawsTo(const geometry_msgs::Pose2D& pose, const geometry_msgs::Twist& twist, double end,
                const Simulation& simulation);

}  // namespace planar_chain
