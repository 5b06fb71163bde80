#pragma once

/// What is checked of messages and requests alike.

#include <string>
#include <vector>

#include "planar_chain/fault.h"

namespace planar_chain {

/// A finite number; else a fault. unit: such as "N m".
void checkFinite(std::vector<Fault>& faults, const std::string& path, const char* unit, double value);

/// One finite number per joint; else the faults. what, unit: such as "angles", "rad".
void checkValues(std::vector<Fault>& faults, const std::string& path, const char* what, const char* unit,
                 const std::vector<double>& values, std::size_t joints);

}  // namespace planar_chain
