#pragma once

/// Checks the ROS master every two seconds, in its own thread because a master may answer slowly. roscpp
/// notices neither a restarted master, which has lost all registrations, nor a second publisher of /clock.

#include <xmlrpcpp/XmlRpcValue.h>

#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "ros/messages/pace.h"

namespace planar_chain {

/// If the master has lost this node, registers it again: topics, services, and the given parameters unless
/// the master has other values for them. Existing connections stay. One exception follows from roscpp: when a
/// new publisher of a subscribed topic appears, connections to publishers that the master does not know are
/// closed.
class MasterWatch {
 public:
  /// Construct this after everything is advertised and the parameters are set.
  explicit MasterWatch(const std::vector<std::string>& parameters);
  /// Waits for a pending answer of the master.
  ~MasterWatch();
  MasterWatch(const MasterWatch&) = delete;
  MasterWatch& operator=(const MasterWatch&) = delete;

  /// Returns a fault if /clock has several publishers and this node publishes or uses it. Empty: none.
  std::string clockFault() const;

 private:
  static constexpr double warningPeriod = 30;  // s

  void watch();
  std::string update();
  bool registerAgain() const;
  std::string clockFaultIn(const XmlRpc::XmlRpcValue& state) const;

  std::string name_, uri_;                       ///< of this node
  std::map<std::string, std::string> services_;  ///< uri by name
  std::map<std::string, XmlRpc::XmlRpcValue> parameters_;
  bool isRegistered_ = true;
  Every warnings_{warningPeriod};
  std::string clockFault_;
  bool isEnding_ = false;
  mutable std::mutex mutex_;  ///< guards clockFault_ and isEnding_
  std::condition_variable end_;
  std::thread thread_;
};

}  // namespace planar_chain
