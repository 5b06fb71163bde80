#include "ros/node/master_watch.h"

#include <ros/connection_manager.h>
#include <ros/console.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>
#include <xmlrpcpp/XmlRpcClient.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>
#include <initializer_list>

#include "reading/section.h"

namespace planar_chain {

namespace {

using XmlRpc::XmlRpcException;
using XmlRpc::XmlRpcValue;

const ros::WallDuration period(2);

XmlRpcValue requestOf(std::initializer_list<XmlRpcValue> arguments) {
  XmlRpcValue request;
  request[0] = ros::this_node::getName();
  for (const XmlRpcValue& argument : arguments) request[request.size()] = argument;
  return request;
}

/// Calls the master, http://wiki.ros.org/ROS/Master_API.
/// @throws XmlRpcException without a successful answer
XmlRpcValue callMaster(const char* method, std::initializer_list<XmlRpcValue> arguments) {
  XmlRpcValue response, payload;
  if (ros::master::execute(method, requestOf(arguments), response, payload, false)) return payload;
  throw XmlRpcException("the master does not answer");
}

const std::string& ownUri() {
  return ros::XMLRPCManager::instance()->getServerURI();
}

/// Calls this node as the master does, http://wiki.ros.org/ROS/Slave_API.
/// @throws XmlRpcException without a successful answer
XmlRpcValue callThisNode(const char* method, std::initializer_list<XmlRpcValue> arguments) {
  std::string host;
  std::uint32_t port = 0;
  ros::network::splitURI(ownUri(), host, port);
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpcValue response;
  if (client.execute(method, requestOf(arguments), response) && !client.isFault()) return response[2];
  throw XmlRpcException("the node does not answer");
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

bool hasThisNode(const std::vector<std::string>& nodes) {
  return std::count(nodes.begin(), nodes.end(), ros::this_node::getName()) > 0;
}

std::string clockFaultIn(const XmlRpcValue& state) {
  const std::vector<std::string> owners = nodesOf(state, publishers, "/clock");
  if (owners.size() < 2) return "";
  if (!hasThisNode(owners) && !hasThisNode(nodesOf(state, subscribers, "/clock"))) return "";
  return "/clock has several publishers: " + inCommas(owners) +
         ". Time jumps between them. Stop all but one (rosnode cleanup removes dead nodes from the master)";
}

}  // namespace

MasterWatch::MasterWatch(const std::vector<std::string>& parameters) {
  // Read what is registered now.
  try {
    const XmlRpcValue state = callMaster("getSystemState", {});
    for (int i = 0; i < state[services].size(); ++i) {
      const std::string service = state[services][i][0];
      if (hasThisNode(nodesOf(state, services, service))) services_.push_back(service);
    }
  } catch (const XmlRpcException&) {
    // The master has died since.
  }
  for (const std::string& parameter : parameters) {
    XmlRpcValue value;
    if (handle_.getParam(parameter, value)) parameters_[parameter] = value;
  }

  // Watch. The timer is steady, so setting the machine's clock does not stop it.
  handle_.setCallbackQueue(&queue_);
  timer_ = handle_.createSteadyTimer(period, [this](const ros::SteadyTimerEvent& /*now*/) {
    std::string fault;
    try {
      fault = update();
    } catch (const XmlRpcException&) {
      // There is no answer, or none that follows the API.
    }
    const std::lock_guard lock(mutex_);
    clockFault_ = fault;
  });
  thread_.start();
}

std::string MasterWatch::clockFault() const {
  const std::lock_guard lock(mutex_);
  return clockFault_;
}

/// Registers the node again if necessary. Returns the fault of /clock.
std::string MasterWatch::update() {
  const XmlRpcValue state = callMaster("getSystemState", {});
  // Every node publishes /rosout, so a master that does not know this has lost the node.
  isRegistered_ = isRegistered_ && hasThisNode(nodesOf(state, publishers, "/rosout"));
  if (!isRegistered_) {
    registerAgain();
    isRegistered_ = true;
    ROS_WARN("the master had lost this node: registered again");
  }
  const std::string fault = clockFaultIn(state);
  if (!fault.empty() && warnings_.isDue()) ROS_WARN("%s", fault.c_str());
  return fault;
}

void MasterWatch::registerAgain() const {
  const XmlRpcValue published = callThisNode("getPublications", {});
  for (int i = 0; i < published.size(); ++i) {
    callMaster("registerPublisher", {published[i][0], published[i][1], ownUri()});
  }
  // Connect to publishers that registered before this node did.
  const XmlRpcValue taken = callThisNode("getSubscriptions", {});
  for (int i = 0; i < taken.size(); ++i) {
    const XmlRpcValue known = callMaster("registerSubscriber", {taken[i][0], taken[i][1], ownUri()});
    if (known.size() > 0) callThisNode("publisherUpdate", {taken[i][0], known});
  }
  const std::string serviceUri = "rosrpc://" + ros::network::getHost() + ":" +
                                 std::to_string(ros::ConnectionManager::instance()->getTCPPort());
  for (const std::string& service : services_) {
    callMaster("registerService", {service, serviceUri, ownUri()});
  }
  for (const auto& [parameter, value] : parameters_) {
    if (!bool(callMaster("hasParam", {parameter}))) callMaster("setParam", {parameter, value});
  }
}

}  // namespace planar_chain
