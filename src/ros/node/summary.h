#pragma once

/// The two lines that the node logs when it starts.

#include <string>

#include "planar_chain/simulation.h"
#include "ros/messages/frames.h"

namespace planar_chain {

/// What the scene runs, and what it leaves out.
std::string whatRuns(const Simulation& simulation);

/// Which topics are published, and which are disabled.
std::string whatIsPublished(const PublishSettings& settings, const Frames& frames);

}  // namespace planar_chain
