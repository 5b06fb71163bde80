#pragma once

/// The commands that a bag holds, and the tick before which the node took each.

#include <planar_chain/CommandTaken.h>

#include <optional>
#include <string>
#include <vector>

namespace planar_chain {

struct RecordedCommands {
  std::string node;                    ///< whose they were, such as /left/planar_chain
  std::vector<CommandTaken> commands;  ///< in the order in which they were taken
  bool isExact;                        ///< ticks are the node's own; else the recorder's
  long long lastTick;                  ///< of the states in the bag, give or take one; 0: none found
};

/// From ~commands_taken where the bag has it: ticks are exact, and none may be missing. Otherwise from
/// ~joint_torques, ~joint_torque and ~link_force: a command is taken to come after the joint_states
/// that were received last before it, and ~status tells at which stamp sim time began.
/// `node`: whose; absent: the bag must hold the commands of one only. `rate`: of the ticks, Hz.
/// `alsoEnd`: whether lastTick is looked for, on joint_states and ~status.
/// @throws Refused when the file is no bag that can be read, or holds no such commands, or not all
RecordedCommands readCommands(const std::string& path, const std::optional<std::string>& node, double rate,
                              bool alsoEnd);

}  // namespace planar_chain
