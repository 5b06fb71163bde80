/// pull: drag the links of a running simulation with the mouse, in rviz. The parameter ~simulation names its
/// node.

#include <ros/console.h>
#include <ros/init.h>
#include <ros/names.h>
#include <ros/node_handle.h>

#include <clocale>

#include "planar_chain/ros/hand.h"
#include "planar_chain/ros/parameters.h"
#include "planar_chain/scene_reader.h"

int main(int argc, char** argv) {
  std::setlocale(LC_CTYPE, "C.UTF-8");  // for signs like ² in the log
  ros::init(argc, argv, "pull");
  const ros::NodeHandle own("~");
  try {
    const std::string simulation = ros::names::resolve(own.param<std::string>("simulation", "planar_chain"));
    const planar_chain::Hand hand(planar_chain::readScene(planar_chain::sceneParameters(simulation)),
                                  simulation);
    ros::spin();
  } catch (const planar_chain::Refused& refused) {
    for (const auto& fault : refused.faults()) ROS_FATAL("%s", toString(fault).c_str());
    return 2;
  } catch (const std::exception& failure) {
    ROS_FATAL("%s", failure.what());
    return 1;
  }
}
