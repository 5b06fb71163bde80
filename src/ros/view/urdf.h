#pragma once

/// A scene as URDF, for rviz and other engines.

#include <string>

#include "planar_chain/scene.h"
#include "ros/messages/frames.h"

namespace planar_chain {

/// The root is the world frame, z up, in which the base frame stands upright; every link's frame sits at its
/// inner pin, and its joint (axis +z, the scene's damping and limits) at the outer pin of the link before.
/// Links bear the names of their frames on /tf, prefix and all, so that rviz finds them without further
/// settings; joints are named as on joint_states. What URDF has no word for is left out: springs, loads,
/// gravity. An inertia I about +z is written as a plane body's: izz = I, ixx = iyy = I/2.
std::string urdfOf(const Scene& scene, const Frames& frames);

}  // namespace planar_chain
