#pragma once

/// Attributes and elements that URDF does not define. Those that change the motion are known by name.

#include <string>
#include <vector>

#include "planar_chain/fault.h"
#include "reading/notes.h"

namespace tinyxml2 {
class XMLElement;
}

namespace planar_chain {

/// True if `name` differs from `known` by one letter (more, less or another), or by two letters that changed
/// places. Names of less than four letters are never slips.
bool isSlipOf(const std::string& name, const std::string& known);

/// An attribute or element of a link or joint that other programs read and that changes the motion.
struct ForeignForce {
  const char* name;
  const char* instead;  ///< what to do instead
  bool isRefused;       ///< a fault, else a note
};
/// The one of this name, or nullptr.
const ForeignForce* foreignForce(const std::string& name);

/// Reads the elements of `robot` other than links, joints and materials. Records a fault for each element
/// that closes a loop, and a note for each force that is not read.
/// @returns true if a joint in <gazebo> fixes the robot to the world
bool readBesideLinks(const tinyxml2::XMLElement& robot, std::vector<Fault>& faults, Notes& notes);

}  // namespace planar_chain
