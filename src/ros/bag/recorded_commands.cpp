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
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "planar_chain/fault.h"
#include "planar_chain/value.h"
#include "reading/section.h"
#include "ros/bag/bags.h"
#include "ros/bag/child.h"
#include "ros/bag/reading.h"

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
  // rosbag keeps relative names.
  const auto found = std::find_if(nodes.begin(), nodes.end(), [&given](const std::string& node) {
    return !given || node == *given || "/" + node == *given;
  });
  if (found == nodes.end() || (!given && nodes.size() > 1)) {
    throw Refused({{"--node", "one of " + inCommas(nodes), given ? quoted(*given) : "nothing"}});
  }
  return *found;
}

template <class Message>
boost::shared_ptr<Message> messageOf(const rosbag::MessageInstance& entry, const std::string& path) {
  if (const auto message = entry.instantiate<Message>()) return message;
  const std::string type = ros::message_traits::datatype<Message>();
  refuse(path, entry.getTopic() + " of type " + type + " as this version defines it",
         entry.getDataType() == type ? "that of another version, which `rosbag fix` converts (msg/README.md)"
                                     : entry.getDataType());
}

/// Refuses what a node that was started again numbers anew, as fitting/bags.py does.
[[noreturn]] void refuseRestart(const std::string& path, const std::string& node, const std::string& numbered,
                                std::uint64_t tick, std::uint64_t other) {
  refuse(path, "one run of " + node,
         "a second one: " + numbered + " is of tick " + std::to_string(tick) + " and of tick " +
             std::to_string(other) + " (the node was started again; record each run in a bag of its own)");
}

/// @throws Refused if one of them is missing, is not what its kind needs, or does not fit the ticks
void check(const std::vector<CommandTaken>& commands, double rate, const std::string& node,
           const std::string& path) {
  std::uint64_t tickBefore = 0, number = 0;
  bool wasSet = false;
  for (const CommandTaken& command : commands) {
    if (number > 0 && command.number == number) {
      refuseRestart(path, node, "its command " + std::to_string(number), tickBefore, command.tick);
    }
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

/// A message of joint_states.
struct State {
  std::uint32_t number;
  ros::Time stamp;
  std::uint64_t digest;
};

/// The last of the ticks, or of the states, with one stamp. An external clock that goes back repeats stamps.
struct AtStamp {
  std::uint64_t last = 0;  ///< a tick, or an index
  bool isOnly = true;
};

/// The ticks that ~status has.
struct Statuses {
  std::map<ros::Time, AtStamp> ticks;
  std::uint64_t last = 0;
  std::string caller;  ///< the publisher
};

/// @throws Refused if the node was started again
Statuses readStatuses(const rosbag::Bag& bag, const std::string& node, const std::string& path,
                      bool isNeeded) {
  Statuses statuses;
  std::map<std::uint32_t, std::pair<std::uint64_t, ros::Time>> byNumber;  // each number is of one message
  for (const rosbag::MessageInstance& entry : rosbag::View(bag, rosbag::TopicQuery(node + "/status"))) {
    if (!isNeeded && !entry.isType<SimStatus>()) continue;
    const auto status = messageOf<SimStatus>(entry, path);
    if (isNeeded) requireTick(status->tick, path);
    const std::pair now(status->tick, status->header.stamp);
    const auto [before, isNew] = byNumber.emplace(status->header.seq, now);
    // Messages without numbers have the number 0.
    if (!isNew && status->header.seq > 0 && before->second != now) {
      refuseRestart(path, node, "its status " + std::to_string(status->header.seq), before->second.first,
                    status->tick);
    }
    AtStamp& at = statuses.ticks.emplace(status->tick_stamp, AtStamp{status->tick}).first->second;
    at.isOnly = at.isOnly && at.last == status->tick;
    at.last = std::max(at.last, status->tick);
    statuses.last = std::max(statuses.last, status->tick);
    statuses.caller = entry.getCallerId();
  }
  return statuses;
}

/// Finds the tick of each state, in whatever order the bag has them. A status gives a tick and its stamp, so
/// the number of the joint_states with this stamp. From one to the next, each state is one tick more, if both
/// agree on that. Stamps alone do not give the tick: they jump over pauses, and go back with an external
/// clock.
void readStates(const rosbag::Bag& bag, const std::string& path, bool isNeeded, RecordedCommands& recorded) {
  const Statuses statuses = readStatuses(bag, recorded.node, path, isNeeded);
  std::vector<State> states;
  const std::string topic = recorded.node.substr(0, recorded.node.rfind('/') + 1) + "joint_states";
  for (const rosbag::MessageInstance& entry : rosbag::View(bag, rosbag::TopicQuery(topic))) {
    const bool isOthers = !statuses.caller.empty() && entry.getCallerId() != statuses.caller;
    if (isOthers || !(isNeeded || entry.isType<sensor_msgs::JointState>())) continue;
    const auto state = messageOf<sensor_msgs::JointState>(entry, path);
    if (state->header.stamp.isZero()) continue;
    states.push_back({state->header.seq, state->header.stamp, digestOf(state->position, state->velocity)});
  }
  std::stable_sort(states.begin(), states.end(),
                   [](const State& a, const State& b) { return a.number < b.number; });

  std::map<ros::Time, AtStamp> at;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const auto [entry, isNew] = at.emplace(states[i].stamp, AtStamp());
    entry->second = {i, isNew};
  }

  // Find the states that a status names, by how far ticks are ahead of numbers, and the last one.
  std::vector<std::pair<std::size_t, std::uint64_t>> known;
  std::uint64_t lastKnown = 0, later = at.size();
  for (const auto& [stamp, tick] : statuses.ticks) {
    const auto state = at.find(stamp);
    if (state == at.end()) continue;
    const std::uint32_t number = states[state->second.last].number;
    if (tick.isOnly && state->second.isOnly) known.emplace_back(state->second.last, tick.last - number);
    if (tick.last >= lastKnown) {
      lastKnown = tick.last;
      later = states.back().number - number;
    }
  }
  std::sort(known.begin(), known.end());
  std::map<std::uint64_t, std::uint64_t> digests;  // by tick
  for (std::size_t k = 0; k < known.size(); ++k) {
    const auto [first, ahead] = known[k];
    const bool isLast = k + 1 == known.size();
    if (isLast ? k > 0 && known[k - 1].second != ahead : known[k + 1].second != ahead) continue;
    for (std::size_t i = first; i < (isLast ? states.size() : known[k + 1].first); ++i) {
      digests.emplace(states[i].number + ahead, states[i].digest);
    }
  }
  for (const auto& [tick, digest] : digests) {
    recorded.ticks.push_back(tick);
    recorded.digests.push_back(digest);
  }
  const std::uint64_t last = std::max(statuses.last, lastKnown + later);
  if (!isNeeded || last == 0) return;
  requireTick(recorded.commands.back().tick, path);
  recorded.lastTick = std::max(last, recorded.commands.back().tick);
}

}  // namespace

