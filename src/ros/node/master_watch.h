#pragma once

/// Checks the ROS master every two seconds, in its own thread because a master may answer slowly. roscpp
/// notices neither a restarted master, which has lost all registrations, nor a second publisher of /clock.

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "ros/messages/pace.h"

namespace planar_chain {

/// If the master has lost this node, registers it again: topics, services, and the given parameters unless
/// the master has other values for them. Existing connections stay. One exception follows from roscpp: when a
/// new publisher of a subscribed topic appears, connections to publishers that the master does not know are
/// closed.
class MasterWatch {
 public:
  /// Construct this after everything is advertised and the parameters are set. The destructor waits for a
  /// pending answer of the master.
  explicit MasterWatch(const std::vector<std::string>& parameters);

  /// Returns a fault if /clock has several publishers and this node publishes or uses it. Empty: none.
  std::string clockFault() const;

 private:
  std::string update();
  void registerAgain() const;

  std::vector<std::string> services_;  ///< the names of those of this node
  std::map<std::string, XmlRpc::XmlRpcValue> parameters_;
  bool isRegistered_ = true;
  Every warnings_{30};
  std::string clockFault_;
  mutable std::mutex mutex_;  ///< guards clockFault_
  ros::CallbackQueue queue_;
  ros::NodeHandle handle_;
  ros::SteadyTimer timer_;
  ros::AsyncSpinner thread_{1, &queue_};
};

}  // namespace planar_chain
