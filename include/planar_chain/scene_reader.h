#pragma once

/// From a tree of values to a scene, or to the full list of what is wrong with it. The one reader: files,
/// ROS parameters and overrides of the command line all pass here. config/README.md explains the keys.

#include <string>

#include "planar_chain/scene.h"
#include "planar_chain/value.h"

namespace planar_chain {

/// @throws Refused with every fault at once, such as
///   links/lower/mass: expected a number > 0 kg, got "heavy"
Scene readScene(const Value& value);

/// @throws Refused as parseYaml, or as readScene.
Scene readSceneText(const std::string& yaml);

}  // namespace planar_chain
