#pragma once

/// The commands that a node took, from a recording of them.

#include <planar_chain/CommandTaken.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace planar_chain {

struct RecordedCommands {
  std::string node;                    ///< the node that took them, such as /left/planar_chain
  std::vector<CommandTaken> commands;  ///< in the order in which they were taken
  std::uint64_t lastTick = 0;          ///< of the states and commands; 0 without states
  std::string scene;                   ///< its text; empty if the bag has none
  /// The ticks of the states, in their order, as far as ~status has them; and digestOf() each state.
  std::vector<std::uint64_t> ticks, digests;
};

/// Equal for two states if they are equal to the last bit.
std::uint64_t digestOf(const std::vector<double>& q, const std::vector<double>& qd);

/// Reads ~commands_taken, of which no command may be missing. A child process does it, because rosbag's
/// reader crashes on some damaged bags.
/// @param node the node that took the commands; without it, the bag must hold those of one node only
/// @param rate ticks per second
/// @param needsEnd refuses joint_states and ~status of another version; otherwise they are left out
/// @throws Refused when the file cannot be read, has no such commands or not all of them, or if the node was
/// started again
RecordedCommands readCommands(const std::string& path, const std::optional<std::string>& node, double rate,
                              bool needsEnd);

/// Returns the first difference of two scenes, with both values, apart from publishing and sensors; empty if
/// there is none. Both are texts. A text that spells a number equals the number.
std::string differenceOfScenes(const std::string& recorded, const std::string& present);

}  // namespace planar_chain
