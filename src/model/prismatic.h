#pragma once

/// Requirements on the prismatic joints of a chain, and their units.

#include <string>
#include <vector>

#include "planar_chain/chain.h"

namespace planar_chain {

/// True if a vector has a direction: products of two such are numbers of full precision, neither 0 nor
/// infinite.
inline bool isDirection(Vec2d a) {
  constexpr double shortest = 1e-100;
  return length(a) >= shortest && length(a) <= 1 / shortest;
}
constexpr const char* directionInWords = "a direction [x, y] of a length from 1e-100 to 1e100";

/// The words of a fault for a prismatic joint: its units in place of those of an angle.
std::string inUnitsOfPrismatic(std::string words);

/// Adds the faults of the prismatic joints and their links.
void requirePrismatic(const std::vector<Link>& links, const std::vector<Joint>& joints,
                      std::vector<Fault>& faults);

}  // namespace planar_chain
