#pragma once

/// Frame names. All nodes share /tf, so a prefix keeps the frames of two chains apart.

#include <string>
#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain {

struct Frames {
  std::string prefix;              ///< of every frame except the world
  std::string world;               ///< without prefix
  std::string base;                ///< with prefix
  std::vector<std::string> links;  ///< with prefix, in chain order
};

/// Returns the names for a node in `nodeNamespace`. The prefix is publish/frame_prefix of the scene if given.
/// Else it is the namespace, such as "left/", and empty in the root namespace.
/// @throws Refused if the world frame has the name of another frame.
Frames framesOf(const Scene& scene, const std::string& nodeNamespace);

}  // namespace planar_chain
