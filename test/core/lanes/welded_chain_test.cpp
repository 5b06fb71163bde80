/// Friction in long chains: bodies that stick together as one body, against the recursion for prescribed
/// joints.

#include "dynamics/welded_chain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "dynamics/dynamics.h"
#include "planar_chain/simulation.h"
#include "recursion/general_recursion.h"
#include "support/known_chains.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

/// Random motions of a random chain. This share of its joints sticks.
void compare(int links, unsigned seed, double share) {
  const Scene scene = test::randomScene(links, seed);
  const auto n = index(links);
  test::Random random(seed);
  Couplings couplings(links);
  std::vector<double> theta(n), omega(n), N(n);
  std::vector<Rotation<double>> e(n);
  for (std::size_t j = 0; j < n; ++j) {
    const double q = random.between(-3, 3), rate = random.between(-2, 2);
    const bool sticks = random.between(0, 1) < share;
    couplings.joints[j].isPrescribed = sticks;
    couplings.prescribed[j].value = q;
    theta[j] = (j > 0 ? theta[j - 1] : 0) + q;
    omega[j] = (j > 0 ? omega[j - 1] : 0) + (sticks ? 0 : rate);
    e[j] = Rotation<double>::of(theta[j]);
    N[j] = random.between(-5, 5);
  }

  std::vector<double> alpha(n), moments(n), expectedAlpha(n), expectedMoments(n);
  GeneralRecursion<double>(scene.chain)
      .accelerations({e.data(), omega.data(), nullptr},
                     {N.data(), nullptr, couplings.joints.data(), -1.0 * scene.chain.gravity()}, {},
                     expectedAlpha.data(), expectedMoments.data());
  WeldedChain welded(scene.chain, simd::kernelFor(scene.chain.size(), {}));
  welded.weld(couplings);
  welded.accelerations(theta.data(), omega.data(), N.data(), alpha.data());
  welded.moments(N.data(), moments.data());

  const auto largest = [](const std::vector<double>& of) {
    double most = 1;
    for (const double x : of) most = std::max(most, std::abs(x));
    return most;
  };
  for (std::size_t j = 0; j < n; ++j) {
    EXPECT_NEAR(alpha[j], expectedAlpha[j], 1e-10 * largest(expectedAlpha)) << "link " << j;
    EXPECT_NEAR(moments[j], expectedMoments[j], 1e-10 * largest(expectedMoments)) << "joint " << j;
  }
}

TEST(WeldedChain, MovesAsTheRecursionWithHeldJoints) {
  for (const int links : {13, 14, 20, 33, 100}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      for (const double share : {0.0, 0.3, 0.8, 1.0}) {
        SCOPED_TRACE(testing::Message() << links << " links, seed " << seed << ", share " << share);
        compare(links, seed, share);
      }
    }
  }
}

// Alone or in segments: it holds to the last bit, or the joint moves as without.
TEST(Friction, ABreakawayTorqueAloneHolds) {
  for (const int links : {1, 20}) {
    const double weight = 9.81 * links * links / 2;  // the torque in the first joint, N m
    const auto chain = [&](double breakaway) {
      Joint joint;
      if (breakaway > 0) joint.others.emplace_back("breakaway", breakaway);
      Simulation simulation(
          test::uniformChain(links, {"", 1, 1. / 12, {0.5, 0}, {1, 0}}, joint, joint, {0, -9.81}));
      EXPECT_TRUE(simulation.advanceTo(0.5)) << simulation.fault();
      return simulation.q();
    };
    EXPECT_EQ(chain(1.001 * weight), std::vector<double>(index(links), 0.0));
    const std::vector<double> loose = chain(1e-9 * weight), expected = chain(0);
    for (std::size_t i = 0; i < loose.size(); ++i) EXPECT_NEAR(loose[i], expected[i], 1e-6) << "joint " << i;
  }
}

// Rounding makes joints of long chains stick and slide by turns: each decision must end all the same.
TEST(Friction, DecidesInFewRounds) {
  Joint joint;
  joint.others.emplace_back("friction", 0.01);
  Scene scene = test::uniformChain(1000, {"", 0.1, 1e-4, {0.05, 0}, {0.1, 0}}, joint, joint, {0, -9.81});
  scene.integrator.tolerance = 1e-4;
  Simulation simulation(scene);
  simulation.advanceTo(0.3);
  const Statistics statistics = simulation.statistics();
  EXPECT_EQ(simulation.fault(), "");
  EXPECT_GT(statistics.steps, 1000);
  EXPECT_LT(statistics.evaluations, 20 * statistics.steps);
}

}  // namespace
}  // namespace planar_chain
