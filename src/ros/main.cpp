/// planar_chain_node: the scene of the private parameters, running.

#include <ros/console.h>
#include <ros/init.h>
#include <ros/node_handle.h>

#include <clocale>

#include "planar_chain/ros/node.h"
#include "planar_chain/ros/parameters.h"
#include "planar_chain/ros/services.h"
#include "planar_chain/scene_reader.h"

int main(int argc, char** argv) {
  // The log writes m² as m?? in a locale without it; numbers keep their dot.
  std::setlocale(LC_CTYPE, "C.UTF-8");
  ros::init(argc, argv, "planar_chain");
  const ros::NodeHandle loggingLastsAsLongAsThis;
  try {
    planar_chain::Node node(planar_chain::readScene(planar_chain::privateParameters()));
    const planar_chain::Services services(node);
    node.run();
  } catch (const planar_chain::Refused& refused) {
    for (const auto& fault : refused.faults()) ROS_FATAL("%s", toString(fault).c_str());
    return 2;
  } catch (const std::exception& failure) {
    ROS_FATAL("%s", failure.what());
    return 1;
  }
}
