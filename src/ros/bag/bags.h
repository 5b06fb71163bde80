#pragma once

/// What the tool simulate knows of bags: a run that takes recorded commands, and writes what a node would
/// publish. The bags themselves are ROS's; they live in a library of their own (src/ros/bags.cpp), which is
/// loaded when a run asks for one, so that no other run pays for ROS.

#include <optional>
#include <string>

#include "planar_chain/scene.h"
#include "planar_chain/simulation.h"

namespace planar_chain {

/// As many ticks a run may have.
inline constexpr double mostRows = 1e8;

struct BagArguments {
  std::optional<std::string> out;       ///< path of the bag to write
  std::optional<std::string> commands;  ///< path of the bag whose commands are taken
  bool endsAsRecorded = false;          ///< the run is to end with the last state in the bag of commands
  std::optional<std::string> urdf;      ///< path of the file to write: what robot_description is
  std::optional<std::string> node;      ///< whose topics these are; absent: found out, or /planar_chain
};

class Bags {
 public:
  virtual ~Bags() = default;

  virtual Simulation& simulation() = 0;

  /// When the last state in the bag of commands was, s; for runs that end there.
  virtual double recordedEnd() const = 0;

  /// Simulation::advanceTo for the time t of row k, after the commands that were taken before tick k.
  virtual bool advanceTo(long long k, double t) = 0;

  /// Writes what the node publishes at tick k, to whose time the simulation has come; after a fault only
  /// the status, which names it. Nothing at tick 0, for time 0 is never stamped.
  /// @throws std::runtime_error when the disk is full or the like
  virtual void tick(long long k) = 0;

  /// Makes the bag whole.
  /// @throws std::runtime_error as tick()
  virtual void close() = 0;

  /// What became of the commands, in lines of words; empty where there were none to take.
  virtual std::string summary() const = 0;
};

/// The library's one function, under the name `openBags`: a run of a scene, whose publish settings say what
/// is written, and when. The caller deletes it.
/// @throws Refused every fault of the arguments and of the bag of commands
using OpenBags = Bags*(const Scene& scene, const BagArguments& given);

}  // namespace planar_chain
