#include "ros/bag/recorded_commands.h"

#include <planar_chain/SimStatus.h>
#include <ros/names.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <boost/algorithm/string/predicate.hpp>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <string_view>

#include "planar_chain/fault.h"
#include "planar_chain/value.h"
#include "reading/section.h"
#include "ros/bag/bags.h"

namespace planar_chain {

namespace {

const std::string commandsTaken = "/commands_taken";  // below a node's name

[[noreturn]] void refuse(const std::string& path, const std::string& expected, const std::string& found) {
  throw Refused({{"--commands " + path, expected, found}});
}

/// Returns why a file cannot be read as a bag, and the remedy, in the words of fitting/unread.py.
std::string whyUnread(const std::string& path, const std::exception& problem) {
  constexpr std::string_view beginning = "#ROSBAG";
  std::ifstream file(path);
  if (!file) return std::string("nothing: ") + std::strerror(errno);
  std::string begins(beginning.size(), ' ');
  file.read(begins.data(), static_cast<std::streamsize>(begins.size()));
  if (file.bad()) return std::string("nothing: ") + std::strerror(errno);
  if (file.gcount() == 0) return "an empty file";
  if (begins != beginning) return "a file that is no bag";
  // A bag that was cut off has no index where its header says.
  if (dynamic_cast<const rosbag::BagUnindexedException*>(&problem) ||
      dynamic_cast<const rosbag::BagIOException*>(&problem)) {
    return "one without an index; its recorder still runs or was killed (to mend it: rosbag reindex " + path +
           ")";
  }
  return std::string("a damaged one (") + problem.what() + ")";
}

/// Returns the node with ~commands_taken that is given, or the only one.
std::string nodeOf(const rosbag::Bag& bag, const std::optional<std::string>& given, const std::string& path) {
  std::set<std::string> nodes;
  for (const rosbag::ConnectionInfo* connection : rosbag::View(bag).getConnections()) {
    const std::string& topic = connection->topic;
    if (boost::ends_with(topic, commandsTaken)) {
      nodes.insert(topic.substr(0, topic.size() - commandsTaken.size()));
    }
  }
  if (nodes.empty()) {
    refuse(path, "a bag with commands on " + given.value_or("a topic such as …") + commandsTaken, "none");
  }
  if (given ? nodes.count(*given) == 0 : nodes.size() > 1) {
    throw Refused({{"--node", "one of " + inCommas(nodes), given ? quoted(*given) : "nothing"}});
  }
  return given ? *given : *nodes.begin();
}

template <class Message>
boost::shared_ptr<Message> messageOf(const rosbag::MessageInstance& entry, const std::string& path) {
  if (const auto message = entry.instantiate<Message>()) return message;
  const std::string type = ros::message_traits::datatype<Message>();
  refuse(path, entry.getTopic() + " of type " + type + " as this version defines it",
         entry.getDataType() == type ? "that of another version, which `rosbag fix` converts (msg/README.md)"
                                     : entry.getDataType());
}

/// @throws Refused if one of them is missing, is not what its kind needs, or does not fit the ticks
void check(const std::vector<CommandTaken>& commands, double rate, const std::string& path) {
  std::uint64_t tickBefore = 0, number = 0;
  bool wasSet = false;
  for (const CommandTaken& command : commands) {
    if (command.number != ++number) {
      const bool isReset = command.kind == CommandTaken::RESET && command.number == number + 1;
      refuse(
          path, "every command that the node took since its start",
          "number " + std::to_string(command.number) + " where " + std::to_string(number) + " is due" +
              (isReset
                   ? " (a reset that changes the scene skips a number: what follows belongs to another scene)"
                   : ""));
    }
    const bool hasItsFields =
        command.kind <= CommandTaken::TOLERANCE && std::isfinite(command.scene_time) &&
        command.joint_torque.size() == (command.kind == CommandTaken::JOINT_TORQUE ? 1 : 0) &&
        command.link_force.size() == (command.kind == CommandTaken::LINK_FORCE ? 1 : 0) &&
        command.joint_trajectory.size() == (command.kind == CommandTaken::JOINT_TRAJECTORY ? 1 : 0) &&
        command.base_trajectory.size() == (command.kind == CommandTaken::BASE_TRAJECTORY ? 1 : 0);
    if (!hasItsFields) {
      refuse(path, "commands with what their kind needs",
             "number " + std::to_string(number) + " of kind " + std::to_string(command.kind));
    }
    if (command.tick < tickBefore) refuse(path, "ticks that do not go back", std::to_string(command.tick));
    tickBefore = command.tick;
    wasSet = wasSet || command.kind == CommandTaken::RESET || command.kind == CommandTaken::SETTLE;
    // Until the first tick that shows a state of ~reset or ~settle, scene time lies between the tick before
    // and this one.
    const auto tick = static_cast<double>(command.tick);
    if (!wasSet && !(std::abs(command.scene_time * rate - tick) <= 1.01)) {
      refuse(path, "commands of a node with ticks of " + toText(rate) + " Hz (publish/rate, or --rate)",
             "tick " + std::to_string(command.tick) + " after " + toText(command.scene_time) + " s");
    }
  }
}

void requireTick(std::uint64_t tick, const std::string& path) {
  if (tick <= static_cast<std::uint64_t>(mostRows)) return;
  refuse(path, "ticks up to number 100000000", std::to_string(tick));
}

/// Returns the last tick of the states in the bag, in whatever order it has them. A status gives a tick and
/// its stamp, so the number of the joint_states with this stamp. Each joint_states with a higher number is
/// one tick more. Stamps alone do not give the tick: they jump over pauses, and go back with an external
/// clock.
std::uint64_t lastTick(const rosbag::Bag& bag, const std::string& node, const std::string& path) {
  std::map<ros::Time, std::uint32_t> numbers;  // of the last one with each stamp
  std::uint32_t newest = 0;
  const std::string states = ros::names::append(ros::names::parentNamespace(node), "joint_states");
  for (const rosbag::MessageInstance& entry : rosbag::View(bag, rosbag::TopicQuery(states))) {
    const std_msgs::Header header = messageOf<sensor_msgs::JointState>(entry, path)->header;
    std::uint32_t& number = numbers[header.stamp];
    number = std::max(number, header.seq);
    newest = std::max(newest, header.seq);
  }
  std::uint64_t last = 0, known = 0, later = numbers.size() - numbers.count(ros::Time());
  for (const rosbag::MessageInstance& entry : rosbag::View(bag, rosbag::TopicQuery(node + "/status"))) {
    const auto status = messageOf<SimStatus>(entry, path);
    requireTick(status->tick, path);
    last = std::max(last, status->tick);
    const auto found = numbers.find(status->tick_stamp);
    if (found == numbers.end() || status->tick < known) continue;
    known = status->tick;
    later = newest - found->second;
  }
  return std::max(last, known + later);
}

}  // namespace

RecordedCommands readCommands(const std::string& path, const std::optional<std::string>& node, double rate,
                              bool alsoEnd) {
  try {
    const rosbag::Bag bag(path);
    RecordedCommands recorded{nodeOf(bag, node, path), {}, 0, {}};

    const std::string topic = recorded.node + commandsTaken;
    std::vector<CommandTaken>& commands = recorded.commands;
    for (const rosbag::MessageInstance& entry : rosbag::View(bag, rosbag::TopicQuery(topic))) {
      commands.push_back(*messageOf<CommandTaken>(entry, path));
    }
    if (commands.empty()) refuse(path, "a bag with commands on " + topic, "none");
    std::sort(commands.begin(), commands.end(),
              [](const CommandTaken& a, const CommandTaken& b) { return a.number < b.number; });
    check(commands, rate, path);
    for (const rosbag::MessageInstance& entry :
         rosbag::View(bag, rosbag::TopicQuery(recorded.node + "/scene"))) {
      recorded.scene = messageOf<std_msgs::String>(entry, path)->data;
    }
    try {
      parseYaml(recorded.scene);
    } catch (const Refused& problem) {
      refuse(path, recorded.node + "/scene in YAML", problem.what());
    }
    if (const std::uint64_t last = alsoEnd ? lastTick(bag, recorded.node, path) : 0; last > 0) {
      requireTick(commands.back().tick, path);
      recorded.lastTick = static_cast<long long>(std::max(last, commands.back().tick));
    }
    return recorded;
  } catch (const Refused&) {
    throw;
  } catch (const std::exception& problem) {  // of rosbag; of ros::serialization, if a message is damaged
    refuse(path, "a bag that can be read", whyUnread(path, problem));
  }
}

namespace {

std::string difference(const Value* a, const Value* b, const std::string& path) {
  const auto below = [&](const std::string& key, const Value* one, const Value* other) {
    return difference(one, other, path.empty() ? key : path + "/" + key);
  };
  std::string found;
  if (a && b && a->map() && b->map()) {
    const auto at = [](const Value& of, const std::string& key) {
      const auto entry = of.map()->find(key);
      return entry == of.map()->end() ? nullptr : &entry->second;
    };
    for (auto entry = a->map()->begin(); found.empty() && entry != a->map()->end(); ++entry) {
      found = below(entry->first, &entry->second, at(*b, entry->first));
    }
    for (auto entry = b->map()->begin(); found.empty() && entry != b->map()->end(); ++entry) {
      if (!at(*a, entry->first)) found = below(entry->first, nullptr, &entry->second);
    }
    return found;
  }
  if (a && b && a->list() && b->list() && a->list()->size() == b->list()->size()) {
    for (std::size_t i = 0; found.empty() && i < a->list()->size(); ++i) {
      found = below(std::to_string(i), &(*a->list())[i], &(*b->list())[i]);
    }
    return found;
  }
  if (a && b) {
    const std::optional<double> number = numberIn(*a);
    if (number ? number == numberIn(*b) : toYaml(*a) == toYaml(*b)) return "";
  }
  return path + " was " + describe(a) + ", here it is " + describe(b);
}

}  // namespace

std::string differenceOfScenes(const std::string& recorded, const std::string& present) {
  if (recorded.empty()) return "";
  Value before = parseYaml(recorded), now = parseYaml(present);
  for (const char* key : {"publish", "real_time_factor"}) {
    if (before.map()) before.map()->erase(key);
    if (now.map()) now.map()->erase(key);
  }
  return difference(&before, &now, "");
}

}  // namespace planar_chain
