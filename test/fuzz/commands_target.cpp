/// Any run of commands is taken or refused, one by one, with its reason; the chain stays finite, and no
/// number of the status is not.

#include <ros/console.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "bytes.h"
#include "planar_chain/scene_reader.h"
#include "ros/node/commands.h"

namespace planar_chain {
namespace {

void takeOne(Bytes& bytes, Commands& commands) {
  switch (bytes.take<std::uint8_t>() % 3) {
    case 0: {
      std::vector<double> torques(bytes.take<std::uint8_t>() % 5);
      for (double& torque : torques) torque = bytes.take<double>();
      return commands.onJointTorques(torques);
    }
    case 1: {
      JointTorque message;
      message.joint = bytes.name({"a_joint", "b_joint"});
      message.torque = bytes.take<double>();
      message.duration = bytes.take<double>();
      message.start.sec = bytes.take<std::uint32_t>();
      message.start.nsec = bytes.take<std::uint32_t>();
      return commands.onJointTorque(message);
    }
    default: {
      LinkForce message;
      message.link = bytes.name({"a", "b"});
      for (double* part : {&message.point.x, &message.point.y, &message.force.x, &message.force.y,
                           &message.moment, &message.duration, &message.point.z, &message.force.z}) {
        *part = bytes.take<double>();
      }
      message.start.sec = bytes.take<std::uint32_t>();
      return commands.onLinkForce(message);
    }
  }
}

void requireFinite(const Simulation& simulation) {
  for (const auto* numbers : {&simulation.q(), &simulation.qd()}) {
    for (const double number : *numbers) require(std::isfinite(number));
  }
}

/// A moment of a billion N m makes the chain turn a million times a second, which takes as many steps as it
/// takes: there the run is cut short, as the node cuts its ticks.
int patience = 0;
bool goesOn() {
  return --patience > 0;
}

const Scene& scene() {
  static const Scene one = readSceneText(
      "chain: [a, b]\n"
      "links:\n"
      "  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0]}\n"
      "  b: {mass: 2, inertia: 0.1, com: [0.3, 0], pin: [0.4, 0.1]}\n"
      "integrator: {method: rk4, step: 0.01}\n");
  return one;
}

}  // namespace
}  // namespace planar_chain

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planar_chain;
  ros::console::set_logger_level(ROSCONSOLE_DEFAULT_NAME, ros::console::levels::Fatal);

  Simulation simulation(scene(), Commands::capacity);
  Ticks ticks{100};
  Commands commands(ticks, [](ros::Time stamp) { return stamp.toSec() - 1e9; });
  commands.moveTo(simulation);
  Bytes bytes(data, size);
  std::uint64_t refusals = 0;
  while (!bytes.empty()) {
    takeOne(bytes, commands);
    SimStatus status;
    commands.describe(status);
    require(status.rejected_commands >= refusals && status.rejected_commands <= refusals + 1);
    require((status.rejected_commands == 0) == status.last_rejection.empty());
    require(status.last_rejection.size() < 2000);
    for (const double age : {status.joint_torques_age, status.joint_torque_age, status.link_force_age}) {
      require(age == -1 || (age >= 0 && std::isfinite(age)));
    }
    refusals = status.rejected_commands;

    patience = 50;
    if (simulation.fault().empty()) simulation.advanceTo(simulation.time() + 0.01, goesOn);
    requireFinite(simulation);
  }
  return 0;
}
