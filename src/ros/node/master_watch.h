#pragma once

/// Looks at the master every two seconds, in a thread of its own, for a master may take long to answer. A
/// master that took the place of one that died knows nothing, and roscpp does not notice; and nobody notices
/// when /clock has two owners.

#include <xmlrpcpp/XmlRpcValue.h>

#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "ros/messages/pace.h"

namespace planar_chain {

/// Where the master does not know this node any more, everything is registered again: topics, services, and
/// the parameters named, unless the master has others by those names. Connections stay as they are, but once
/// somebody new publishes a topic that this node takes, those whom the master does not know are cut off:
/// that is how roscpp understands the master's word.
class MasterWatch {
 public:
  /// When all is advertised and the parameters are set.
  explicit MasterWatch(const std::vector<std::string>& parameters);
  /// Waits for an answer that is due.
  ~MasterWatch();
  MasterWatch(const MasterWatch&) = delete;
  MasterWatch& operator=(const MasterWatch&) = delete;

  /// The faults of /clock, where this node publishes or takes it: several publishers. Empty: none.
  std::string faultOfClock() const;

 private:
  static constexpr double warningPeriod = 30;  // s

  void watch();
  std::string look();
  bool registerAgain() const;
  std::string faultOfClockIn(const XmlRpc::XmlRpcValue& state) const;

  std::string name_, uri_;                       ///< this node's
  std::map<std::string, std::string> services_;  ///< uri by name
  std::map<std::string, XmlRpc::XmlRpcValue> parameters_;
  bool isRegistered_ = true;
  Every warnings_{warningPeriod};
  std::string faultOfClock_;
  bool ends_ = false;
  mutable std::mutex mutex_;  ///< of the two above
  std::condition_variable end_;
  std::thread thread_;
};

}  // namespace planar_chain
