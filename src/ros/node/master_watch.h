#pragma once

/// Checks the ROS master every two seconds, in another thread because a master may answer slowly. roscpp
/// notices neither a restarted master, which has lost all registrations, nor a second publisher of /clock.

#include <xmlrpcpp/XmlRpcValue.h>

#include <future>
#include <map>
#include <string>

#include "ros/messages/pace.h"

namespace planar_chain {

/// If the master has lost this node, registers it again: topics, services, and the node's parameters unless
/// the master has other values for them. Existing connections stay. One exception follows from roscpp: when a
/// new publisher of a subscribed topic appears, connections to publishers that the master does not know are
/// closed.
class MasterWatch {
 public:
  /// Construct this after everything is advertised and the parameters are set. The destructor waits for a
  /// pending answer of the master.
  MasterWatch();

  /// Starts a check if one is due. Call this at least once per second.
  void update();
  /// Returns a fault if /clock has several publishers and this node publishes or uses it. Empty: none.
  const std::string& clockFault() const { return clockFault_; }

 private:
  std::string check();
  void registerAgain() const;

  std::map<std::string, XmlRpc::XmlRpcValue> parameters_;
  XmlRpc::XmlRpcValue known_;  ///< the state of the last master that had this node
  bool isRegistered_ = true;
  Every checks_{2}, warnings_{30};
  std::string clockFault_;
  std::future<std::string> pending_;  ///< the fault that check() finds
};

}  // namespace planar_chain
