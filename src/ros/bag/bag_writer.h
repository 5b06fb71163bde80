#pragma once

/// Writes what a node publishes to a bag: the same topics, types and messages, made by the same functions.
///
/// rosbag::Bag writes the file. It seeks to the end of the file twice per message, but is fast enough: a
/// minute of config/scenes/double_pendulum.yaml at 200 Hz takes 0.34 s of processor time, 175 times less than
/// real time (test/README.md, Long checks). A writer of our own took 0.04 s, and 285 lines.

#include <planar_chain/CommandTaken.h>
#include <planar_chain/SimStatus.h>
#include <rosbag/bag.h>
#include <rosgraph_msgs/Clock.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "planar_chain/simulation.h"
#include "ros/messages/frames.h"
#include "ros/messages/messages.h"
#include "ros/messages/pace.h"
#include "ros/node/commands.h"

namespace planar_chain {

/// Tick k is stamped k/rate, rounded to ns, and is received at that time. /clock comes first. The status
/// fields of wall time (real_time_factor, overruns, lag) are 0. So two runs of a scene with the same commands
/// give the same bytes.
class BagWriter {
 public:
  /// node: the full name of the publishing node, such as /left/planar_chain.
  /// @throws Refused when the scene's frames have faults
  /// @throws std::runtime_error when the file cannot be opened
  BagWriter(const std::string& path, const Scene& scene, const std::string& node);

  /// Adds a command that was taken since the last tick.
  void command(const CommandTaken& taken) { taken_.push_back(taken); }

  /// Writes every message of tick k ≥ 1; after a fault only the status. simTime: simulated seconds since the
  /// start, resets included.
  /// @throws std::runtime_error when the disk is full, for example
  void tick(long long k, double simTime, const Simulation& simulation, const CommandTopics& commands);

  /// Writes the index. Without it rosbag refuses the file, and `rosbag reindex` repairs it.
  /// @throws std::runtime_error as tick()
  void close();

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

  void writeState(long long k, ros::Time stamp, const Simulation& simulation);
  void writeStatus(ros::Time stamp, double simTime, const Simulation& simulation,
                   const CommandTopics& commands);
  template <class Message>
  void write(Topic& topic, ros::Time stamp, Message& message);
  template <class Operation>
  void attempt(Operation operation) const;

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

}  // namespace planar_chain
