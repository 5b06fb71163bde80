#pragma once

/// The tool simulate's side of bags: a run takes recorded commands from one bag, and writes to another what a
/// node would publish. The code that needs ROS is a library of its own (src/ros/bag/bags.cpp). simulate loads
/// it when a run needs a bag, so other runs do not load ROS.

#include <functional>
#include <optional>
#include <string>

#include "planar_chain/scene.h"
#include "planar_chain/simulation.h"

namespace planar_chain {

/// The largest number of ticks in a run.
inline constexpr double mostRows = 1e8;
/// The longest run with bags, s: the stamps of ROS end at 2^32 s.
inline constexpr double longestRun = 4294967295;

struct BagArguments {
  std::optional<std::string> out;       ///< path of the bag to write
  bool views = false;                   ///< it also has what rviz shows
  std::optional<std::string> commands;  ///< path of the bag with recorded commands
  bool endsAsRecorded = false;      ///< the run ends with the last state or command in the bag of commands
  std::optional<std::string> urdf;  ///< path of the URDF to write, which is robot_description
  std::optional<std::string>
      node;  ///< the node that publishes; default: that of the commands, or /planar_chain
};

class Bags {
 public:
  virtual ~Bags() = default;

  virtual Simulation& simulation() = 0;

  /// Returns the time of the last state or command in the bag of commands, s. Requires endsAsRecorded.
  virtual double recordedEnd() const = 0;

  /// Takes the commands recorded up to tick k, then calls Simulation::advanceTo for the time t of row k.
  virtual bool advanceTo(long long k, double t, const std::function<bool()>& keepGoing) = 0;

  /// Writes the messages of tick k, after advanceTo() for it. After a fault that is the status,
  /// which names the fault. Writes nothing at tick 0, because no stamp is 0.
  /// @throws std::runtime_error when the disk is full, for example
  virtual void tick(long long k) = 0;

  /// Completes the bag.
  /// @throws std::runtime_error as tick()
  virtual void close() = 0;

  /// Returns a line that counts the commands taken and refused, with the reason of the first refusal, and one
  /// that says where the motion leaves the recorded one, if it does; empty without a bag of commands.
  virtual std::string summary() const = 0;
  /// False if a command was refused, or the motion left the recorded one.
  virtual bool isAsRecorded() const = 0;
};

/// The library's only function, exported as `openBags`: a run of the scene, whose publish settings give the
/// topics and rates. The caller deletes it.
/// @throws Refused with every fault of the arguments and of the bag of commands
using OpenBags = Bags*(const Scene& scene, const BagArguments& given);

}  // namespace planar_chain
