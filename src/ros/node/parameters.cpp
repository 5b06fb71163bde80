#include "ros/node/parameters.h"

#include <ros/console.h>
#include <ros/master.h>
#include <ros/names.h>
#include <ros/param.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <exception>
#include <utility>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/scene_reader.h"
#include "ros/messages/frames.h"

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
Scene sceneIn(const XmlRpcValue& parameters) {
  std::vector<Fault> faults;
  const Value value = convert(parameters, "", faults);
  if (!faults.empty()) throw Refused(std::move(faults));
  Scene scene = readScene(value);
  scene.text = toYaml(value);
  return scene;
}

}  // namespace

SceneParameters::SceneParameters(const std::string& node) : node_(ros::names::resolve(node)) {}

Scene SceneParameters::read() {
  if (!ros::param::has(node_ + "/chain") && !ros::param::has(node_ + "/links") &&
      !ros::param::has(node_ + "/robot_description")) {
    refuseNothing("roslaunch planar_chain sim.launch scene:=double_pendulum, or rosparam load SCENE.yaml " +
                  node_ + " before the node starts");
  }
  ros::param::get(node_, known_);
  return sceneIn(known_);
}

void SceneParameters::refuseNothing(const std::string& remedy) const {
  throw Refused({{node_ + "/chain", "a scene in the node's parameters (" + remedy + ")", "nothing"}});
}

std::optional<Scene> SceneParameters::readIfChanged() {
  XmlRpcValue now;
  const bool isThere = ros::param::get(node_, now);
  if (!isThere && ros::master::check()) refuseNothing("rosparam load SCENE.yaml " + node_);
  if (!isThere || now == known_) return std::nullopt;

  std::vector<Fault> faults;
  for (const char* key : {"publish", "real_time_factor"}) {
    const auto in = [&](const XmlRpcValue& map) { return map.hasMember(key) ? map[key] : XmlRpcValue(); };
    if (in(now) == in(known_)) continue;
    faults.push_back({key, "the value at the start (to change it, restart the node)", "another"});
  }
  std::optional<Scene> scene;
  try {
    scene = sceneIn(now);
    framesOf(*scene, node_);  // which may collide
  } catch (const Refused& refused) {
    faults.insert(faults.end(), refused.faults().begin(), refused.faults().end());
  }
  if (!faults.empty()) throw Refused(std::move(faults));
  known_ = now;
  return scene;
}

int SceneParameters::run(const std::function<void(const Scene&)>& act) {
  try {
    act(read());
    return 0;
  } catch (const Refused& refused) {
    if (node_ != ros::this_node::getName()) {
      ROS_FATAL("%s has no scene, or refuses it and says why", node_.c_str());
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
