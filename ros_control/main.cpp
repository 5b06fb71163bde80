/// planar_chain_control_node: a chain under controller_manager. Parameters: ~scene_file, and ~rate in Hz
/// (1000).

#include <controller_manager/controller_manager.h>
#include <planar_chain/scene_reader.h>
#include <ros/ros.h>

#include <fstream>
#include <sstream>

#include "chain_hardware.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "planar_chain_control");
  ros::NodeHandle node;
  ros::NodeHandle own("~");
  const std::string path = own.param<std::string>("scene_file", "");
  const double rate = own.param("rate", 1000.0);
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file || !(rate > 0)) {
    ROS_FATAL("expected ~scene_file, a file that can be read, and ~rate > 0 Hz; got \"%s\", %g", path.c_str(),
              rate);
    return 2;
  }
  try {
    planar_chain_control::ChainHardware hardware(planar_chain::readSceneText(text.str()));
    controller_manager::ControllerManager manager(&hardware, node);
    ros::AsyncSpinner spinner(1);  // services of the manager
    spinner.start();
    const ros::Duration period(1 / rate);
    for (ros::Rate loop(rate); ros::ok(); loop.sleep()) {
      const ros::Time now = ros::Time::now();
      hardware.read(now, period);
      manager.update(now, period);
      hardware.write(now, period);
    }
  } catch (const std::exception& failure) {
    ROS_FATAL("%s", failure.what());
    return 1;
  }
}
