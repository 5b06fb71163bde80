#pragma once

/// Frame names. All nodes share /tf, so a prefix keeps the frames of two chains apart.

#include <algorithm>
#include <string>
#include <vector>

#include "planar_chain/fault.h"
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
inline Frames framesOf(const Scene& scene, const std::string& nodeNamespace) {
  const PublishSettings& publish = scene.publish;
  Frames frames;
  const std::size_t first = nodeNamespace.find_first_not_of('/'), last = nodeNamespace.find_last_not_of('/');
  const bool isRoot = first == std::string::npos;
  frames.prefix =
      publish.framePrefix.value_or(isRoot ? "" : nodeNamespace.substr(first, last + 1 - first) + "/");
  frames.world = publish.worldFrame;
  frames.base = frames.prefix + publish.baseFrame;
  for (const Link& link : scene.chain.links()) frames.links.push_back(frames.prefix + link.name);

  // The reader has checked the scene's own names. Only the prefix can make one of them equal to the world's.
  const auto isWorld = [&](const std::string& frame) { return frame == frames.world; };
  if (isWorld(frames.base) || std::any_of(frames.links.begin(), frames.links.end(), isWorld)) {
    throw Refused({{"publish/world_frame", "a name that no other frame has", quoted(publish.worldFrame)}});
  }
  return frames;
}

}  // namespace planar_chain
