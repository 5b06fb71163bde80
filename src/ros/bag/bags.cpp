#include "ros/bag/bags.h"

#include <ros/names.h>
#include <ros/time.h>

#include <cstdint>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/value.h"
#include "ros/bag/bag_reader.h"
#include "ros/bag/bag_writer.h"
#include "ros/messages/pace.h"
#include "ros/node/commands.h"
#include "ros/view/urdf.h"

namespace planar_chain {

namespace {

constexpr const char* usualNode = "/planar_chain";

/// Returns the name with a leading slash, as rosnode lists it.
std::optional<std::string> fullName(const std::optional<std::string>& node) {
  if (!node) return std::nullopt;
  std::string problem;
  const std::string name = ros::names::clean("/" + *node);
  if (name.size() < 2 || !ros::names::validate(name, problem)) {
    throw Refused({{"--node", "the name of a node, such as /left/planar_chain", describe(Value(*node))}});
  }
  return name;
}

void writeUrdf(const std::string& path, const Scene& scene, const std::string& node) {
  std::ofstream file(path);
  file << urdfOf(scene, framesOf(scene, ros::names::parentNamespace(node)));
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

/// Does what the node does, tick by tick, without a master: src/ros/node/node.cpp has the same ticks.
class OfflineNode : public Bags {
 public:
  OfflineNode(const Scene& scene, const BagArguments& given)
      : pace_(scene.publish.rate),
        simulation_(scene, CommandTopics::capacity),
        commands_(simulation_, [this](ros::Time) { return recorded_.commands[next_].start; }) {
    const std::optional<std::string> node = fullName(given.node);
    if (given.commands) {
      recorded_ = readCommands(*given.commands, node, scene.publish.rate, given.endsAsRecorded);
    }
    if (given.endsAsRecorded && recorded_.lastTick == 0) {
      throw Refused({{"--duration", "a time, for the bag has no states of " + recorded_.node, "nothing"}});
    }
    const std::string publisher = node ? *node : given.commands ? recorded_.node : usualNode;
    if (given.out) writer_.emplace(*given.out, scene, publisher);
    if (given.urdf) writeUrdf(*given.urdf, scene, publisher);
  }

  Simulation& simulation() override { return simulation_; }

  double recordedEnd() const override { return pace_.timeOf(recorded_.lastTick); }

  bool advanceTo(long long k, double t) override {
    const std::vector<CommandTaken>& commands = recorded_.commands;
    for (; next_ < commands.size() && commands[next_].tick <= static_cast<std::uint64_t>(k); ++next_) {
      if (!take(commands[next_])) {
        ++refused_;
      } else if (writer_) {
        writer_->command(commands[next_]);
      }
    }
    const bool isTick = t == pace_.timeOf(k);
    return simulation_.advanceTo(isTick ? pace_.timeOf(k - origin_) : t - pace_.timeOf(origin_));
  }

  void tick(long long k) override {
    if (!writer_ || k == 0) return;
    writer_->tick(k, pace_.timeOf(origin_) + simulation_.time(), simulation_, commands_);
  }

  void close() override {
    if (writer_) writer_->close();
  }

  std::string summary() const override {
    if (recorded_.node.empty()) return "";
    std::ostringstream text;
    text << "  commands of " << recorded_.node << ": " << next_ - refused_ << " taken";
    if (refused_ > 0) text << ", " << refused_ << " refused";
    const std::size_t late = recorded_.commands.size() - next_;
    if (late > 0) text << ", " << late << " after the end";
    if (!recorded_.isExact) {
      text
          << "\n  the bag has no " << recorded_.node
          << "/commands_taken: each command acts from the tick at which rosbag received it, which may not be "
             "the node's tick";
    }
    text << '\n';
    return text.str();
  }

 private:
  /// Returns false if the command is refused.
  bool take(const CommandTaken& command) {
    const auto tick = static_cast<long long>(command.tick);
    switch (command.kind) {
      case CommandTaken::CLEAR_COMMANDS:
        simulation_.clearCommands();
        return true;
      case CommandTaken::SET_STATE:
        return setState(command);
      case CommandTaken::STEP:
        if (tick == origin_) --origin_;  // as Node::step does
        return command.joint_torques.empty() || hold(command.joint_torques);
      case CommandTaken::RESET:
        simulation_.reset();
        commands_.forget();
        origin_ = tick;
        return true;
      default:
        return commands_.take(command);
    }
  }

  bool hold(const std::vector<double>& torques) {
    if (!commands_.faultsOf(torques, "torques").empty()) return false;
    commands_.hold(torques);
    return true;
  }

  bool setState(const CommandTaken& command) {
    // A fault stops the node between two ticks.
    if (command.scene_time > simulation_.time()) simulation_.advanceTo(command.scene_time);
    try {
      simulation_.setState(command.q, command.qd);
    } catch (const std::invalid_argument&) {
      return false;
    }
    return true;
  }

  Pace pace_;
  long long origin_ = 0;  ///< the tick of scene time 0
  Simulation simulation_;
  CommandTopics commands_;
  RecordedCommands recorded_;
  std::size_t next_ = 0;  ///< index of the next command to take
  std::size_t refused_ = 0;
  std::optional<BagWriter> writer_;
};

}  // namespace

extern "C" Bags* openBags(const Scene& scene, const BagArguments& given) {
  ros::Time::init();  // for the stamps of ROS's log
  return new OfflineNode(scene, given);
}

}  // namespace planar_chain
