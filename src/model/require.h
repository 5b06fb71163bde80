#pragma once

/// Checks of values that a scene or a program gives.

#include <string>
#include <vector>

#include "planar_chain/fault.h"

namespace planar_chain {

/// Adds a fault unless `given` is finite and `isInRange`. which: reads on from "a number", as " > 0 kg".
void requireNumber(std::vector<Fault>& faults, const std::string& path, double given, bool isInRange,
                   const std::string& which);

}  // namespace planar_chain
