#include "ros/bag/bags.h"

#include <planar_chain/SimStatus.h>
#include <ros/names.h>
#include <ros/time.h>
#include <rosbag/bag.h>
#include <rosgraph_msgs/Clock.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/value.h"
#include "reading/section.h"
#include "ros/bag/recorded_commands.h"
#include "ros/messages/frames.h"
#include "ros/messages/ticks.h"
#include "ros/node/commands.h"
#include "ros/view/drawing.h"
#include "ros/view/messages.h"

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
  file << urdfOf(scene, framesOf(scene, node));
  if (!file.flush()) throw std::runtime_error("cannot write " + path + ": " + std::strerror(errno));
  const std::vector<std::string> others = notInUrdf(scene);
  if (others.empty()) return;
  std::fprintf(stderr, "simulate: %s is without what URDF does not have: %s\n", path.c_str(),
               inCommas(others).c_str());
}

// ---- The bag to write ----------------------------------------------------------------------------

/// Writes the messages of a node to a bag: the same topics, types and messages, made by the same functions.
///
/// rosbag::Bag writes the file. It seeks to the end of the file twice per message, but is fast enough: a
/// minute of config/scenes/double_pendulum.yaml at 200 Hz takes 0.34 s of processor time, 175 times less than
/// real time (test/README.md, By hand). A writer of our own took 0.04 s, and 285 lines.
///
/// Tick k is stamped k/rate, rounded to ns, and is received at that time. /clock comes first. The scene is in
/// tick 1. The status
/// fields of wall time (real_time_factor, overruns, lag) are 0. So two runs of a scene with the same commands
/// give the same bytes.
class BagWriter {
 public:
  /// node: the full name of the publishing node, such as /left/planar_chain. The others must outlive this.
  /// @throws Refused when the scene's frames have faults
  /// @throws std::runtime_error when the file cannot be opened
  BagWriter(const std::string& path, bool hasViews, const std::string& node, Simulation& simulation,
            const Commands& commands, const Ticks& ticks)
      : simulation_(simulation),
        commands_(commands),
        ticks_(ticks),
        messages_(simulation, node, hasViews),
        path_(path),
        node_(node),
        bag_(new rosbag::Bag) {
    status_.header.frame_id = messages_.frames().base;
    attempt([&] { bag_->open(path_, rosbag::bagmode::Write); });
  }

  /// Adds a command that was taken since the last tick.
  void command(const CommandTaken& taken) { taken_.push_back(taken); }

  /// Writes every message of tick k ≥ 1; after a fault only the status.
  /// @throws std::runtime_error when the disk is full, for example
  void tick(long long k) {
    const ros::Time stamp = timeOf(ticks_.nanosecondsOf(k));
    rosgraph_msgs::Clock clock;
    clock.clock = stamp;
    write("/clock", stamp, clock);
    for (CommandTaken& taken : taken_) write(node_ + "/commands_taken", stamp, taken);
    taken_.clear();

    if (k == 1) {
      std_msgs::String scene;
      scene.data = simulation_.scene().text;
      write(node_ + "/scene", stamp, scene, true);
    }
    const bool isGood = simulation_.fault().empty();
    if (isGood) {
      messages_.forEach([&](const Topic& topic, auto make) {
        if (topic.isDue(ticks_, k)) write(topic.name, stamp, *make(stamp), topic.isLatched);
      });
      messages_.measurements().forEach(
          ticks_, k, stamp, [&](const std::string& topic, auto& message) { write(topic, stamp, message); });
      status_.tick = static_cast<std::uint64_t>(k);
      status_.tick_stamp = stamp;
    }
    if (isGood && !Ticks{ticks_.rate}.isDue(k, simulation_.scene().publish.statusRate)) return;
    status_.header.stamp = stamp;
    describe(simulation_, status_);
    status_.sim_time = ticks_.simTime(simulation_.time());
    if (!isGood) status_.standstill = standstillByFault;
    commands_.describe(status_);
    write(node_ + "/status", stamp, status_);
  }

