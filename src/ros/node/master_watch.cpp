#include "ros/node/master_watch.h"

#include <ros/connection_manager.h>
#include <ros/console.h>
#include <ros/master.h>
#include <ros/names.h>
#include <ros/network.h>
#include <ros/param.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>
#include <xmlrpcpp/XmlRpcClient.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>
#include <chrono>
#include <initializer_list>
#include <vector>

#include "reading/section.h"

namespace planar_chain {

namespace {

using XmlRpc::XmlRpcException;
using XmlRpc::XmlRpcValue;

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

/// Returns the nodes of each topic or service.
std::map<std::string, std::vector<std::string>> nodesIn(const XmlRpcValue& part) {
  std::map<std::string, std::vector<std::string>> nodes;
  for (int i = 0; i < part.size(); ++i) {
    for (int j = 0; j < part[i][1].size(); ++j) nodes[part[i][0]].push_back(part[i][1][j]);
  }
  return nodes;
}

bool hasThisNode(const std::vector<std::string>& nodes) {
  return std::count(nodes.begin(), nodes.end(), ros::this_node::getName()) > 0;
}

std::string clockFaultIn(const XmlRpcValue& state) {
  const std::vector<std::string> owners = nodesIn(state[publishers])["/clock"];
  if (owners.size() < 2) return "";
  if (!hasThisNode(owners) && !hasThisNode(nodesIn(state[subscribers])["/clock"])) return "";
  return "/clock has several publishers: " + inCommas(owners) +
         ". Time jumps between them. Stop all but one (rosnode cleanup removes dead nodes from the master)";
}

}  // namespace

MasterWatch::MasterWatch() {
  for (const std::string& parameter :
       {ros::this_node::getName(), ros::names::resolve("robot_description"), std::string("/use_sim_time")}) {
    XmlRpcValue value;
    if (ros::param::get(parameter, value)) parameters_[parameter] = value;
  }
  update();
  pending_.wait();
}

void MasterWatch::update() {
  if (pending_.valid() && pending_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    clockFault_ = pending_.get();
  }
  if (!pending_.valid() && checks_.isDue()) {
    pending_ = std::async(std::launch::async, [this] { return check(); });
  }
}

/// Registers the node again if necessary. Returns the fault of /clock; none if the master does not answer.
std::string MasterWatch::check() {
  try {
    const XmlRpcValue state = callMaster("getSystemState", {});
    // Every node publishes /rosout, so a master that does not know this has lost the node.
    isRegistered_ = isRegistered_ && hasThisNode(nodesIn(state[publishers])["/rosout"]);
    if (isRegistered_) {
      known_ = state;
    } else {
      registerAgain();
      isRegistered_ = true;
      ROS_WARN("the master had lost this node: registered again");
    }
    const std::string fault = clockFaultIn(state);
    if (!fault.empty() && warnings_.isDue()) ROS_WARN("%s", fault.c_str());
    return fault;
  } catch (const XmlRpcException&) {
    return "";
  }
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
  for (const auto& [parameter, value] : parameters_) {
    if (!bool(callMaster("hasParam", {parameter}))) callMaster("setParam", {parameter, value});
  }
  if (!known_.valid()) return;  // no master has had the node
  const std::string serviceUri = "rosrpc://" + ros::network::getHost() + ":" +
                                 std::to_string(ros::ConnectionManager::instance()->getTCPPort());
  for (const auto& [service, nodes] : nodesIn(known_[services])) {
    if (hasThisNode(nodes)) callMaster("registerService", {service, serviceUri, ownUri()});
  }
}

}  // namespace planar_chain
