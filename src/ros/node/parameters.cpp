#include "ros/node/parameters.h"

#include <ros/console.h>
#include <ros/names.h>
#include <ros/param.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <exception>
#include <utility>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/scene_reader.h"

namespace planar_chain {

namespace {

using XmlRpc::XmlRpcValue;

/// Converts a parameter. Adds a fault for each type that no scene has: dates and binary data.
Value convert(const XmlRpcValue& parameter, const std::string& path, std::vector<Fault>& faults) {
  switch (parameter.getType()) {
    case XmlRpcValue::TypeBoolean:
      return static_cast<const bool&>(parameter);
    case XmlRpcValue::TypeInt:
      return static_cast<const int&>(parameter);
    case XmlRpcValue::TypeDouble:
      return static_cast<const double&>(parameter);
    case XmlRpcValue::TypeString:
      return static_cast<const std::string&>(parameter);
    case XmlRpcValue::TypeArray: {
      Value::List list;
      for (int i = 0; i < parameter.size(); ++i) {
        list.push_back(convert(parameter[i], path + "[" + std::to_string(i) + "]", faults));
      }
      return list;
    }
    case XmlRpcValue::TypeStruct: {
      Value::Map map;
      for (const auto& [key, value] : parameter) {
        map.emplace(key, convert(value, path.empty() ? key : path + "/" + key, faults));
      }
      return map;
    }
    case XmlRpcValue::TypeInvalid:
      return {};
    default:
      const bool isDate = parameter.getType() == XmlRpcValue::TypeDateTime;
      faults.push_back({path, "a number, text, list or map", isDate ? "a date" : "binary data"});
      return {};
  }
}

/// @throws Refused
Value sceneParameters(const std::string& node) {
  if (!ros::param::has(node + "/chain") && !ros::param::has(node + "/links") &&
      !ros::param::has(node + "/robot_description")) {
    throw Refused({{node + "/chain",
                    "a scene in the node's parameters (roslaunch planar_chain sim.launch "
                    "scene:=double_pendulum, or rosparam load SCENE.yaml " +
                        node + " before the node starts)",
                    "nothing"}});
  }
  XmlRpcValue parameters;
  ros::param::get(node, parameters);
  std::vector<Fault> faults;
  Value value = convert(parameters, "", faults);
  if (!faults.empty()) throw Refused(std::move(faults));
  return value;
}

}  // namespace

int withScene(const std::string& node, const std::function<void(const Scene&)>& act) {
  const std::string name = ros::names::resolve(node);
  try {
    act(readScene(sceneParameters(name)));
    return 0;
  } catch (const Refused& refused) {
    if (name != ros::this_node::getName()) {
      ROS_FATAL("%s has no scene, or refuses it and says why", name.c_str());
      return 2;
    }
    for (const Fault& fault : refused.faults()) ROS_FATAL("%s", toString(fault).c_str());
    return 2;
  } catch (const std::exception& failure) {
    ROS_FATAL("%s", failure.what());
    return 1;
  }
}

}  // namespace planar_chain
