#pragma once

/// What a node publishes, as a bag: the same topics, types and messages, made by the same functions.

#include <planar_chain/CommandTaken.h>
#include <planar_chain/SimStatus.h>
#include <rosgraph_msgs/Clock.h>

#include <cstdint>
#include <string>
#include <vector>

#include "planar_chain/simulation.h"
#include "ros/bag/bag_file.h"
#include "ros/messages/frames.h"
#include "ros/messages/messages.h"
#include "ros/messages/pace.h"
#include "ros/node/commands.h"

namespace planar_chain {

/// Tick k is stamped k/rate, rounded to ns, and received at that time; /clock comes first. What the status
/// says of wall time (real_time_factor, overruns, lag) is 0. So the bag is a function of the scene and the
/// commands.
class BagWriter {
 public:
  /// node: the full name of the node whose topics these are, such as /left/planar_chain.
  /// @throws Refused what is wrong with the scene's frames
  /// @throws std::runtime_error when the file cannot be opened
  BagWriter(const std::string& path, const Scene& scene, const std::string& node);

  /// A command that was taken since the last tick.
  void command(const CommandTaken& taken) { taken_.push_back(taken); }

  /// Everything that a node publishes at tick k ≥ 1; after a fault only the status. simTime: s simulated so
  /// far, resets or not.
  /// @throws std::runtime_error when the disk is full or the like
  void tick(long long k, double simTime, const Simulation& simulation, const Commands& commands);

  void close() { file_.close(); }

 private:
  void writeState(long long k, ros::Time stamp, const Simulation& simulation);
  void writeStatus(ros::Time stamp, double simTime, const Simulation& simulation, const Commands& commands);

  PublishSettings settings_;
  Frames frames_;
  Messages messages_;
  Pace pace_;
  BagFile file_;
  std::uint32_t clockOut_, jointStatesOut_, tfOut_, staticTfOut_, linkStatesOut_, statusOut_, commandsOut_;
  rosgraph_msgs::Clock clock_;
  SimStatus status_;
  std::vector<CommandTaken> taken_;
};

}  // namespace planar_chain
