#include "ros/bag/bag_reader.h"

#include <planar_chain/SimStatus.h>
#include <ros/names.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/JointState.h>

#include <algorithm>
#include <boost/algorithm/string/predicate.hpp>
#include <cmath>
#include <cstdint>
#include <set>

#include "planar_chain/fault.h"
#include "reading/section.h"
#include "ros/bag/bags.h"

namespace planar_chain {

namespace {

const std::string commandsTaken = "/commands_taken";  // below a node's name

[[noreturn]] void refuse(const std::string& path, const std::string& expected, const std::string& found) {
  throw Refused({{"--commands " + path, expected, found}});
}

/// Returns the only node with ~commands_taken.
std::string onlyNode(const rosbag::Bag& bag, const std::string& path) {
  std::set<std::string> nodes;
  for (const rosbag::ConnectionInfo* connection : rosbag::View(bag).getConnections()) {
    const std::string& topic = connection->topic;
    if (boost::ends_with(topic, commandsTaken)) {
      nodes.insert(topic.substr(0, topic.size() - commandsTaken.size()));
    }
  }
  if (nodes.empty()) refuse(path, "a bag with commands on a topic such as …" + commandsTaken, "none");
  if (nodes.size() > 1) throw Refused({{"--node", "one of " + inCommas(nodes), "nothing"}});
  return *nodes.begin();
}

template <class Message>
boost::shared_ptr<Message> messageOf(const rosbag::MessageInstance& entry, const std::string& path) {
  if (const auto message = entry.instantiate<Message>()) return message;
  refuse(path,
         entry.getTopic() + " of type " + ros::message_traits::datatype<Message>() +
             " as this version defines it",
         "another definition of " + entry.getDataType());
}

bool hasFieldsOfItsKind(const CommandTaken& command) {
  return command.kind <= CommandTaken::RESET && std::isfinite(command.scene_time) &&
         command.joint_torque.size() == (command.kind == CommandTaken::JOINT_TORQUE ? 1 : 0) &&
         command.link_force.size() == (command.kind == CommandTaken::LINK_FORCE ? 1 : 0);
}

/// @throws Refused if one of them is missing, is not what its kind needs, or does not fit the ticks
void check(const std::vector<CommandTaken>& commands, double rate, const std::string& path) {
  std::uint64_t tickBefore = 0, number = 1;
  bool wasReset = false;
  for (const CommandTaken& command : commands) {
    if (command.number != number) {
      refuse(path, "every command that the node took since its start",
             "number " + std::to_string(command.number) + " where " + std::to_string(number) + " is due");
    }
    if (!hasFieldsOfItsKind(command)) {
      refuse(path, "commands with what their kind needs",
             "number " + std::to_string(number) + " of kind " + std::to_string(command.kind));
    }
    if (command.tick < tickBefore) refuse(path, "ticks that do not go back", std::to_string(command.tick));
    wasReset = wasReset || command.kind == CommandTaken::RESET;
    // Until the first reset, scene time lies between the tick before and this one.
    const auto tick = static_cast<double>(command.tick);
    if (!wasReset && !(std::abs(command.scene_time * rate - tick) <= 1.01)) {
      refuse(path, "commands of a node with ticks of " + toText(rate) + " Hz (publish/rate, or --rate)",
             "tick " + std::to_string(command.tick) + " after " + toText(command.scene_time) + " s");
    }
    tickBefore = command.tick;
    ++number;
  }
}

/// Returns the last tick in the bag. A status gives a tick and its stamp. Each joint_states with a later
/// stamp is one tick more. Stamps alone do not give the tick, because they jump over pauses.
long long lastTick(const rosbag::Bag& bag, const std::string& node, const std::string& path) {
  const std::string states = ros::names::append(ros::names::parentNamespace(node), "joint_states");
  std::uint64_t tick = 0;
  ros::Time stamp;
  std::set<ros::Time> later;
  rosbag::View view(bag, rosbag::TopicQuery(std::vector{states, node + "/status"}));
  for (const rosbag::MessageInstance& entry : view) {
    if (entry.getTopic() == states) {
      later.insert(messageOf<sensor_msgs::JointState>(entry, path)->header.stamp);
    } else {
      const auto status = messageOf<SimStatus>(entry, path);
      if (status->tick > static_cast<std::uint64_t>(mostRows)) {
        refuse(path, "ticks up to number 100000000", std::to_string(status->tick));
      }
      tick = status->tick;
      stamp = status->tick_stamp;
    }
    later.erase(later.begin(), later.upper_bound(stamp));
  }
  return static_cast<long long>(tick + later.size());
}

}  // namespace

RecordedCommands readCommands(const std::string& path, const std::optional<std::string>& node, double rate,
                              bool alsoEnd) {
  try {
    const rosbag::Bag bag(path);
    RecordedCommands recorded{node ? *node : onlyNode(bag, path), {}, 0};

    const std::string topic = recorded.node + commandsTaken;
    rosbag::View view(bag, rosbag::TopicQuery(topic));
    if (view.size() == 0) refuse(path, "a bag with commands on " + topic, "none");
    std::vector<CommandTaken>& commands = recorded.commands;
    for (const rosbag::MessageInstance& entry : view)
      commands.push_back(*messageOf<CommandTaken>(entry, path));
    std::sort(commands.begin(), commands.end(),
              [](const CommandTaken& a, const CommandTaken& b) { return a.number < b.number; });
    check(commands, rate, path);
    if (alsoEnd) recorded.lastTick = lastTick(bag, recorded.node, path);
    return recorded;
  } catch (const rosbag::BagException& problem) {
    refuse(path, "a bag that can be read", problem.what());
  }
}

}  // namespace planar_chain
