#include "ros/bag/bag_reader.h"

#include <planar_chain/SimStatus.h>
#include <ros/names.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Float64MultiArray.h>

#include <algorithm>
#include <boost/algorithm/string/predicate.hpp>
#include <cmath>
#include <cstdint>
#include <set>

#include "planar_chain/fault.h"
#include "reading/section.h"
#include "ros/bag/bags.h"
#include "ros/messages/pace.h"

namespace planar_chain {

namespace {

// Topics below a node's name.
const std::string jointTorques = "/joint_torques", jointTorque = "/joint_torque", linkForce = "/link_force";
const std::string commandsTaken = "/commands_taken";

[[noreturn]] void refuse(const std::string& path, const std::string& expected, const std::string& found) {
  throw Refused({{"--commands " + path, expected, found}});
}

bool hasFieldsOfItsKind(const CommandTaken& command) {
  return command.kind <= CommandTaken::RESET && std::isfinite(command.scene_time) &&
         command.joint_torque.size() == (command.kind == CommandTaken::JOINT_TORQUE ? 1 : 0) &&
         command.link_force.size() == (command.kind == CommandTaken::LINK_FORCE ? 1 : 0);
}

class Reader {
 public:
  Reader(const std::string& path, const std::optional<std::string>& node, double rate)
      : path_(path), rate_(rate), bag_(path) {
    for (const rosbag::ConnectionInfo* connection : rosbag::View(bag_).getConnections()) {
      topics_.insert(connection->topic);
    }
    node_ = node ? *node : onlyNode();
    jointStates_ = ros::names::append(ros::names::parentNamespace(node_), "joint_states");
    status_ = node_ + "/status";
  }

  RecordedCommands read(bool alsoEnd) {
    const bool isExact = topics_.count(node_ + commandsTaken) > 0;
    return {node_, isExact ? commandsByTick() : commandsByReceipt(), isExact, alsoEnd ? lastTick() : 0};
  }

 private:
  std::string onlyNode() const {
    std::set<std::string> nodes;
    for (const std::string& topic : topics_) {
      for (const std::string& name : {jointTorques, jointTorque, linkForce, commandsTaken}) {
        if (topic.size() > name.size() && boost::ends_with(topic, name)) {
          nodes.insert(topic.substr(0, topic.size() - name.size()));
        }
      }
    }
    if (nodes.empty()) refuse(path_, "a bag with commands on topics such as …" + commandsTaken, "none");
    if (nodes.size() > 1) throw Refused({{"--node", "one of " + inCommas(nodes), "nothing"}});
    return *nodes.begin();
  }

  template <class Message>
  boost::shared_ptr<Message> messageOf(const rosbag::MessageInstance& entry) const {
    if (const auto message = entry.instantiate<Message>()) return message;
    refuse(path_,
           entry.getTopic() + " of type " + ros::message_traits::datatype<Message>() +
               " as this version defines it",
           "another definition of " + entry.getDataType());
  }

  // ---- Commands with their ticks ---------------------------------------------------------------

  std::vector<CommandTaken> commandsByTick() {
    std::vector<CommandTaken> commands;
    rosbag::View view(bag_, rosbag::TopicQuery(node_ + commandsTaken));
    for (const rosbag::MessageInstance& entry : view) commands.push_back(*messageOf<CommandTaken>(entry));
    std::sort(commands.begin(), commands.end(),
              [](const CommandTaken& a, const CommandTaken& b) { return a.number < b.number; });

    std::uint64_t tickBefore = 0, number = 1;
    bool wasReset = false;
    for (const CommandTaken& command : commands) {
      if (command.number != number) {
        refuse(path_, "every command that the node took since its start",
               "number " + std::to_string(command.number) + " where " + std::to_string(number) + " is due");
      }
      if (!hasFieldsOfItsKind(command)) {
        refuse(path_, "commands with what their kind needs",
               "number " + std::to_string(number) + " of kind " + std::to_string(command.kind));
      }
      if (command.tick < tickBefore) {
        refuse(path_, "ticks that do not go back", std::to_string(command.tick));
      }
      wasReset = wasReset || command.kind == CommandTaken::RESET;
      // Until the first reset, scene time lies between the tick before and this one.
      const auto tick = static_cast<double>(command.tick);
      if (!wasReset && !(std::abs(command.scene_time * rate_ - tick) <= 1.01)) {
        refuse(path_, "commands of a node with ticks of " + toText(rate_) + " Hz (publish/rate, or --rate)",
               "tick " + std::to_string(command.tick) + " after " + toText(command.scene_time) + " s");
      }
      tickBefore = command.tick;
      ++number;
    }
    return commands;
  }

  // ---- Commands as rosbag received them --------------------------------------------------------

