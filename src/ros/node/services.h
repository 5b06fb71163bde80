#pragma once

/// The services: requests in, handed to the node, its answers out.

#include <planar_chain/SetState.h>
#include <planar_chain/Step.h>
#include <ros/node_handle.h>
#include <ros/service_server.h>
#include <std_srvs/Trigger.h>

#include <vector>

#include "ros/node/node.h"

namespace planar_chain {

class Services {
 public:
  /// Advertises ~pause, ~resume, ~reset, ~clear_commands, ~set_state and ~step. The node must outlive this.
  explicit Services(Node& node);

 private:
  void offer(const char* name, Node::Answer (Node::*action)());

  Node& node_;
  ros::NodeHandle handle_{"~"};
  std::vector<ros::ServiceServer> servers_;
};

}  // namespace planar_chain
