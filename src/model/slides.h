#pragma once

/// Requirements on the slides of a chain, and the units of their joints.

#include <string>
#include <vector>

#include "planar_chain/chain.h"

namespace planar_chain {

constexpr int mostSlides = 2;

/// True if a vector has a direction: products of two such are numbers of full precision, neither 0 nor
/// infinite.
inline bool isDirection(Vec2d a) {
  constexpr double shortest = 1e-100;
  return length(a) >= shortest && length(a) <= 1 / shortest;
}
constexpr const char* directionInWords = "a direction [x, y] of a length from 1e-100 to 1e100";

/// The words of a fault for a joint that slides: its units in place of those of an angle.
std::string inUnitsOfSlide(std::string words);

/// Adds the faults of the slides. slides: the number of those in front.
void requireSlides(const std::vector<Link>& links, const std::vector<Joint>& joints, int slides,
                   std::vector<Fault>& faults);

}  // namespace planar_chain
