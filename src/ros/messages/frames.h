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
  std::set<int> withImu{};  ///< links that have a frame in any case

  bool has(int link) const {
    return (static_cast<int>(links.size()) - 1 - link) % every == 0 || withImu.count(link) != 0;
  }
  /// The frame of a link that has one, or of the base for -1.
  const std::string& of(int link) const { return link < 0 ? base : links[static_cast<std::size_t>(link)]; }
  /// The frame of an IMU.
  std::string sensor(const std::string& name) const { return prefix + name; }
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
    if (const Imu* imu = std::get_if<Imu>(&sensor.kind)) frames.withImu.insert(imu->link);
  }

  const int n = scene.chain.size();
  frames.every = publish.frameEvery.value_or(n <= Frames::most ? 1 : (n + Frames::few - 1) / Frames::few);

  // The reader has checked the scene's own names. Only the prefix can make one of them equal to the world's.
  const auto isWorld = [&](const std::string& frame) { return frame == frames.world; };
  if (isWorld(frames.base) || isWorld(frames.pin) ||
      std::any_of(frames.links.begin(), frames.links.end(), isWorld) ||
      std::any_of(scene.sensors.begin(), scene.sensors.end(),
                  [&](const Sensor& sensor) { return isWorld(frames.sensor(sensor.name)); })) {
    throw Refused({{"publish/world_frame", "a name that no other frame has", quoted(publish.worldFrame)}});
  }
  return frames;
}

}  // namespace planar_chain