  /// Writes the index. Without it rosbag refuses the file, and `rosbag reindex` repairs it.
  /// @throws std::runtime_error as tick()
  void close() {
    attempt([&] { bag_->close(); });
  }

 private:
  struct Connection {
    boost::shared_ptr<ros::M_string> header;  ///< which the publisher would send
    std::uint32_t messages = 0;               ///< number written
  };
  /// rosbag::Bag's destructor closes it. After a fault that would index a bag with a gap, or throw again.
  struct DeleteIfClosed {
    void operator()(rosbag::Bag* bag) const {
      if (!bag->isOpen()) delete bag;
    }
  };

  /// As ros::Publisher does, sets header.seq to the number of messages before, if the message has a header.
  template <class Message>
  void write(const std::string& topic, ros::Time stamp, Message& message, bool isLatched = false) {
    namespace traits = ros::message_traits;
    Connection& connection = connections_[topic];
    if (!connection.header) {
      connection.header = boost::make_shared<ros::M_string>(
          ros::M_string{{"callerid", node_},
                        {"latching", isLatched ? "1" : "0"},
                        {"md5sum", traits::md5sum<Message>()},
                        {"message_definition", traits::definition<Message>()},
                        {"topic", topic},
                        {"type", traits::datatype<Message>()}});
    }
    if (auto* const header = traits::header(message)) header->seq = connection.messages++;
    attempt([&] { bag_->write(topic, stamp, message, connection.header); });
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

  Simulation& simulation_;
  const Commands& commands_;
  const Ticks& ticks_;
  Messages messages_;
  std::string path_, node_;
  std::unique_ptr<rosbag::Bag, DeleteIfClosed> bag_;
  std::map<std::string, Connection> connections_;  ///< by topic
  SimStatus status_;
  std::vector<CommandTaken> taken_;
};

// ---- The run -------------------------------------------------------------------------------------

/// Makes the ticks of the node (src/ros/node/node.cpp) without a master.
class OfflineNode : public Bags {
 public:
  OfflineNode(const Scene& scene, const BagArguments& given)
      : ticks_{scene.publish.rate, 1}, simulation_(scene, Commands::capacity, true), commands_(ticks_, {}) {
    commands_.moveTo(simulation_);
    const std::optional<std::string> node = fullName(given.node);
    if (given.commands) {
      recorded_ = readCommands(*given.commands, node, scene.publish.rate, given.endsAsRecorded);
      const std::string other = differenceOfScenes(recorded_.scene, scene.text);
      const bool isOfARun = given.endsAsRecorded ? recorded_.lastTick > 0 : !recorded_.scene.empty();
      if (!other.empty()) {
        std::fprintf(stderr,
                     "simulate: %s was recorded with another scene, so its motion is not compared: %s\n",
                     given.commands->c_str(), other.c_str());
        recorded_.ticks.clear();
      } else if (recorded_.ticks.empty() && isOfARun) {
        std::fprintf(
            stderr, "simulate: %s has no joint_states with a status of %s, so its motion is not compared%s\n",
            given.commands->c_str(), recorded_.node.c_str(),
            given.endsAsRecorded ? ", and the run ends with the last that it tells" : "");
      }
    }
    if (given.endsAsRecorded && recorded_.lastTick == 0) {
      throw Refused({{"--duration", "a time, for the bag has no states of " + recorded_.node, "nothing"}});
    }
    const std::string publisher = node ? *node : given.commands ? *fullName(recorded_.node) : usualNode;
    if (given.out) writer_.emplace(*given.out, given.views, publisher, simulation_, commands_, ticks_);
    if (given.urdf) writeUrdf(*given.urdf, scene, publisher);
  }

  Simulation& simulation() override { return simulation_; }

  double recordedEnd() const override { return ticks_.timeOf(static_cast<long long>(recorded_.lastTick)); }

