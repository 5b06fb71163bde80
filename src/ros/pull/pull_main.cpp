/// pull: drags the links of a running simulation with the mouse, in rviz. The parameter ~simulation is the
/// name of its node.

#include <ros/init.h>
#include <ros/names.h>
#include <ros/node_handle.h>

#include <clocale>

#include "ros/node/parameters.h"
#include "ros/pull/mouse_drag.h"

int main(int argc, char** argv) {
  std::setlocale(LC_CTYPE, "C.UTF-8");  // let the log write signs such as ²
  ros::init(argc, argv, "pull");
  const ros::NodeHandle own("~");
  const auto simulation = own.param<std::string>("simulation", "planar_chain");
  return planar_chain::withScene(simulation, [&simulation](const planar_chain::Scene& scene) {
    const planar_chain::MouseDrag drag(scene, ros::names::resolve(simulation));
    ros::spin();
  });
}
