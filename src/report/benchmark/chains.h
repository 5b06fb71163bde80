#pragma once

/// The chains that are measured: n uniform rods of 1 m and 1 kg under gravity, no springs, dampers or loads,
/// as the other programs have them too.

#include <string>
#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain::benchmarks {

/// 1 to 10,000.
const std::vector<int>& sizes();

Chain rods(int n);

/// Relative angles, rad, and rates, rad/s.
struct Posture {
  std::vector<double> q, qd;
};

/// θ_i anywhere within 0.1 rad of a line, or anywhere at all; ω_i within ±1 rad/s. Every call
/// returns the same values.
Posture nearlyStraight(int n);
Posture crooked(int n);

struct Shape {
  std::string name;
  Posture (*posture)(int n);
};
/// Both.
const std::vector<Shape>& shapes();

/// Rods in a posture, as a scene.
Scene sceneOf(const Chain& chain, const Posture& posture);

/// A uniform chain of 1 m and 1 kg, 0.1 rad away from where it would hang at rest.
Scene hanging(int n);

}  // namespace planar_chain::benchmarks
