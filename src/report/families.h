#pragma once

/// The chains on which `stability` measures: each family varies one number.

#include <string>
#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain::tools {

/// A chain, undriven, which would hang straight down at rest.
struct Case {
  std::string family;
  double value = 0;  ///< of what the family varies
  Scene scene;
  double horizon = 0;      ///< s that a run lasts at least
  double smallest = 1e-9;  ///< step that is tried, s
  /// The motion stays close to rest, so that the eigenvalues there say what explicit methods need.
  bool isNearRest = true;
};

struct Family {
  std::string name;
  std::string story;   ///< what the chain is, in a sentence
  std::string varied;  ///< head of the column
  std::vector<Case> cases;
};

/// quick: few and short chains.
std::vector<Family> stabilityFamilies(bool quick);

/// A uniform chain of 1 m and 1 kg, swung out by 0.1 rad and bent a little.
Scene hangingChain(int n);

}  // namespace planar_chain::tools
