#pragma once

/// The parts of a URDF that matter to dynamics, in the units and frames of the file. Only this pair of files
/// and urdf_foreign use XML.

#include <Eigen/Geometry>
#include <set>
#include <string>
#include <vector>

#include "planar_chain/chain.h"
#include "reading/notes.h"

namespace planar_chain {

/// The pose of one frame in another.
using Pose = Eigen::Isometry3d;

/// rad or m, N m, rad/s. A limit that is not smaller is none: URDF has no other word for it.
constexpr double noLimit = 1e9;

/// A visual element: where it is, and its geometry and material as they are written.
struct UrdfVisual {
  Pose origin;  ///< in the link
  std::string text;
};

struct UrdfLink {
  std::string name;
  double mass = 0;                                    ///< kg, ≥ 0
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      ///< m, link frame
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< kg m², about com, in the link's axes
  bool isSound = true;                                ///< no fault in these
  std::vector<std::size_t> joints;                    ///< indices of the joints whose parent it is
  std::vector<UrdfVisual> visuals;                    ///< those without faults
};

/// A joint with its pose. It sets these values of Joint: name, damping, limits, friction, effort_limit and
/// velocity_limit.
struct UrdfJoint : Joint {
  bool moves = false;
  bool isFree = false;     ///< planar or floating
  bool hasNormal = false;  ///< `along` is normal to the plane of motion: revolute, continuous, planar
  std::size_t parent = 0;  ///< index of the link
  std::size_t child = 0;
  Pose origin = Pose::Identity();                    ///< of the child in the parent, at position 0
  Eigen::Vector3d along = Eigen::Vector3d::UnitX();  ///< unit vector, child's frame
};

struct UrdfDocument {
  std::vector<UrdfLink> links;
  std::vector<UrdfJoint> joints;
  std::string materials;         ///< the elements of that name, as they are written
  bool hasStructure = true;      ///< no fault in the names of links, and in those that joints connect
  bool hasPoses = true;          ///< no fault in the origins, axes and types of joints
  bool isFixedInGazebo = false;  ///< an SDF joint fixes the root to the world
};

/// "robot_description/joint[elbow]"
std::string urdfPath(const char* kind, const std::string& name);

/// Checks each element alone, not whether they form a chain. Adds faults to `faults`, notes to `notes`.
/// limitedElsewhere: names of links whose joints' lower and upper are not read.
/// @throws Refused for a text that is no XML, or too long
UrdfDocument parseUrdf(const std::string& text, const std::set<std::string>& limitedElsewhere,
                       std::vector<Fault>& faults, Notes& notes);

}  // namespace planar_chain
