#pragma once

/// The services that change the motion.

#include <ros/service_server.h>

#include <vector>

#include "ros/node/node.h"

namespace planar_chain {

/// Advertises ~pause, ~resume, ~reset, ~clear_commands, ~set_state and ~step. The node must outlive the
/// servers.
std::vector<ros::ServiceServer> advertiseServices(Node& node);

}  // namespace planar_chain
