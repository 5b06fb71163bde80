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

#include "reading/section.h"

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

/// Calls the master, http://wiki.ros.org/ROS/Master_API. Returns nothing without a successful answer.
std::optional<XmlRpcValue> callMaster(const char* method, std::initializer_list<XmlRpcValue> arguments) {
  XmlRpcValue response, payload;
  if (!ros::master::execute(method, requestOf(arguments), response, payload, false)) return std::nullopt;
  return payload;
}

/// Calls the node `uri`, http://wiki.ros.org/ROS/Slave_API. Returns nothing without a successful answer.
std::optional<XmlRpcValue> callNode(const std::string& uri, const char* method,
                                    std::initializer_list<XmlRpcValue> arguments) {
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(uri, host, port)) return std::nullopt;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpcValue response;
  if (!client.execute(method, requestOf(arguments), response) || client.isFault()) return std::nullopt;
  return response[2];
}

enum Part { publishers, subscribers, services };  // of getSystemState

/// Returns the nodes that the master knows for a topic or service.
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
  // Read what is registered now.
  if (const auto uri = callMaster("lookupNode", {name_})) uri_ = std::string(XmlRpcValue(*uri));
  if (auto state = callMaster("getSystemState", {})) {
    for (int i = 0; i < (*state)[services].size(); ++i) {
      const std::string service = (*state)[services][i][0];
      if (!contains(nodesOf(*state, services, service), name_)) continue;
      if (auto uri = callMaster("lookupService", {service})) services_[service] = std::string(*uri);
    }
  }
  for (const std::string& parameter : parameters) {
    if (const auto value = callMaster("getParam", {parameter})) parameters_[parameter] = *value;
  }
  thread_ = std::thread([this] { watch(); });
}

MasterWatch::~MasterWatch() {
  {
    const std::lock_guard lock(mutex_);
    isEnding_ = true;
  }
  end_.notify_all();
  thread_.join();
}

std::string MasterWatch::clockFault() const {
  const std::lock_guard lock(mutex_);
  return clockFault_;
}

void MasterWatch::watch() {
  std::unique_lock lock(mutex_);
  while (!end_.wait_for(lock, period, [this] { return isEnding_; })) {
    lock.unlock();
    std::string fault;
    try {
      fault = update();
    } catch (const XmlRpc::XmlRpcException&) {
      // The answer does not follow the API. Treat it as no answer.
    }
    lock.lock();
    clockFault_ = fault;
  }
}

/// Registers the node again if necessary. Returns the fault of /clock.
std::string MasterWatch::update() {
  const auto state = callMaster("getSystemState", {});
  if (!state) return "";
  // Every node publishes /rosout, so a master that does not know this has lost the node.
  if (!isRegistered_ || !contains(nodesOf(*state, publishers, "/rosout"), name_)) {
    isRegistered_ = registerAgain();
    if (isRegistered_) ROS_WARN("the master had lost this node: registered again");
  }
  const std::string fault = clockFaultIn(*state);
  const std::chrono::duration<double> now = std::chrono::steady_clock::now().time_since_epoch();
  if (!fault.empty() && warnings_.isDue(now.count())) ROS_WARN("%s", fault.c_str());
  return fault;
}

/// Returns true if every call succeeded.
bool MasterWatch::registerAgain() const {
  auto published = callNode(uri_, "getPublications", {}), taken = callNode(uri_, "getSubscriptions", {});
  if (!published || !taken) return false;
  bool isDone = true;
  for (int i = 0; i < published->size(); ++i) {
    isDone &= callMaster("registerPublisher", {(*published)[i][0], (*published)[i][1], uri_}).has_value();
  }
  // Connect to publishers that registered before this node did.
  for (int i = 0; i < taken->size(); ++i) {
    const XmlRpcValue topic = (*taken)[i][0];
    const auto known = callMaster("registerSubscriber", {topic, (*taken)[i][1], uri_});
    isDone &= known.has_value();
    if (known && known->size() > 0) isDone &= callNode(uri_, "publisherUpdate", {topic, *known}).has_value();
  }
  for (const auto& [service, uri] : services_) {
    isDone &= callMaster("registerService", {service, uri, uri_}).has_value();
  }
  for (const auto& [parameter, value] : parameters_) {
    auto isThere = callMaster("hasParam", {parameter});
    isDone &= isThere && (bool(*isThere) || callMaster("setParam", {parameter, value}).has_value());
  }
  return isDone;
}

std::string MasterWatch::clockFaultIn(const XmlRpcValue& state) const {
  const std::vector<std::string> owners = nodesOf(state, publishers, "/clock");
  if (owners.size() < 2) return "";
  if (!contains(owners, name_) && !contains(nodesOf(state, subscribers, "/clock"), name_)) return "";
  return "/clock has several publishers: " + inCommas(owners) +
         ". Time jumps between them. Stop all but one (rosnode cleanup removes dead nodes from the master)";
}

}  // namespace planar_chain
