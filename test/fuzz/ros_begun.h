#pragma once

/// For targets that are a node: once, and without a word in the log.

#include <ros/console.h>
#include <ros/init.h>

namespace planar_chain {

inline void beginRos(const char* name) {
  int none = 0;
  ros::init(none, nullptr, name, ros::init_options::NoSigintHandler | ros::init_options::NoRosout);
  ros::console::set_logger_level(ROSCONSOLE_DEFAULT_NAME, ros::console::levels::Fatal);
}

}  // namespace planar_chain
