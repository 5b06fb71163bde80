#pragma once

/// What the node says of itself when it starts, each in a line.

#include <string>

#include "planar_chain/simulation.h"
#include "ros/messages/frames.h"

namespace planar_chain {

/// What the scene runs, and what it leaves out.
std::string whatRuns(const Simulation& simulation);

/// Which messages are made, and which never.
std::string whatIsPublished(const PublishSettings& settings, const Frames& frames);

}  // namespace planar_chain
