#pragma once

/// Reads what a scene has of prismatic links, and of a floating one: two prismatic links without mass, and
/// the link itself.

#include <optional>
#include <string>
#include <vector>

#include "planar_chain/scene.h"
#include "reading/section.h"

namespace planar_chain {

enum class JointType { revolute, prismatic, floating };

/// Key `joint/type` of a link. Any other value is a fault, and gives nothing.
std::optional<JointType> takeType(const Section& link);

/// A link below the inner pin of a floating link, with a prismatic joint along x (axis 0) or y (axis 1).
struct FreeAxis {
  Link link;
  Joint joint;
};
FreeAxis freeAxis(const std::string& link, const std::string& joint, int axis);

/// Records a fault for each part that a chain with prismatic links, or a floating one, may not have.
void refuseBesideTypes(const Section& top, const Chain& chain, const std::vector<Load>& loads);

}  // namespace planar_chain
