#include "ros/bag/bags.h"

#include <planar_chain/CommandTaken.h>
#include <planar_chain/SimStatus.h>
#include <ros/names.h>
#include <ros/time.h>
#include <rosbag/bag.h>
#include <rosgraph_msgs/Clock.h>

#include <boost/make_shared.hpp>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/value.h"
#include "ros/bag/bag_reader.h"
#include "ros/messages/frames.h"
#include "ros/messages/messages.h"
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

// ---- The bag to write ----------------------------------------------------------------------------

/// Writes what a node publishes to a bag: the same topics, types and messages, made by the same functions.
///
/// rosbag::Bag writes the file. It seeks to the end of the file twice per message, but is fast enough: a
/// minute of config/scenes/double_pendulum.yaml at 200 Hz takes 0.34 s of processor time, 175 times less than
/// real time (test/README.md, Long checks). A writer of our own took 0.04 s, and 285 lines.
///
/// Tick k is stamped k/rate, rounded to ns, and is received at that time. /clock comes first. The status
/// fields of wall time (real_time_factor, overruns, lag) are 0. So two runs of a scene with the same commands
/// give the same bytes.
class BagWriter {
 public:
  /// node: the full name of the publishing node, such as /left/planar_chain.
  /// @throws Refused when the scene's frames have faults
  /// @throws std::runtime_error when the file cannot be opened
  BagWriter(const std::string& path, const Scene& scene, const std::string& node)
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

  /// Adds a command that was taken since the last tick.
  void command(const CommandTaken& taken) { taken_.push_back(taken); }

  /// Writes every message of tick k ≥ 1; after a fault only the status. simTime: simulated seconds since the
  /// start, resets included.
  /// @throws std::runtime_error when the disk is full, for example
  void tick(long long k, double simTime, Simulation& simulation, const CommandTopics& commands) {
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

  /// Writes the index. Without it rosbag refuses the file, and `rosbag reindex` repairs it.
  /// @throws std::runtime_error as tick()
  void close() {
    attempt([&] { bag_->close(); });
  }

 private:
  struct Topic {
    std::string name;
    bool isLatched = false;
    boost::shared_ptr<ros::M_string> connection = nullptr;  ///< the header that the publisher would send
    std::uint32_t messages = 0;                             ///< number written
  };
  /// rosbag::Bag's destructor closes it. After a fault that would index a bag with a gap, or throw again.
  struct DeleteIfClosed {
    void operator()(rosbag::Bag* bag) const {
      if (!bag->isOpen()) delete bag;
    }
  };

  void writeState(long long k, ros::Time stamp, Simulation& simulation) {
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

  void writeStatus(ros::Time stamp, double simTime, const Simulation& simulation,
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
  void write(Topic& topic, ros::Time stamp, Message& message) {
    namespace traits = ros::message_traits;
    if (!topic.connection) {
      topic.connection = boost::make_shared<ros::M_string>(
          ros::M_string{{"callerid", node_},
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
  void attempt(Operation operation) const {
    try {
      operation();
    } catch (const rosbag::BagException&) {
      throw std::runtime_error("cannot write " + path_ + ": " + std::strerror(errno));
    }
  }

  PublishSettings settings_;
  Frames frames_;
  Messages messages_;
  Pace pace_;
  std::string path_, node_;
  std::unique_ptr<rosbag::Bag, DeleteIfClosed> bag_;
  Topic clockOut_{"/clock"}, tfOut_{"/tf"}, staticTfOut_{"/tf_static", true};
  Topic jointStatesOut_, linkStatesOut_, statusOut_, commandsOut_;
  rosgraph_msgs::Clock clock_;
  SimStatus status_;
  std::vector<CommandTaken> taken_;
};

// ---- The run -------------------------------------------------------------------------------------

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
