#pragma once

/// ROS parameters as the tree of values that a scene file gives, so that the same reader accepts both.

#include <xmlrpcpp/XmlRpcValue.h>

#include <functional>
#include <optional>
#include <string>

#include "planar_chain/scene.h"

namespace planar_chain {

/// The scene in the private parameters of a node.
class SceneParameters {
 public:
  /// node: any name that resolves to the node.
  explicit SceneParameters(const std::string& node);

  /// @throws Refused with every fault
  Scene read();
  /// Reads the scene again. Returns nothing if the parameters are those of the last scene, or if the master
  /// does not answer.
  /// @throws Refused with every fault; `publish` and `real_time_factor` must not change
  std::optional<Scene> readIfChanged();

  /// Reads the scene and calls `act` with it. Logs what fails, and for the node itself every fault of the
  /// scene.
  /// @returns the exit status of the program: 0 done, 2 the scene is refused, 1 `act` failed.
  int run(const std::function<void(const Scene&)>& act);

 private:
  /// Refuses that the node has no parameters. remedy: in words.
  [[noreturn]] void refuseNothing(const std::string& remedy) const;

  std::string node_;
  XmlRpc::XmlRpcValue known_;
};

}  // namespace planar_chain
