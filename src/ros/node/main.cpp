/// planar_chain_node [--wait-for-recorder]: runs the scene in its private parameters.

#include <ros/init.h>
#include <ros/node_handle.h>
#include <ros/this_node.h>

#include <clocale>
#include <csignal>
#include <iostream>
#include <string>
#include <vector>

#include "ros/node/node.h"
#include "ros/node/parameters.h"

namespace {

constexpr const char* usage =
    "planar_chain_node [--wait-for-recorder] [NAME:=VALUE …]\n"
    "Simulates the scene in its private parameters. roslaunch planar_chain sim.launch loads one and starts "
    "it.\n"
    "  --wait-for-recorder  starts when a recorder has subscribed to every topic, or after 15 s\n";

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
  std::vector<std::string> given;
  ros::removeROSArgs(argc, argv, given);
  const bool waits = given.size() == 2 && given[1] == "--wait-for-recorder";
  if (given.size() > 1 && !waits) {
    const bool asks = given[1] == "--help" || given[1] == "-h";
    (asks ? std::cout : std::cerr) << usage;
    return asks ? 0 : 2;
  }
  ros::init(argc, argv, "planar_chain");
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
