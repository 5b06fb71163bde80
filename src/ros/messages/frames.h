#pragma once

/// Frame names. All nodes share /tf, so a prefix keeps the frames of two chains apart.
///
/// A long chain has the frame of every k-th link only, counted back from the last: tf2 gives up a frame below
/// more than 1000 others, and rviz draws 24 pictures a second of 100 links, 19 of 200 and 2 of 1000.

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/scene.h"

namespace planar_chain {

struct Frames {
  static constexpr int most = 200, few = 50;  ///< by default a chain of more than `most` links has `few`

  std::string world;               ///< without prefix
  std::string base;                ///< with prefix
  std::string pin;                 ///< of the base where it moves, with prefix; else `base`
  std::vector<std::string> links;  ///< with prefix, in chain order
  int every = 1;                   ///< k

  std::string prefix;
  std::vector<Frame> onLinks{};  ///< the scene's, and the tip's unless another frame has that name
  std::vector<Frame> ofImus{};
  std::set<int> withMore{};  ///< links that have a frame in any case, as these are on them

  bool has(int link) const {
    return (static_cast<int>(links.size()) - 1 - link) % every == 0 || withMore.count(link) != 0;
  }
  /// The frame of a link that has one, or of the base for -1.
  const std::string& of(int link) const { return link < 0 ? base : links[static_cast<std::size_t>(link)]; }
  /// The name of a frame on a link.
  std::string of(const Frame& frame) const { return prefix + frame.name; }
};

/// Returns the names for the node of this full name. The prefix of every frame except the world is
/// publish/frame_prefix of the scene if given. Else it is the namespace, such as "left/".
/// @throws Refused if the world frame has the name of another frame.
inline Frames framesOf(const Scene& scene, const std::string& node) {
  const PublishSettings& publish = scene.publish;
  Frames frames;
  const std::string prefix = publish.framePrefix.value_or(node.substr(1, node.rfind('/')));
  frames.prefix = prefix;
  frames.world = publish.worldFrame;
  frames.base = prefix + publish.baseFrame;
  frames.pin = scene.base ? prefix + movingFrame : frames.base;
  for (const Link& link : scene.chain.links()) frames.links.push_back(prefix + link.name);

  for (const Sensor& sensor : scene.sensors) {
    if (const Imu* imu = std::get_if<Imu>(&sensor.kind))
      frames.ofImus.push_back({sensor.name, imu->link, imu->point, imu->angle});
  }
  frames.onLinks = scene.frames;
  const auto hasName = [](const auto& all, const std::string& name) {
    return std::any_of(all.begin(), all.end(), [&](const auto& one) { return one.name == name; });
  };
  const std::string tip = "tip";
  if (!hasName(scene.chain.links(), tip) && !hasName(frames.ofImus, tip) && !hasName(scene.frames, tip) &&
      publish.baseFrame != tip && prefix + tip != publish.worldFrame) {
    frames.onLinks.push_back({tip, scene.chain.size() - 1, scene.chain.links().back().pin});
  }
  for (const auto* all : {&frames.onLinks, &frames.ofImus}) {
    for (const Frame& frame : *all) frames.withMore.insert(frame.link);
  }

  const int n = scene.chain.size();
  frames.every = publish.frameEvery.value_or(n <= Frames::most ? 1 : (n + Frames::few - 1) / Frames::few);

  // The reader has checked the scene's own names. Only the prefix can make one of them equal to the world's.
  const auto isWorld = [&](const std::string& frame) { return frame == frames.world; };
  const auto isWorlds = [&](const Frame& frame) { return isWorld(frames.of(frame)); };
  if (isWorld(frames.base) || isWorld(frames.pin) ||
      std::any_of(frames.links.begin(), frames.links.end(), isWorld) ||
      std::any_of(frames.ofImus.begin(), frames.ofImus.end(), isWorlds) ||
      std::any_of(frames.onLinks.begin(), frames.onLinks.end(), isWorlds)) {
    throw Refused({{"publish/world_frame", "a name that no other frame has", quoted(publish.worldFrame)}});
  }
  return frames;
}

}  // namespace planar_chain
