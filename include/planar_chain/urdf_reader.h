#pragma once

/// Makes a chain from a URDF that describes a planar one. config/README.md lists supported and refused
/// elements.

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain {

struct PlanarRobot {
  std::vector<Link> links;    ///< moving links, outwards; the pin of the last is its farthest frame
  std::vector<Joint> joints;  ///< name, damping, limits, friction, effort_limit, velocity_limit, axis
  bool floats = false;        ///< the first two are prismatic without mass, for a planar or floating joint
  Vec2d gravity;              ///< m/s²: 9.81 along −z of the root link, projected into the plane
  Appearance appearance;      ///< the visual elements, at their places and depths; empty if there are none
  std::vector<Note> notes;    ///< ignored elements and unexpected readings
};

/// The axes of joints that turn must be parallel, and those of prismatic joints at right angles to them. The
/// plane is normal to the former: k = the axis, that of a planar joint too, j = the root link's z projected
/// into the plane, i = j × k. If the axes are along ±z, i is the root link's x. The axes of every
/// link are i and j when all joints are at 0, so the angles q are the joint positions of the URDF.
///
/// Only quantities in the plane count. Offsets along the axes are dropped. Of the inertia tensor I, only
/// kᵀ I k is used. This is exact, because the pins keep the chain in the plane. Links on fixed joints form
/// one body. Links fixed to the root are the ground.
/// @throws Refused with every fault at once, such as
///   robot_description/joint[elbow]/axis: expected an axis parallel to the first joint's …
PlanarRobot readUrdf(const std::string& text);

/// Reads a robot as readUrdf(), but adds its faults to `faults`. A body with faults is replaced by a disc,
/// and its joint has no limits, so that the rest of a scene can be checked. Returns nothing if the links do
/// not form a chain.
/// limitedElsewhere: names of links whose joints' lower and upper the caller sets. Those of the URDF are not
/// read, and the joints have none.
/// @throws Refused for a text that is no XML, or too long
std::optional<PlanarRobot> findRobot(const std::string& text, std::vector<Fault>& faults,
                                     const std::set<std::string>& limitedElsewhere = {});

}  // namespace planar_chain
