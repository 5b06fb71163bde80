#pragma once

/// ROS parameters as the same tree of values that a scene file gives, so that one reader serves both.

#include <xmlrpcpp/XmlRpcValue.h>

#include <functional>
#include <string>

#include "planar_chain/scene.h"
#include "planar_chain/value.h"

namespace planar_chain {

/// @throws Refused every value of a type that a scene has no use for (dates, binary data), with its
///   path.
Value valueOf(const XmlRpc::XmlRpcValue& parameter);

/// The scene's tree from the private parameters of a node, given by its full name.
/// @throws Refused as valueOf, and where there is no scene at all: then it says how to load one.
Value sceneParameters(const std::string& node);

/// Reads that scene, of a node by any name that resolves to it, and does something with it. What is wrong
/// with the scene, or fails, goes to the log.
/// @returns the program's exit status: 0 done, 2 refused, 1 failed
int withScene(const std::string& node, const std::function<void(const Scene&)>& act);

}  // namespace planar_chain
