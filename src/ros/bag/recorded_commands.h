#pragma once

/// The commands that a node took, from a recording of them.

#include <planar_chain/CommandTaken.h>

#include <optional>
#include <string>
#include <vector>

namespace planar_chain {

struct RecordedCommands {
  std::string node;                    ///< the node that took them, such as /left/planar_chain
  std::vector<CommandTaken> commands;  ///< in the order in which they were taken
  long long lastTick = 0;              ///< of the states and commands; 0 without states
  std::string scene;                   ///< its text; empty if the bag has none
};

/// Reads ~commands_taken, of which no command may be missing.
/// @param node the node that took the commands; without it, the bag must hold those of one node only
/// @param rate ticks per second
/// @param alsoEnd finds lastTick, from joint_states and ~status
/// @throws Refused when the file cannot be read, or has no such commands or not all of them
RecordedCommands readCommands(const std::string& path, const std::optional<std::string>& node, double rate,
                              bool alsoEnd);

/// Where two scenes differ first, with both values, apart from what is published; empty if nowhere. Both are
/// texts. A text that spells a number equals the number.
std::string differenceOfScenes(const std::string& recorded, const std::string& present);

}  // namespace planar_chain
