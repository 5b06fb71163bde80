#pragma once

#include <vector>

#include "dynamics/dynamics.h"
#include "report/benchmark/chains.h"
#include "simd/cache_lines.h"

namespace planar_chain::benchmarks {

/// Rods in motion, ready to be evaluated, linearized and integrated.
struct MovingRods {
  MovingRods(int n, const Posture& posture) : scene(sceneOf(rods(n), posture)), dynamics(scene) {
    double theta = 0, omega = 0;
    for (const double q : posture.q) y.push_back(theta += q);
    for (const double qd : posture.qd) y.push_back(omega += qd);
    dydt.resize(y.size());
    laneOrderedY = CacheLines(static_cast<std::size_t>(dynamics.sizeInLaneOrder()));
    laneOrderedRates = CacheLines(static_cast<std::size_t>(dynamics.sizeInLaneOrder()));
    dynamics.toLaneOrder(y.data(), laneOrderedY.data());
  }

  /// As the methods evaluate it at their stages.
  void evaluate() { dynamics.rates(0, laneOrderedY.data(), laneOrderedRates.data() + dynamics.positions()); }

  Scene scene;
  Dynamics dynamics;
  std::vector<double> y, dydt;                ///< θ_1…θ_n ω_1…ω_n; ω_1…ω_n α_1…α_n
  CacheLines laneOrderedY, laneOrderedRates;  ///< the same, in lane order
};

}  // namespace planar_chain::benchmarks
