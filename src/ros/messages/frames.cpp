#include "ros/messages/frames.h"

#include <algorithm>

#include "planar_chain/fault.h"
#include "planar_chain/value.h"

namespace planar_chain {

namespace {

std::string prefixFrom(const std::string& nodeNamespace) {
  const std::size_t first = nodeNamespace.find_first_not_of('/');
  if (first == std::string::npos) return "";
  const std::size_t last = nodeNamespace.find_last_not_of('/');
  return nodeNamespace.substr(first, last - first + 1) + "/";
}

}  // namespace

Frames framesOf(const Scene& scene, const std::string& nodeNamespace) {
  const PublishSettings& publish = scene.publish;
  Frames frames;
  frames.prefix = publish.framePrefix ? *publish.framePrefix : prefixFrom(nodeNamespace);
  frames.world = publish.worldFrame;
  frames.base = frames.prefix + publish.baseFrame;
  for (const Link& link : scene.chain.links()) frames.links.push_back(frames.prefix + link.name);

  // The reader keeps the scene's own names apart; only the prefix can make one of them the world's.
  const auto isWorld = [&](const std::string& frame) { return frame == frames.world; };
  if (isWorld(frames.base) || std::any_of(frames.links.begin(), frames.links.end(), isWorld)) {
    throw Refused(
        {{"publish/world_frame", "another frame than those of the chain", describe(Value(frames.world))}});
  }
  return frames;
}

}  // namespace planar_chain
