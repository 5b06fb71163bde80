#pragma once

/// What the table of effects consists of: see effects.cpp.

#include <functional>
#include <string>
#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain::test {

/// One row of a table at one length.
struct Operation {
  std::string table;  ///< "evaluation", "tick" or "message"
  std::string effect;
  std::function<void()> prepare, run;
};

/// Each message of the node, filled and serialized as it is published. Only where ROS is.
std::vector<Operation> messagesOf(const Scene& scene);

}  // namespace planar_chain::test
