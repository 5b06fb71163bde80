#include "ros/node/master_watch.h"

#include <ros/console.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcClient.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>
#include <chrono>
#include <initializer_list>
#include <optional>

namespace planar_chain {

namespace {

using XmlRpc::XmlRpcValue;

constexpr auto period = std::chrono::seconds(2);

XmlRpcValue requestOf(std::initializer_list<XmlRpcValue> arguments) {
  XmlRpcValue request;
  request[0] = ros::this_node::getName();
  for (const XmlRpcValue& argument : arguments) request[request.size()] = argument;
  return request;
}

/// http://wiki.ros.org/ROS/Master_API. @returns nothing where there is no answer, or no good one
std::optional<XmlRpcValue> askMaster(const char* method, std::initializer_list<XmlRpcValue> arguments) {
  XmlRpcValue response, payload;
  if (!ros::master::execute(method, requestOf(arguments), response, payload, false)) return std::nullopt;
  return payload;
}

/// http://wiki.ros.org/ROS/Slave_API, of the node `uri`, as askMaster().
std::optional<XmlRpcValue> askNode(const std::string& uri, const char* method,
                                   std::initializer_list<XmlRpcValue> arguments) {
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(uri, host, port)) return std::nullopt;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpcValue response;
  if (!client.execute(method, requestOf(arguments), response) || client.isFault()) return std::nullopt;
  return response[2];
}

enum Part { publishers, subscribers, services };  // of the master's state

/// The nodes that the master knows for a topic or service.
std::vector<std::string> nodesOf(const XmlRpcValue& state, Part part, const std::string& name) {
  std::vector<std::string> nodes;
  for (int i = 0; i < state[part].size(); ++i) {
    const XmlRpcValue& entry = state[part][i];
    if (static_cast<const std::string&>(entry[0]) != name) continue;
    for (int j = 0; j < entry[1].size(); ++j) nodes.push_back(entry[1][j]);
  }
  return nodes;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

MasterWatch::MasterWatch(const std::vector<std::string>& parameters) : name_(ros::this_node::getName()) {
  if (const auto uri = askMaster("lookupNode", {name_})) uri_ = std::string(XmlRpcValue(*uri));
  if (auto state = askMaster("getSystemState", {})) {
    for (int i = 0; i < (*state)[services].size(); ++i) {
      const std::string service = (*state)[services][i][0];
      if (!contains(nodesOf(*state, services, service), name_)) continue;
      if (auto uri = askMaster("lookupService", {service})) services_[service] = std::string(*uri);
    }
  }
  for (const std::string& parameter : parameters) {
    if (const auto value = askMaster("getParam", {parameter})) parameters_[parameter] = *value;
  }
  thread_ = std::thread([this] { watch(); });
}

MasterWatch::~MasterWatch() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  end_.notify_all();
  thread_.join();
}

std::string MasterWatch::faultOfClock() const {
  const std::lock_guard lock(mutex_);
  return faultOfClock_;
}

void MasterWatch::watch() {
  std::unique_lock lock(mutex_);
  while (!end_.wait_for(lock, period, [this] { return ends_; })) {
    lock.unlock();
    std::string faultOfClock;
    try {
      faultOfClock = look();
    } catch (const XmlRpc::XmlRpcException&) {
      // An answer of another kind than the master's API has: as good as none.
    }
    lock.lock();
    faultOfClock_ = faultOfClock;
  }
}

/// @returns the fault of /clock
std::string MasterWatch::look() {
  const auto state = askMaster("getSystemState", {});
  if (!state) return "";
  // Every node publishes there.
  if (!isRegistered_ || !contains(nodesOf(*state, publishers, "/rosout"), name_)) {
    isRegistered_ = registerAgain();
    if (isRegistered_) ROS_WARN("the master did not know this node any more: it is registered again");
  }
  const std::string fault = faultOfClockIn(*state);
  const std::chrono::duration<double> now = std::chrono::steady_clock::now().time_since_epoch();
  if (!fault.empty() && warnings_.falls(now.count())) ROS_WARN("%s", fault.c_str());
  return fault;
}

/// @returns whether all of it could be told.
bool MasterWatch::registerAgain() const {
  auto published = askNode(uri_, "getPublications", {}), taken = askNode(uri_, "getSubscriptions", {});
  if (!published || !taken) return false;
  bool isTold = true;
  for (int i = 0; i < published->size(); ++i) {
    isTold &= askMaster("registerPublisher", {(*published)[i][0], (*published)[i][1], uri_}).has_value();
  }
  for (int i = 0; i < taken->size(); ++i) {
    const XmlRpcValue topic = (*taken)[i][0];
    const auto known = askMaster("registerSubscriber", {topic, (*taken)[i][1], uri_});
    isTold &= known.has_value();
    if (known && known->size() > 0) isTold &= askNode(uri_, "publisherUpdate", {topic, *known}).has_value();
  }
  for (const auto& [service, uri] : services_) {
    isTold &= askMaster("registerService", {service, uri, uri_}).has_value();
  }
  for (const auto& [parameter, value] : parameters_) {
    auto isThere = askMaster("hasParam", {parameter});
    isTold &= isThere && (bool(*isThere) || askMaster("setParam", {parameter, value}).has_value());
  }
  return isTold;
}

std::string MasterWatch::faultOfClockIn(const XmlRpcValue& state) const {
  const std::vector<std::string> owners = nodesOf(state, publishers, "/clock");
  if (owners.size() < 2) return "";
  if (!contains(owners, name_) && !contains(nodesOf(state, subscribers, "/clock"), name_)) return "";
  std::string all;
  for (const std::string& owner : owners) all += (all.empty() ? "" : ", ") + owner;
  return "/clock has several publishers: " + all +
         "; time can have one owner, and jumps between them (rosnode cleanup strikes dead ones off the "
         "master's list)";
}

}  // namespace planar_chain
