/// pull: drag the links of a running simulation with the mouse, in rviz. The parameter ~simulation names its
/// node.

#include <ros/init.h>
#include <ros/names.h>
#include <ros/node_handle.h>

#include <clocale>

#include "ros/node/parameters.h"
#include "ros/pull/hand.h"

int main(int argc, char** argv) {
  std::setlocale(LC_CTYPE, "C.UTF-8");  // for signs like ² in the log
  ros::init(argc, argv, "pull");
  const ros::NodeHandle own("~");
  const auto simulation = own.param<std::string>("simulation", "planar_chain");
  return planar_chain::withScene(simulation, [&simulation](const planar_chain::Scene& scene) {
    const planar_chain::Hand hand(scene, ros::names::resolve(simulation));
    ros::spin();
  });
}
