#include "planar_chain/ros/frames.h"

#include <utility>

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

  std::vector<Fault> faults;
  const auto refuse = [&faults](const char* key, const char* expected, const std::string& found) {
    faults.push_back({std::string("publish/") + key, expected, describe(Value(found))});
  };
  if (frames.world.front() == '/') refuse("world_frame", "a frame without leading /", frames.world);
  if (frames.base.front() == '/') {
    const bool fromPrefix = !frames.prefix.empty();
    refuse(fromPrefix ? "frame_prefix" : "base_frame", "a frame without leading /", frames.base);
  }
  if (frames.base == frames.world) {
    refuse("base_frame", "another frame than the world's", frames.base);
  }
  for (const std::string& link : frames.links) {
    if (link == frames.world) refuse("world_frame", "another frame than any link's", link);
    if (link == frames.base) refuse("base_frame", "another frame than any link's", link);
  }
  if (!faults.empty()) throw Refused(std::move(faults));
  return frames;
}

}  // namespace planar_chain
