#pragma once

/// From a URDF that is a planar chain to the chain. config/README.md says what is taken and what refused.

#include <string>
#include <vector>

#include "planar_chain/chain.h"

namespace planar_chain {

struct PlanarRobot {
  std::vector<Link> links;    ///< what moves, from the ground outwards; the last one's pin is [0, 0]
  std::vector<Joint> joints;  ///< name, damping, limits
  Vec2d gravity;              ///< m/s², of 9.81 along −z of the root link what lies in the plane
};

/// The plane is normal to the joints' axes, which are parallel: k = the axis, j = the root link's z, seen in
/// the plane, i = j × k. Where the axes are along ±z, i = the root link's x. Every link's axes are i and j
/// when all joints are at 0, and so the angles q are URDF's own joint positions. What is out of the plane
/// does not count, for a chain that pins keep in the plane: offsets along the axes, and of the inertia
/// tensor all but kᵀ I k. Links on fixed joints are one body, those fixed to the root are the ground.
/// @throws Refused every fault at once, such as
///   robot_description/joint[slide]/type: expected revolute, continuous or fixed, got "prismatic"
PlanarRobot readUrdf(const std::string& text);

}  // namespace planar_chain
