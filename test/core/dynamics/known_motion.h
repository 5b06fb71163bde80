#pragma once

/// Motions of 3 s that dense equations of another program gave.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"

namespace planar_chain::test {

struct KnownMotion {
  const char* name;
  std::string scene;
  const std::vector<double>& end;  ///< [q q̇]
};

/// Expects that motion at a tolerance of 1e-10. mostResidual: of the energy balance, J.
inline void expectMotion(const KnownMotion& known, const char* method, double mostResidual) {
  SCOPED_TRACE(known.name);
  Scene scene = readSceneText(known.scene);
  scene.integrator.method = method;
  scene.integrator.tolerance = 1e-10;
  Simulation simulation(scene);
  for (int k = 1; k <= 30; ++k) {
    ASSERT_TRUE(simulation.advanceTo(0.1 * k)) << simulation.fault();
    EXPECT_LT(simulation.closureError(), 1e-12 * scene.chain.reach());
  }
  const std::size_t n = scene.q.size();
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_NEAR(simulation.q()[i], known.end[i], 1e-8) << "q of " << i;
    EXPECT_NEAR(simulation.qd()[i], known.end[n + i], 1e-7) << "rate of " << i;
  }
  EXPECT_EQ(simulation.statistics().rescues, 0);
  EXPECT_LT(std::abs(simulation.energyBalance().residual), mostResidual);
}

}  // namespace planar_chain::test