  std::vector<CommandTaken> commandsByReceipt() {
    const std::int64_t start = startOfSimTime();
    std::vector<CommandTaken> commands;
    std::optional<std::uint64_t> firstTick;
    std::uint64_t nextTick = 0;
    rosbag::View view(bag_, rosbag::TopicQuery(std::vector{jointStates_, node_ + jointTorques,
                                                           node_ + jointTorque, node_ + linkForce}));
    for (const rosbag::MessageInstance& entry : view) {
      if (entry.getTopic() == jointStates_) {
        const std::uint64_t tick = tickOf(messageOf<sensor_msgs::JointState>(entry)->header.stamp, start);
        if (!firstTick) firstTick = tick;
        nextTick = tick + 1;
      } else {
        commands.push_back(commandOf(entry, start));
        commands.back().tick = nextTick;
      }
    }
    if (!firstTick) refuse(path_, jointStates_ + ", whose stamps give the tick of a command", "none");

    std::uint64_t number = 0;
    for (CommandTaken& command : commands) {
      command.number = ++number;
      command.tick = std::max(command.tick, *firstTick);
      command.scene_time = static_cast<double>(std::max<std::uint64_t>(command.tick, 1) - 1) / rate_;
    }
    return commands;
  }

  CommandTaken commandOf(const rosbag::MessageInstance& entry, std::int64_t simStart) const {
    CommandTaken command;
    ros::Time start;
    if (entry.getTopic() == node_ + jointTorques) {
      command.kind = CommandTaken::JOINT_TORQUES;
      command.joint_torques = messageOf<std_msgs::Float64MultiArray>(entry)->data;
    } else if (entry.getTopic() == node_ + jointTorque) {
      command.kind = CommandTaken::JOINT_TORQUE;
      command.joint_torque.push_back(*messageOf<JointTorque>(entry));
      start = command.joint_torque.back().start;
    } else {
      command.kind = CommandTaken::LINK_FORCE;
      command.link_force.push_back(*messageOf<LinkForce>(entry));
      start = command.link_force.back().start;
    }
    command.start = static_cast<double>(static_cast<std::int64_t>(start.toNSec()) - simStart) * 1e-9;
    return command;
  }

  /// The stamp of sim time 0, ns. Pauses shift later stamps, so the earliest of all estimates holds.
  std::int64_t startOfSimTime() {
    std::optional<std::int64_t> start;
    rosbag::View view(bag_, rosbag::TopicQuery(status_));
    for (const rosbag::MessageInstance& entry : view) {
      const auto status = messageOf<SimStatus>(entry);
      if (status->tick_stamp.isZero()) continue;
      const std::int64_t estimate = static_cast<std::int64_t>(status->tick_stamp.toNSec()) -
                                    Pace(rate_).nanosecondsOf(static_cast<long long>(status->tick));
      start = std::min(start.value_or(estimate), estimate);
    }
    if (!start) refuse(path_, status_ + ", which gives the start of sim time", "none");
    return *start;
  }

  std::uint64_t tickOf(ros::Time stamp, std::int64_t simStart) const {
    const double elapsed = static_cast<double>(static_cast<std::int64_t>(stamp.toNSec()) - simStart) * 1e-9;
    const long long tick = std::llround(elapsed * rate_);
    if (tick < 0) refuse(path_, "joint_states after the start of sim time", toText(elapsed) + " s");
    return static_cast<std::uint64_t>(tick);
  }

  // ---- The end of the run ----------------------------------------------------------------------

  /// A status gives a tick and its stamp. Each joint_states with a later stamp is one tick more. Stamps alone
  /// do not give the tick, because they jump over pauses.
  long long lastTick() {
    std::uint64_t tick = 0;
    ros::Time stamp;
    std::set<ros::Time> later;
    rosbag::View view(bag_, rosbag::TopicQuery(std::vector{jointStates_, status_}));
    for (const rosbag::MessageInstance& entry : view) {
      if (entry.getTopic() == jointStates_) {
        later.insert(messageOf<sensor_msgs::JointState>(entry)->header.stamp);
      } else {
        const auto status = messageOf<SimStatus>(entry);
        if (status->tick > static_cast<std::uint64_t>(mostRows)) {
          refuse(path_, "ticks up to number 100000000", std::to_string(status->tick));
        }
        tick = status->tick;
        stamp = status->tick_stamp;
      }
      later.erase(later.begin(), later.upper_bound(stamp));
    }
    return static_cast<long long>(tick + later.size());
  }

  const std::string& path_;
  double rate_;  ///< of ticks, Hz
  rosbag::Bag bag_;
  std::set<std::string> topics_;
  std::string node_, jointStates_, status_;
};

}  // namespace

RecordedCommands readCommands(const std::string& path, const std::optional<std::string>& node, double rate,
                              bool alsoEnd) {
  try {
    return Reader(path, node, rate).read(alsoEnd);
  } catch (const rosbag::BagException& problem) {
    refuse(path, "a bag that can be read", problem.what());
  }
}

}  // namespace planar_chain
