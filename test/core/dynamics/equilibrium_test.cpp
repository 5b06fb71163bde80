/// The search for an equilibrium: it says whether it gave up or there is none.
///
///     two level rods    hang: q = (−π/2, 0)
///     a closed chain    at rest q̈ = 0, as the equations of motion have it

#include "dynamics/equilibrium.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "dynamics/dynamics.h"
#include "planar_chain/scene_reader.h"

namespace planar_chain {
namespace {

Scene rods(const std::string& more) {
  return readSceneText(
      "chain: [a, b]\nlinks:\n  a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]}\n"
      "  b: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]}\n" +
      more);
}

TEST(Equilibrium, OfASearchThatGaveUpThereMayBeOne) {
  const Scene scene = rods("");
  try {
    equilibriumOf(scene, 0, scene.q, 2);
    FAIL() << "found in two steps";
  } catch (const SearchGaveUp& search) {
    EXPECT_STREQ(search.what(), "the search for an equilibrium gave up after 2 steps: there may be one");
  }
  const std::vector<double> found = equilibriumOf(scene, 0, scene.q);
  EXPECT_NEAR(found[0], -std::acos(-1) / 2, 1e-12);
  EXPECT_NEAR(found[1], 0, 1e-12);
}

TEST(Equilibrium, IsFoundFromFarBeyondALimit) {
  for (const char* const holds : {"lower: -0.1, upper: 0.1", "stiffness: 100, rest_angle: 0.1"}) {
    const std::string rod =
        ": {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {" + std::string(holds) + "}}\n";
    const Scene scene = readSceneText("chain: [a, b]\nlinks:\n  a" + rod + "  b" + rod);
    const std::vector<double> near = equilibriumOf(scene, 0, {0, 0});
    for (const double far : {1e6, -1e6, 30.}) {
      const std::vector<double> found = equilibriumOf(scene, 0, {far, -far});
      for (const std::size_t j : {0, 1}) EXPECT_NEAR(found[j], near[j], 1e-9) << holds << " from " << far;
    }
  }
}

/// The largest |q̈| at rest, rad/s².
double accelerationAtRest(const Scene& scene, const std::vector<double>& q) {
  const std::size_t n = q.size();
  std::vector<double> y(2 * n, 0), qdd(n);
  toAbsolute(q.data(), scene.chain.size(), y.data());
  Dynamics dynamics(scene);
  dynamics.enter(0);
  dynamics.enterState(0, y.data());
  dynamics.accelerations(0, y.data(), qdd.data());
  double most = 0;
  for (const double one : qdd) most = std::max(most, std::abs(one));
  return most;
}

TEST(Equilibrium, OfAClosedChainIsExactWhereItsOpenChainWouldHaveNone) {
  // Without the tip's hold these are no minima of the energy: H has a negative eigenvalue.
  const auto machine = [](const char* tip, const char* angle) {
    return readSceneText(
        "chain: [a, b, c]\nlinks:\n  a: {mass: 1, inertia: 0.1, com: [0.45, 0], pin: [0.9, 0], initial: "
        "{angle: " +
        std::string(angle) +
        "}}\n  b: {mass: 1, inertia: 0.1, com: [0.35, 0], pin: [0.7, 0], joint: {stiffness: 3}}\n"
        "  c: {mass: 1, inertia: 0.1, com: [0.65, 0], pin: [1.3, 0]}\ntip: {" +
        tip + "}\n");
  };
  for (const char* const tip : {"pin: [1.2, 0]", "line: {point: [1.2, 0], direction: [1, 0.4]}"}) {
    for (const char* const angle : {"0.5", "1", "0.2", "1.4"}) {
      const Scene scene = machine(tip, angle);
      EXPECT_LE(accelerationAtRest(scene, equilibriumOf(scene, 0, scene.q)), 1e-11)
          << tip << " from " << angle;
    }
  }
}

TEST(Equilibrium, OfAnEnergyWithoutAMinimumThereIsNone) {
  const Scene scene = rods("gravity: [0, 0]\nloads: {motor: {joint: b_joint, torque: 1}}\n");
  try {
    equilibriumOf(scene, 0, scene.q);
    FAIL() << "found";
  } catch (const SearchGaveUp& search) {
    FAIL() << search.what();
  } catch (const std::domain_error& none) {
    EXPECT_NE(std::string(none.what()).find("falls without end"), std::string::npos) << none.what();
  }
}

/// Why there is none: of a rod on a spring without weight, under this torque.
std::string whyNone(const std::string& spring, const std::string& torque) {
  const Scene scene = readSceneText(
      "{gravity: [0, 0], chain: [a], links: {a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: "
      "{" +
      spring + "}}}, loads: {one: {joint: a_joint, torque: " + torque +
      "}, other: {joint: a_joint, torque: " + torque + "}}}");
  try {
    return "found at " + std::to_string(equilibriumOf(scene, 0, scene.q)[0]);
  } catch (const std::domain_error& none) {
    return none.what();
  }
}

TEST(Equilibrium, TellsWhyNoneIsFound) {
  EXPECT_EQ(whyNone("stiffness: 1", "1"), "found at 2.000000");
  EXPECT_EQ(whyNone("stiffness: 1", "1000"),
            "the search for an equilibrium gave up 1000 rad from its start: there may be one");
  EXPECT_EQ(whyNone("damping: 1", "1"),
            "the energy falls without end, as under a constant torque without a spring");
  EXPECT_EQ(whyNone("stiffness: 1", "1.5e308"), "forces and torques whose sum is not finite");
}

}  // namespace
}  // namespace planar_chain
