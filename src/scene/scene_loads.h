#pragma once

/// The loads of a scene. Internal to the reader.

#include <map>
#include <string>
#include <vector>

#include "planar_chain/scene.h"
#include "planar_chain/value.h"

namespace planar_chain {

/// What loads may refer to, by name.
struct ChainNames {
  std::map<std::string, int> links;
  std::map<std::string, int> joints;
  std::vector<Vec2d> com;  ///< of each link: where a force acts by default
};

/// @param value the scene's `loads`, may be null (absent)
/// @param names null: not known for certain, for the chain has faults of its own; then loads are held
///   against everything but the names.
std::vector<Load> readLoads(const Value* value, const ChainNames* names, std::vector<Fault>& faults);

}  // namespace planar_chain
