#include "ros/node/parameters.h"

#include <ros/console.h>
#include <ros/names.h>
#include <ros/param.h>

#include <exception>
#include <utility>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/scene_reader.h"

namespace planar_chain {

namespace {

using XmlRpc::XmlRpcValue;

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
    case XmlRpcValue::TypeDateTime:
      faults.push_back({path, "a number, text, list or map", "a date"});
      return {};
    case XmlRpcValue::TypeBase64:
      faults.push_back({path, "a number, text, list or map", "binary data"});
      return {};
    case XmlRpcValue::TypeInvalid:
      return {};
  }
  return {};
}

}  // namespace

Value valueOf(const XmlRpcValue& parameter) {
  std::vector<Fault> faults;
  Value value = convert(parameter, "", faults);
  if (!faults.empty()) throw Refused(std::move(faults));
  return value;
}

Value sceneParameters(const std::string& node) {
  XmlRpcValue parameters;
  ros::param::get(node, parameters);
  if (!ros::param::has(node + "/chain") && !ros::param::has(node + "/links") &&
      !ros::param::has(node + "/robot_description")) {
    throw Refused({{node + "/chain",
                    "a scene in the node's parameters (roslaunch planar_chain sim.launch "
                    "scene:=double_pendulum, or rosparam load SCENE.yaml " +
                        node + " before the node starts)",
                    "nothing"}});
  }
  return valueOf(parameters);
}

int withScene(const std::string& node, const std::function<void(const Scene&)>& act) {
  try {
    act(readScene(sceneParameters(ros::names::resolve(node))));
    return 0;
  } catch (const Refused& refused) {
    for (const Fault& fault : refused.faults()) ROS_FATAL("%s", toString(fault).c_str());
    return 2;
  } catch (const std::exception& failure) {
    ROS_FATAL("%s", failure.what());
    return 1;
  }
}

}  // namespace planar_chain