  bool advanceTo(long long k, double t, const std::function<bool()>& keepGoing) override {
    const std::vector<CommandTaken>& commands = recorded_.commands;
    for (; next_ < commands.size() && commands[next_].tick <= static_cast<std::uint64_t>(k); ++next_) {
      const CommandTaken& command = commands[next_];
      ticks_.next = static_cast<long long>(command.tick);
      if (!goWhereItCame(command, keepGoing)) return false;
      if (const std::string refusal = commands_.take(command); !refusal.empty()) {
        commands_.refuse(refusal);
        if (refused_++ == 0) {
          firstRefused_ = command.number;
          firstRefusal_ = refusal;
        }
      } else if (writer_) {
        writer_->command(command);
      }
    }
    const bool isTick = t == ticks_.timeOf(k);
    return simulation_.advanceTo(isTick ? ticks_.sceneTime(k) : t - ticks_.simTime(0), keepGoing);
  }

  void tick(long long k) override {
    const std::vector<std::uint64_t>& known = recorded_.ticks;
    const auto entry = std::lower_bound(known.begin(), known.end(), static_cast<std::uint64_t>(k));
    const bool isKnown = entry != known.end() && *entry == static_cast<std::uint64_t>(k);
    if (left_.empty() && isKnown && simulation_.fault().empty() &&
        recorded_.digests[static_cast<std::size_t>(entry - known.begin())] !=
            digestOf(simulation_.q(), simulation_.qd())) {
      leave(k);
    }
    if (writer_ && k > 0) writer_->tick(k);
  }

  bool isAsRecorded() const override { return refused_ == 0 && left_.empty(); }

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
    if (refused_ > 0) text << "; the first refusal, of command " << firstRefused_ << ": " << firstRefusal_;
    text << '\n' << left_;
    return text.str();
  }

 private:
  /// Only a fault stops a node between two ticks. So does this: on the way to the tick, as an end elsewhere
  /// would change the steps. Returns false if interrupted.
  bool goWhereItCame(const CommandTaken& command, const std::function<bool()>& keepGoing) {
    if (command.kind == CommandTaken::RESET || command.scene_time <= simulation_.time()) return true;
    const bool arrives = simulation_.advanceTo(ticks_.sceneTime(ticks_.next), keepGoing);
    if (arrives) {
      std::fprintf(stderr,
                   "simulate: at %s s the node had failed, and command %llu came; this run did not fail\n",
                   toText(command.scene_time).c_str(), static_cast<unsigned long long>(command.number));
    }
    return arrives || !simulation_.fault().empty();
  }

  /// Says that the state of tick k is not the recorded one.
  void leave(long long k) {
    std::ostringstream text;
    text << "  from tick " << k << " (" << toText(ticks_.timeOf(k))
         << " s) on, the motion is not the recorded one: ";
    if (refused_ > 0) {
      text << "command " << firstRefused_ << " was refused\n";
    } else {
      // Between recorded commands none is missing: their numbers have no gap.
      if (next_ == recorded_.commands.size()) {
        text << "a command after number " << next_ << ", the last in the bag, is missing, or ";
      }
      text << "the node had another " << (recorded_.scene.empty() ? "scene, " : "")
           << "version or kind of processor, or the bag was changed\n";
    }
    left_ = text.str();
  }

  Ticks ticks_;
  Simulation simulation_;
  Commands commands_;
  RecordedCommands recorded_;
  std::size_t next_ = 0;  ///< index of the next command to take
  std::size_t refused_ = 0;
  std::uint64_t firstRefused_ = 0;  ///< the number of the first refused command
  std::string firstRefusal_;        ///< its reason
  std::string left_;                ///< where the motion left the recorded one; empty: nowhere
  std::optional<BagWriter> writer_;
};

}  // namespace

extern "C" Bags* openBags(const Scene& scene, const BagArguments& given) {
  ros::Time::init();  // for the stamps of ROS's log
  return new OfflineNode(scene, given);
}

}  // namespace planar_chain