std::uint64_t digestOf(const std::vector<double>& q, const std::vector<double>& qd) {
  const auto of = [](const std::vector<double>& values) {
    const std::string_view bytes(reinterpret_cast<const char*>(values.data()),
                                 values.size() * sizeof(double));
    return std::hash<std::string_view>()(bytes);
  };
  return 31 * of(q) + of(qd);
}

namespace {

/// @throws Refused
RecordedCommands readHere(const std::string& path, const std::optional<std::string>& node, double rate,
                          bool needsEnd) {
  try {
    const rosbag::Bag bag(path);
    RecordedCommands recorded{nodeOf(bag, node, path), {}, 0, {}, {}, {}};

    const std::string topic = recorded.node + commandsTaken;
    std::vector<CommandTaken>& commands = recorded.commands;
    for (const rosbag::MessageInstance& entry : rosbag::View(bag, rosbag::TopicQuery(topic))) {
      commands.push_back(*messageOf<CommandTaken>(entry, path));
    }
    if (commands.empty()) refuse(path, "a bag with commands on " + topic, "none");
    std::stable_sort(commands.begin(), commands.end(),
                     [](const CommandTaken& a, const CommandTaken& b) { return a.number < b.number; });
    check(commands, rate, recorded.node, path);
    for (const rosbag::MessageInstance& entry :
         rosbag::View(bag, rosbag::TopicQuery(recorded.node + "/scene"))) {
      recorded.scene = messageOf<std_msgs::String>(entry, path)->data;
    }
    try {
      parseYaml(recorded.scene);
    } catch (const Refused& problem) {
      refuse(path, recorded.node + "/scene in YAML", problem.what());
    }
    readStates(bag, path, needsEnd, recorded);
    return recorded;
  } catch (const Refused&) {
    throw;
  } catch (const std::exception& problem) {  // of rosbag; of ros::serialization, if a message is damaged
    refuse(path, "a bag that can be read", whyUnread(path, problem));
  }
}

}  // namespace

RecordedCommands readCommands(const std::string& path, const std::optional<std::string>& node, double rate,
                              bool needsEnd) {
  // A damaged length may ask for any memory. A bag of commands takes a few times its size.
  constexpr std::uintmax_t least = std::uintmax_t{256} << 20, times = 64;
  std::error_code none;
  const std::uintmax_t size = std::filesystem::file_size(path, none);
  std::string bytes;
  try {
    const auto read = [&] {
      Reading reading;
      try {
        reading.recorded = readHere(path, node, rate, needsEnd);
      } catch (const Refused& refused) {
        reading.faults = refused.faults();
      }
      return inBytes(reading);
    };
    bytes = madeByChild(read, least + (none ? 0 : times * size));
  } catch (const Crash& crash) {
    refuse(path, "a bag that can be read", whyUnread(path, crash));
  }
  Reading reading = ofBytes(bytes);
  if (!reading.faults.empty()) throw Refused(std::move(reading.faults));
  return std::move(reading.recorded);
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
  for (const char* key : {"publish", "real_time_factor", "seed", "sensors"}) {
    if (before.map()) before.map()->erase(key);
    if (now.map()) now.map()->erase(key);
  }
  return difference(&before, &now, "");
}

}  // namespace planar_chain
