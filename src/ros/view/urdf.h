#pragma once

/// A scene as URDF, for rviz and other engines.

#include <string>

#include "planar_chain/scene.h"
#include "ros/messages/frames.h"

namespace planar_chain {

/// Returns the URDF. Its root is the world frame, z up; a fixed joint turns the base frame upright. Each link
/// frame is at the link's inner pin, and its joint (axis +z, damping and limits of the scene) is at the outer
/// pin of the link before. Links have the names of their /tf frames, prefix included. Joints have the names
/// in joint_states. A moment of inertia I about +z becomes that of a flat body: izz = I, ixx = iyy = I/2.
/// URDF has no springs, loads and gravity, so these are left out.
std::string urdfOf(const Scene& scene, const Frames& frames);

/// Returns robot_description, the URDF that rviz moves by /tf: urdfOf() if every link has a frame, else the
/// ground alone. Views draws the chain then.
std::string robotDescription(const Scene& scene, const Frames& frames);

}  // namespace planar_chain
