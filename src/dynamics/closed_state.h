#pragma once

/// A state that a user gives, moved onto the condition of a held tip.

#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain {

struct Closing {
  bool isClosed = true;
  double gap = 0;            ///< what is left, m
  bool onlyTouches = false;  ///< the tip touches its line, and no motion leads across
};

/// Moves relative angles and rates at time t (s) to where the tip is held, by the least motion in the metric
/// of the mass matrix. From a pose from which that does not lead there, such as a straight one, it starts
/// again with the chain laid along an arc, or bent. Driven joints are where their laws have them. A free tip:
/// changes nothing. Allocates.
Closing closeState(const Scene& scene, double t, std::vector<double>& q, std::vector<double>& qd);

}  // namespace planar_chain
