#pragma once

/// ROS parameters as the same tree of values that a scene file gives, so that one reader serves both.

#include <xmlrpcpp/XmlRpcValue.h>

#include <string>

#include "planar_chain/value.h"

namespace planar_chain {

/// @throws Refused every value of a type that a scene has no use for (dates, binary data), with its
///   path.
Value valueOf(const XmlRpc::XmlRpcValue& parameter);

/// The scene's tree from the private parameters of a node, given by its full name.
/// @throws Refused as valueOf, and where there is no scene at all: then it says how to load one.
Value sceneParameters(const std::string& node);

}  // namespace planar_chain
