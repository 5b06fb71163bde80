#pragma once

/// Makes a scene from a tree of values, or refuses it with all its faults. Files, ROS parameters and
/// command-line overrides all pass through this reader. config/README.md explains the keys.

#include <optional>
#include <string>
#include <vector>

#include "planar_chain/scene.h"
#include "planar_chain/value.h"

namespace planar_chain {

/// @throws Refused with every fault at once, such as
///   links/lower/mass: expected a number > 0 kg, got "heavy"
Scene readScene(const Value& value);

/// The tree of a scene's text: YAML, or a URDF, which begins with <, as its robot_description.
/// @throws Refused as parseYaml
Value parseScene(const std::string& text);

/// @throws Refused as parseYaml and readScene
Scene readSceneText(const std::string& text);

// ---- Its numbers, by path --------------------------------------------------------------------------

/// Checks that a scene that readScene() accepts may have a number at each path, such as
/// "links/lower/com/0". The number itself is not checked.
/// @throws Refused with a fault for each path where it may not
void requireNumbers(const Value& scene, const std::vector<std::string>& paths);

/// Returns the number at a path that requireNumbers() accepts, or nothing if the scene leaves it out.
std::optional<double> numberAt(const Value& scene, const std::string& path);

/// Sets the number at a path that requireNumbers() accepts. Maps on the way are made.
/// @throws Refused if the path leads through a number or out of a list
void setNumber(Value& scene, const std::string& path, double number);

}  // namespace planar_chain
