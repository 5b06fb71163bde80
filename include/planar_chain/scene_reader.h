#pragma once

/// Makes a scene from a tree of values, or refuses it with all its faults. Files, ROS parameters and
/// command-line overrides all pass through this reader. config/README.md explains the keys.

#include <string>

#include "planar_chain/scene.h"
#include "planar_chain/value.h"

namespace planar_chain {

/// @throws Refused with every fault at once, such as
///   links/lower/mass: expected a number > 0 kg, got "heavy"
Scene readScene(const Value& value);

/// @throws Refused as parseYaml and readScene
Scene readSceneText(const std::string& yaml);

}  // namespace planar_chain
