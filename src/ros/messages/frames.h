#pragma once

/// The names of the frames on /tf, which all nodes share.

#include <string>
#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain {

struct Frames {
  std::string prefix;              ///< before every name but the world's
  std::string world;               ///< as the scene says
  std::string base;                ///< with prefix
  std::vector<std::string> links;  ///< with prefix, in chain order
};

/// Without publish/frame_prefix the prefix is the node's namespace, such as "left/", and nothing in
/// the root namespace.
/// @throws Refused a world frame that bears the name of another.
Frames framesOf(const Scene& scene, const std::string& nodeNamespace);

}  // namespace planar_chain
