#pragma once

/// Where simulate gets its bags from: a library beside it, in builds with ROS.

#include <vector>

#include "planar_chain/fault.h"
#include "ros/bag/bags.h"

namespace planar_chain::tools {

/// Notes a fault where this build has no bags.
void checkBags(std::vector<Fault>& faults);

/// Loads the library.
/// @throws std::runtime_error when it cannot be loaded
OpenBags* bagsLibrary();

}  // namespace planar_chain::tools
