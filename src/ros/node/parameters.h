#pragma once

/// ROS parameters as the tree of values that a scene file gives, so that the same reader accepts both.

#include <functional>
#include <string>

#include "planar_chain/scene.h"

namespace planar_chain {

/// Reads the scene in the private parameters of a node and calls `act` with it. Logs what fails, and
/// for the node itself every fault of the scene. node: any name that resolves to the node.
/// @returns the exit status of the program: 0 done, 2 the scene is refused, 1 `act` failed.
int withScene(const std::string& node, const std::function<void(const Scene&)>& act);

}  // namespace planar_chain
