#include "ros/bag/bag_writer.h"

#include <ros/names.h>

#include <boost/make_shared.hpp>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace planar_chain {

BagWriter::BagWriter(const std::string& path, const Scene& scene, const std::string& node)
    : settings_(scene.publish),
      frames_(framesOf(scene, ros::names::parentNamespace(node))),
      messages_(scene, frames_),
      pace_(settings_.rate),
      path_(path),
      node_(node),
      bag_(new rosbag::Bag),
      jointStatesOut_{ros::names::append(ros::names::parentNamespace(node), "joint_states")},
      linkStatesOut_{node + "/link_states"},
      statusOut_{node + "/status"},
      commandsOut_{node + "/commands_taken"} {
  status_.header.frame_id = frames_.base;
  attempt([&] { bag_->open(path_, rosbag::bagmode::Write); });
}

void BagWriter::close() {
  attempt([&] { bag_->close(); });
}

void BagWriter::tick(long long k, double simTime, const Simulation& simulation,
                     const CommandTopics& commands) {
  ros::Time stamp;
  stamp.fromNSec(static_cast<std::uint64_t>(pace_.nanosecondsOf(k)));

  clock_.clock = stamp;
  write(clockOut_, stamp, clock_);
  for (CommandTaken& taken : taken_) write(commandsOut_, stamp, taken);
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
    write(staticTfOut_, stamp, base);
  }
  write(jointStatesOut_, stamp, messages_.jointStates(simulation, stamp));
  if (settings_.tf && pace_.falls(k, settings_.tfRate)) {
    write(tfOut_, stamp, messages_.transforms(simulation, stamp));
  }
  if (settings_.linkStates) write(linkStatesOut_, stamp, messages_.linkStates(simulation, stamp));
}

void BagWriter::writeStatus(ros::Time stamp, double simTime, const Simulation& simulation,
                            const CommandTopics& commands) {
  status_.header.stamp = stamp;
  describe(simulation, status_);
  status_.sim_time = simTime;
  if (!simulation.fault().empty()) status_.standstill = standstillByFault;
  commands.describe(status_);
  write(statusOut_, stamp, status_);
}

/// As ros::Publisher does, sets header.seq to the number of messages before, if the message has a header.
template <class Message>
void BagWriter::write(Topic& topic, ros::Time stamp, Message& message) {
  namespace traits = ros::message_traits;
  if (!topic.connection) {
    topic.connection =
        boost::make_shared<ros::M_string>(ros::M_string{{"callerid", node_},
                                                        {"latching", topic.isLatched ? "1" : "0"},
                                                        {"md5sum", traits::md5sum<Message>()},
                                                        {"message_definition", traits::definition<Message>()},
                                                        {"topic", topic.name},
                                                        {"type", traits::datatype<Message>()}});
  }
  if (auto* const header = traits::header(message)) header->seq = topic.messages++;
  attempt([&] { bag_->write(topic.name, stamp, message, topic.connection); });
}

/// rosbag's exceptions name neither the file nor the reason.
template <class Operation>
void BagWriter::attempt(Operation operation) const {
  try {
    operation();
  } catch (const rosbag::BagException&) {
    throw std::runtime_error("cannot write " + path_ + ": " + std::strerror(errno));
  }
}

}  // namespace planar_chain
