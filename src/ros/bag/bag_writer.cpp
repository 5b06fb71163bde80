#include "ros/bag/bag_writer.h"

#include <ros/names.h>

namespace planar_chain {

BagWriter::BagWriter(const std::string& path, const Scene& scene, const std::string& node)
    : settings_(scene.publish),
      frames_(framesOf(scene, ros::names::parentNamespace(node))),
      messages_(scene, frames_),
      pace_(settings_.rate),
      file_(path) {
  const std::string outer = ros::names::parentNamespace(node);
  clockOut_ = file_.connect<rosgraph_msgs::Clock>("/clock", node);
  jointStatesOut_ = file_.connect<sensor_msgs::JointState>(ros::names::append(outer, "joint_states"), node);
  tfOut_ = file_.connect<tf2_msgs::TFMessage>("/tf", node);
  staticTfOut_ = file_.connect<tf2_msgs::TFMessage>("/tf_static", node, true);
  linkStatesOut_ = file_.connect<LinkStates>(node + "/link_states", node);
  statusOut_ = file_.connect<SimStatus>(node + "/status", node);
  commandsOut_ = file_.connect<CommandTaken>(node + "/commands_taken", node);
  status_.header.frame_id = frames_.base;
}

void BagWriter::tick(long long k, double simTime, const Simulation& simulation, const Commands& commands) {
  ros::Time stamp;
  stamp.fromNSec(static_cast<std::uint64_t>(pace_.nanosecondsOf(k)));

  clock_.clock = stamp;
  file_.write(clockOut_, stamp, clock_);
  for (const CommandTaken& taken : taken_) file_.write(commandsOut_, stamp, taken);
  taken_.clear();

  const bool isGood = simulation.fault().empty();
  if (isGood) {
    writeState(k, stamp, simulation);
    status_.tick = static_cast<std::uint64_t>(k);
    status_.tick_stamp = stamp;
  }
  if (!isGood || pace_.falls(k, settings_.statusRate)) writeStatus(stamp, simTime, simulation, commands);
}

void BagWriter::writeState(long long k, ros::Time stamp, const Simulation& simulation) {
  if (settings_.tf && k == 1) {
    tf2_msgs::TFMessage base;
    base.transforms.push_back(Messages::baseInWorld(frames_, stamp));
    file_.write(staticTfOut_, stamp, base);
  }
  file_.write(jointStatesOut_, stamp, messages_.jointStates(simulation, stamp));
  if (settings_.tf && pace_.falls(k, settings_.tfRate)) {
    file_.write(tfOut_, stamp, messages_.transforms(simulation, stamp));
  }
  if (settings_.linkStates) {
    file_.write(linkStatesOut_, stamp, messages_.linkStates(simulation, stamp));
  }
}

void BagWriter::writeStatus(ros::Time stamp, double simTime, const Simulation& simulation,
                            const Commands& commands) {
  status_.header.stamp = stamp;
  describe(simulation, status_);
  status_.sim_time = simTime;
  if (!simulation.fault().empty()) status_.standstill = standstillByFault;
  commands.describe(status_);
  file_.write(statusOut_, stamp, status_);
}

}  // namespace planar_chain
