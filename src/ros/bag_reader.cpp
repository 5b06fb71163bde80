#include "planar_chain/ros/bag_reader.h"

#include <planar_chain/SimStatus.h>
#include <ros/names.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Float64MultiArray.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>
#include <utility>

#include "planar_chain/fault.h"
#include "planar_chain/ros/pace.h"
#include "planar_chain/value.h"

namespace planar_chain {

namespace {

constexpr const char* option = "--commands";
const std::string taken = "/commands_taken";
const std::vector<std::string> received = {"/joint_torques", "/joint_torque", "/link_force"};

[[noreturn]] void refuse(const std::string& path, const std::string& expected, const std::string& found) {
  throw Refused({{std::string(option) + " " + path, expected, found}});
}

/// The node's name, where `topic` is `name` below it.
std::optional<std::string> nodeOf(const std::string& topic, const std::string& name) {
  const bool isBelow =
      topic.size() > name.size() && topic.compare(topic.size() - name.size(), name.size(), name) == 0;
  return isBelow ? std::optional(topic.substr(0, topic.size() - name.size())) : std::nullopt;
}

class Reader {
 public:
  Reader(const std::string& path, const std::optional<std::string>& node, double rate)
      : path_(path), pace_(rate), bag_(path, rosbag::bagmode::Read) {
    for (const rosbag::ConnectionInfo* connection : rosbag::View(bag_).getConnections()) {
      topics_.insert(connection->topic);
    }
    node_ = node ? *node : onlyNode();
  }

  RecordedCommands read() {
    if (topics_.count(node_ + taken) > 0) return {node_, whatTheNodeTook(), true};
    return {node_, whatWasReceived(), false};
  }

 private:
  std::string onlyNode() const {
    std::set<std::string> nodes;
    for (const std::string& topic : topics_) {
      if (const auto found = nodeOf(topic, taken)) nodes.insert(*found);
      for (const std::string& name : received) {
        if (const auto found = nodeOf(topic, name)) nodes.insert(*found);
      }
    }
    if (nodes.empty()) refuse(path_, "a bag with commands on topics such as …" + taken, "none");
    if (nodes.size() > 1) {
      std::string all;
      for (const std::string& found : nodes) all += (all.empty() ? "" : ", ") + found;
      throw Refused({{"--node", "one of " + all, "nothing"}});
    }
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

  /// They are numbered, so the bag shows whether it has them all.
  std::vector<CommandTaken> whatTheNodeTook() {
    std::vector<CommandTaken> commands;
    rosbag::View view(bag_, rosbag::TopicQuery(node_ + taken));
    for (const rosbag::MessageInstance& entry : view) commands.push_back(*messageOf<CommandTaken>(entry));
    std::sort(commands.begin(), commands.end(),
              [](const CommandTaken& a, const CommandTaken& b) { return a.number < b.number; });

    double before = 0;
    for (std::size_t i = 0; i < commands.size(); ++i) {
      const CommandTaken& command = commands[i];
      if (command.number != i + 1) {
        refuse(path_, "every command that the node took since its start",
               "number " + std::to_string(command.number) + " where " + std::to_string(i + 1) + " is due");
      }
      if (!(std::isfinite(command.sim_time) && command.sim_time >= before)) {
        refuse(path_, "sim times that do not go back", toText(command.sim_time));
      }
      before = command.sim_time;
    }
    return commands;
  }

  std::vector<CommandTaken> whatWasReceived() {
    const std::string states = ros::names::append(ros::names::parentNamespace(node_), "joint_states");
    const std::int64_t start = startOfSimTime();
    std::vector<std::string> topics = {states};
    for (const std::string& name : received) topics.push_back(node_ + name);

    std::vector<CommandTaken> commands;
    std::optional<double> now;
    std::size_t early = 0;  // commands before the first state
    rosbag::View view(bag_, rosbag::TopicQuery(topics));
    for (const rosbag::MessageInstance& entry : view) {
      if (entry.getTopic() == states) {
        now = simTimeOf(messageOf<sensor_msgs::JointState>(entry)->header.stamp, start);
        for (; early < commands.size(); ++early) commands[early].sim_time = *now;
        continue;
      }
      CommandTaken command = commandOf(entry);
      command.number = commands.size() + 1;
      if (now) command.sim_time = *now;
      commands.push_back(std::move(command));
      if (now) early = commands.size();
    }
    if (!now) refuse(path_, states + ", whose stamps tell when a command was taken", "none");
    return commands;
  }

  /// The stamp of sim time 0, ns.
  std::int64_t startOfSimTime() {
    const std::string topic = node_ + "/status";
    rosbag::View view(bag_, rosbag::TopicQuery(topic));
    if (view.size() == 0) refuse(path_, topic + ", which tells when sim time began", "none");
    const auto status = messageOf<SimStatus>(*view.begin());
    return static_cast<std::int64_t>(status->header.stamp.toNSec()) - std::llround(status->sim_time * 1e9L);
  }

  /// That of the tick with this stamp.
  double simTimeOf(ros::Time stamp, std::int64_t start) const {
    const std::int64_t elapsed = static_cast<std::int64_t>(stamp.toNSec()) - start;
    const long long tick = pace_.nearest(static_cast<double>(elapsed) * 1e-9);
    // Both stamps are rounded to ns.
    const bool isTick = std::abs(pace_.nanosecondsOf(tick) - elapsed) <= 1;
    const double time = isTick ? pace_.timeOf(tick) : static_cast<double>(elapsed) * 1e-9;
    if (time < 0) refuse(path_, "stamps of joint_states after the start of sim time", toText(time) + " s");
    return time;
  }

  CommandTaken commandOf(const rosbag::MessageInstance& entry) const {
    CommandTaken command;
    if (entry.getTopic() == node_ + received[0]) {
      command.joint_torques = messageOf<std_msgs::Float64MultiArray>(entry)->data;
    } else if (entry.getTopic() == node_ + received[1]) {
      command.joint_torque.push_back(*messageOf<JointTorque>(entry));
    } else {
      command.link_force.push_back(*messageOf<LinkForce>(entry));
    }
    return command;
  }

  const std::string& path_;
  Pace pace_;
  rosbag::Bag bag_;
  std::set<std::string> topics_;
  std::string node_;
};

}  // namespace

RecordedCommands readCommands(const std::string& path, const std::optional<std::string>& node, double rate) {
  try {
    return Reader(path, node, rate).read();
  } catch (const rosbag::BagException& problem) {
    refuse(path, "a bag that can be read", problem.what());
  }
}

}  // namespace planar_chain
