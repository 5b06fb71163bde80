#include "ros/bag/bag_reader.h"

#include <planar_chain/SimStatus.h>
#include <ros/names.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Float64MultiArray.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

#include "planar_chain/fault.h"
#include "planar_chain/value.h"
#include "ros/bag/bags.h"
#include "ros/messages/pace.h"

namespace planar_chain {

namespace {

constexpr const char* option = "--commands";
const std::string taken = "/commands_taken", status = "/status";
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

bool isWhole(const CommandTaken& command) {
  return command.kind <= CommandTaken::RESET && std::isfinite(command.scene_time) &&
         command.joint_torque.size() == (command.kind == CommandTaken::JOINT_TORQUE ? 1 : 0) &&
         command.link_force.size() == (command.kind == CommandTaken::LINK_FORCE ? 1 : 0);
}

class Reader {
 public:
  Reader(const std::string& path, const std::optional<std::string>& node, double rate)
      : path_(path), rate_(rate), bag_(path, rosbag::bagmode::Read) {
    for (const rosbag::ConnectionInfo* connection : rosbag::View(bag_).getConnections()) {
      topics_.insert(connection->topic);
    }
    node_ = node ? *node : onlyNode();
  }

  RecordedCommands read(bool alsoEnd) {
    const bool isExact = topics_.count(node_ + taken) > 0;
    return {node_, isExact ? whatTheNodeTook() : whatWasReceived(), isExact, alsoEnd ? lastTick() : 0};
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

    std::uint64_t before = 0;
    bool isFirstScene = true;  // before any reset
    for (std::size_t i = 0; i < commands.size(); ++i) {
      const CommandTaken& command = commands[i];
      if (command.number != i + 1) {
        refuse(path_, "every command that the node took since its start",
               "number " + std::to_string(command.number) + " where " + std::to_string(i + 1) + " is due");
      }
      if (!isWhole(command)) {
        refuse(path_, "commands with what their kind needs",
               "number " + std::to_string(i + 1) + " of kind " + std::to_string(command.kind));
      }
      if (command.tick < before) refuse(path_, "ticks that do not go back", std::to_string(command.tick));
      before = command.tick;
      isFirstScene = isFirstScene && command.kind != CommandTaken::RESET;
      // Taken before its tick, after the one before that.
      const double ticks = isFirstScene ? command.scene_time * rate_ : static_cast<double>(command.tick);
      if (!(std::abs(ticks - static_cast<double>(command.tick)) <= 1.01)) {
        refuse(path_, "commands of a node with ticks of " + toText(rate_) + " Hz (publish/rate, or --rate)",
               "tick " + std::to_string(command.tick) + " after " + toText(command.scene_time) + " s");
      }
    }
    return commands;
  }

  std::vector<CommandTaken> whatWasReceived() {
    const std::string states = jointStates();
    const std::int64_t start = startOfSimTime();
    std::vector<std::string> topics = {states};
    for (const std::string& name : received) topics.push_back(node_ + name);

    std::vector<CommandTaken> commands;
    std::optional<std::uint64_t> last;  // tick
    rosbag::View view(bag_, rosbag::TopicQuery(topics));
    for (const rosbag::MessageInstance& entry : view) {
      if (entry.getTopic() == states) {
        const std::uint64_t tick = tickOf(messageOf<sensor_msgs::JointState>(entry)->header.stamp, start);
        if (!last) setTicks(commands.begin(), commands.end(), tick);
        last = tick;
      } else {
        commands.push_back(commandOf(entry, start));
        commands.back().number = commands.size();
        if (last) setTicks(commands.end() - 1, commands.end(), *last + 1);
      }
    }
    if (!last) refuse(path_, states + ", whose stamps tell when a command was taken", "none");
    return commands;
  }

  /// A status tells a tick and its stamp, and each of the joint_states stamped after it is a tick more:
  /// stamps alone cannot tell, as they jump over every standstill.
  long long lastTick() {
    std::uint64_t tick = 0;
    ros::Time stamp;
    std::vector<ros::Time> later;
    rosbag::View view(bag_, rosbag::TopicQuery(std::vector{jointStates(), node_ + status}));
    for (const rosbag::MessageInstance& entry : view) {
      if (entry.getTopic() == jointStates()) {
        const ros::Time its = messageOf<sensor_msgs::JointState>(entry)->header.stamp;
        if (its > stamp) later.push_back(its);  // else it was told before the status, and came after it
        continue;
      }
      const auto said = messageOf<SimStatus>(entry);
      if (said->tick > static_cast<std::uint64_t>(mostRows)) {
        refuse(path_, "ticks up to number 100000000", std::to_string(said->tick));
      }
      tick = said->tick;
      stamp = said->tick_stamp;
      const auto isNotLater = [&](ros::Time its) { return its <= stamp; };
      later.erase(std::remove_if(later.begin(), later.end(), isNotLater), later.end());
    }
    return static_cast<long long>(tick + later.size());
  }

  std::string jointStates() const {
    return ros::names::append(ros::names::parentNamespace(node_), "joint_states");
  }

  using Iterator = std::vector<CommandTaken>::iterator;
  void setTicks(Iterator command, Iterator end, std::uint64_t tick) const {
    for (; command != end; ++command) {
      command->tick = tick;
      command->scene_time = static_cast<double>(tick > 0 ? tick - 1 : 0) / rate_;
    }
  }

  /// The stamp of sim time 0, ns: by what a status tells of its tick, or somewhat later after a standstill.
  std::int64_t startOfSimTime() {
    const std::string topic = node_ + status;
    std::optional<std::int64_t> start;
    rosbag::View view(bag_, rosbag::TopicQuery(topic));
    for (const rosbag::MessageInstance& entry : view) {
      const auto said = messageOf<SimStatus>(entry);
      if (said->tick_stamp.isZero()) continue;
      const std::int64_t its = static_cast<std::int64_t>(said->tick_stamp.toNSec()) -
                               Pace(rate_).nanosecondsOf(static_cast<long long>(said->tick));
      start = start ? std::min(*start, its) : its;
    }
    if (!start) refuse(path_, topic + ", which tells when sim time began", "none");
    return *start;
  }

  std::uint64_t tickOf(ros::Time stamp, std::int64_t start) const {
    const std::int64_t elapsed = static_cast<std::int64_t>(stamp.toNSec()) - start;
    const long long tick = std::llround(static_cast<double>(elapsed) * 1e-9 * rate_);
    if (tick < 0) {
      refuse(path_, "joint_states after the start of sim time",
             toText(static_cast<double>(elapsed) * 1e-9) + " s");
    }
    return static_cast<std::uint64_t>(tick);
  }

  CommandTaken commandOf(const rosbag::MessageInstance& entry, std::int64_t simStart) const {
    CommandTaken command;
    ros::Time start;
    if (entry.getTopic() == node_ + received[0]) {
      command.kind = CommandTaken::JOINT_TORQUES;
      command.joint_torques = messageOf<std_msgs::Float64MultiArray>(entry)->data;
    } else if (entry.getTopic() == node_ + received[1]) {
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

  const std::string& path_;
  double rate_;  ///< of ticks, Hz
  rosbag::Bag bag_;
  std::set<std::string> topics_;
  std::string node_;
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
