/// planar_chain_node [--wait-for-recorder]: runs the scene in its private parameters.

#include <ros/init.h>
#include <ros/node_handle.h>
#include <ros/this_node.h>

#include <clocale>
#include <csignal>
#include <string>

#include "ros/node/node.h"
#include "ros/node/parameters.h"

namespace {

volatile std::sig_atomic_t isEnding = 0;

void end(int /*signal*/) {
  isEnding = 1;
}

bool keepGoing() {
  return isEnding == 0 && !ros::isShuttingDown();
}

}  // namespace

int main(int argc, char** argv) {
  // Let the log write signs such as ²; LC_NUMERIC stays, with its decimal point.
  std::setlocale(LC_CTYPE, "C.UTF-8");
  ros::init(argc, argv, "planar_chain");
  const bool waits = argc > 1 && argv[1] == std::string("--wait-for-recorder");
  const ros::NodeHandle keepsLoggingAlive;
  planar_chain::SceneParameters parameters(ros::this_node::getName());
  return parameters.run([&](const planar_chain::Scene& scene) {
    planar_chain::Node node(scene, [&] { return parameters.readIfChanged(); });
    // roscpp's own handler would shut down in another thread, in the middle of a tick. Until here it is
    // wanted: it ends the wait for a master.
    std::signal(SIGINT, end);
    std::signal(SIGTERM, end);
    if (waits) node.waitForRecorder(keepGoing);
    node.run(keepGoing);
  });
}
