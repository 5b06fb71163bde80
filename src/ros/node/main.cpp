/// planar_chain_node: the scene of the private parameters, running.

#include <ros/init.h>
#include <ros/node_handle.h>
#include <ros/this_node.h>

#include <clocale>
#include <csignal>

#include "ros/node/node.h"
#include "ros/node/parameters.h"
#include "ros/node/services.h"

namespace {

volatile std::sig_atomic_t endIsAsked = 0;

void askForTheEnd(int /*signal*/) {
  endIsAsked = 1;
}

bool goesOn() {
  return endIsAsked == 0 && !ros::isShuttingDown();
}

}  // namespace

int main(int argc, char** argv) {
  // The log writes m² as m?? in a locale without it; numbers keep their dot.
  std::setlocale(LC_CTYPE, "C.UTF-8");
  ros::init(argc, argv, "planar_chain");
  const ros::NodeHandle loggingLastsAsLongAsThis;
  return planar_chain::withScene(ros::this_node::getName(), [](const planar_chain::Scene& scene) {
    planar_chain::Node node(scene);
    const planar_chain::Services services(node);
    // Not roscpp's own way, which takes everything down in another thread, in the middle of a tick. While the
    // master is waited for, above, that is what is wanted.
    std::signal(SIGINT, askForTheEnd);
    std::signal(SIGTERM, askForTheEnd);
    node.run(goesOn);
  });
}
