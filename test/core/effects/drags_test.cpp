/// Drag in a joint, the example of src/README.md for an effect: it is read and judged, agrees with the dense
/// road, its derivative with differences, its motion with the exact one by every method, rodas5p takes long
/// steps where it is stiff, and nothing of it runs where it is not. effect_laws_test has its laws.

#include "effects/drags.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>

#include "dynamics/dynamics.h"
#include "ode/methods.h"
#include "planar_chain/kane.h"
#include "planar_chain/linear_model.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"

namespace planar_chain {
namespace {

/// A flywheel: J = 0.5 kg m², c = 0.2 N m s²/rad², 3 rad/s, and nothing else.
constexpr double J = 0.5, c = 0.2, v0 = 3;
Scene flywheel(const std::string& method, const std::string& drag = "0.2") {
  return readSceneText(
      "chain: [wheel]\n"
      "gravity: [0, 0]\n"
      "links:\n"
      "  wheel: {mass: 1, inertia: 0.5, com: [0, 0], pin: [1, 0], joint: {drag: " +
      drag +
      "}, initial: {velocity: 3}}\n"
      "integrator: {method: " +
      method + ", tolerance: 1e-10, step: 0.001}\n");
}

/// Five links with gravity, springs, and drag in every joint, folded and turning both ways. exponent: "e6"
/// makes the drag a million times as strong.
Scene chainOfFive(const std::string& method, const std::string& exponent = "") {
  return readSceneText(
      "chain: [a, b]\n"
      "links:\n"
      "  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], joint: {drag: 0.3" +
      exponent +
      ", stiffness: 2},\n"
      "      initial: {angle: 0.4, velocity: 2}}\n"
      "  b: {mass: 0.5, inertia: 0.05, com: [0.3, 0], pin: [0.6, 0.1], repeat: 4, joint: {drag: 0.1" +
      exponent +
      "},\n"
      "      initial: {angle: -0.5, velocity: -3}}\n"
      "integrator: {method: " +
      method + ", tolerance: 1e-10, step: 0.0005}\n");
}

TEST(Drag, IsReadAndJudged) {
  EXPECT_EQ(flywheel("auto").chain.joints()[0].other("drag"), c);
  try {
    flywheel("auto", "-1");
    FAIL() << "a negative drag is taken";
  } catch (const Refused& refused) {
    EXPECT_EQ(toString(refused.faults()),
              "links/wheel/joint/drag: expected a number >= 0 N m s²/rad², got -1");
  }
}

TEST(Drag, SaysSoInTheLog) {
  SceneWords with, without;
  dragKind().summarize(flywheel("auto"), with);
  dragKind().summarize(flywheel("auto", "0"), without);
  EXPECT_EQ(with.runs, std::vector<std::string>{"1 drag"});
  EXPECT_EQ(without.runs.size() + without.leftOut.size(), 0U);  // as with friction
}

class ByEveryMethod : public testing::TestWithParam<std::string> {};

TEST_P(ByEveryMethod, SlowsAFlywheelAsTheFormulaSays) {
  // q̇ = v0/(1 + c v0 t/J), q = J/c ln(1 + c v0 t/J)
  Simulation simulation(flywheel(GetParam()));
  for (const double t : {0.5, 2.0}) {
    ASSERT_TRUE(simulation.advanceTo(t)) << simulation.fault();
    const double slowed = 1 + c * v0 * t / J;
    EXPECT_NEAR(simulation.q()[0], J / c * std::log(slowed), 1e-7) << t;
    EXPECT_NEAR(simulation.qd()[0], v0 / slowed, 1e-7) << t;
  }
  EXPECT_NEAR(simulation.energyBalance().residual, 0, 1e-7);
}

TEST_P(ByEveryMethod, MovesAChainAlike) {
  Simulation reference(chainOfFive("dop853")), simulation(chainOfFive(GetParam()));
  ASSERT_TRUE(reference.advanceTo(1) && simulation.advanceTo(1));
  for (std::size_t i = 0; i < reference.q().size(); ++i) {
    EXPECT_NEAR(simulation.q()[i], reference.q()[i], 1e-5) << i;
  }
  EXPECT_NEAR(simulation.energyBalance().residual, 0, 1e-5);
}

std::vector<std::string> methods() {
  std::vector<std::string> names = ode::methodNames();
  return names;
}

INSTANTIATE_TEST_SUITE_P(Drag, ByEveryMethod, testing::ValuesIn(methods()));

TEST(Drag, LetsRodas5pTakeLongStepsWhereItIsStiff) {
  const auto stepsOf = [](const char* method) {
    Scene scene = chainOfFive(method, "e6");
    scene.integrator.tolerance = 1e-6;
    Simulation simulation(scene);
    EXPECT_TRUE(simulation.advanceTo(1)) << simulation.fault();
    return simulation.statistics().steps;
  };
  // dopri5 needs 333 times as many to be stable. With half the derivative, it would be 2 times; with none,
  // 0.6.
  EXPECT_LT(100 * stepsOf("rodas5p"), stepsOf("dopri5"));
}

/// A cart that runs backwards, with two rods, and drag in every joint.
Scene cart() {
  return readSceneText(
      "chain: [cart, a, b]\n"
      "links:\n"
      "  cart: {mass: 1, pin: [0, 0.1], joint: {type: prismatic, axis: [1, 0], drag: 0.2},\n"
      "         initial: {velocity: -3}}\n"
      "  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], joint: {drag: 0.3}, initial: {velocity: "
      "-0.5}}\n"
      "  b: {mass: 0.5, inertia: 0.05, com: [0.3, 0], pin: [0.6, 0.1], joint: {drag: 0.1},\n"
      "      initial: {angle: -0.5, velocity: 2}}\n"
      "integrator: {tolerance: 1e-10}\n");
}

class Motions : public testing::TestWithParam<Scene> {
 protected:
  const Scene& scene = GetParam();
  const int n = scene.chain.size();
  const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(scene.q.data(), n);
  const Eigen::VectorXd qd = Eigen::Map<const Eigen::VectorXd>(scene.qd.data(), n);

  Eigen::VectorXd dense(const Eigen::VectorXd& rates) const {
    return kane(scene.chain, q, rates, activeForces(scene, 0, q, rates)).qdd;
  }
};

TEST_P(Motions, AgreeWithTheDenseRoad) {
  Simulation simulation(scene);
  Eigen::VectorXd qdd(n);
  simulation.accelerations(qdd.data());
  EXPECT_LT((qdd - dense(qd)).norm(), 1e-11 * qdd.norm());
  ASSERT_TRUE(simulation.advanceTo(1)) << simulation.fault();
  EXPECT_NEAR(simulation.energyBalance().residual, 0, 1e-7);
}

TEST_P(Motions, HaveTheirExactDerivative) {
  // A by automatic differentiation of what the effect says of itself, and by differences of the dense road.
  const Eigen::MatrixXd A = linearModel(scene, 0, q, qd).A;
  constexpr double h = 1e-6;
  for (int j = 0; j < n; ++j) {
    const Eigen::VectorXd change = h * Eigen::VectorXd::Unit(n, j);
    const Eigen::VectorXd difference = (dense(qd + change) - dense(qd - change)) / (2 * h);
    EXPECT_LT((A.col(n + j).tail(n) - difference).norm(), 1e-7 * difference.norm()) << j;
  }
}

INSTANTIATE_TEST_SUITE_P(Drag, Motions, testing::Values(chainOfFive("auto"), cart()));

// It falls from rest beside a carriage that sticks. In steps of 1e-10 s the rounding of an angle was taken
// for a rate whose sign changes, and the stiff methods did not get away from the start.
TEST(Drag, FromRestIsNoStall) {
  Scene scene = readSceneText(
      "{chain: [x, y, arm], links: {arm: {mass: 0.5, inertia: 0.16666666666666666, com: [1, 0], pin: [2, 0], "
      "joint: "
      "{stiffness: 0.981, rest_angle: -0.5}}, x: {mass: 50, joint: {type: prismatic, axis: [1, 0], friction: "
      "245.25}}, y: {mass: 5, joint: {type: prismatic, axis: [0, 1], drag: 0.01}}}}");
  for (const char* method : {"auto", "rodas5p", "radau13"}) {
    for (const double tolerance : {1e-6, 1e-8, 1e-10}) {
      scene.integrator.method = method;
      scene.integrator.tolerance = tolerance;
      Simulation simulation(scene);
      EXPECT_TRUE(simulation.advanceTo(0.3)) << simulation.fault();
      EXPECT_LT(simulation.statistics().rejected, 100) << method << " to " << tolerance;
    }
  }
}

// Strong drag of an oscillation that is so slow that q̇ stays near 1e-9: there, drags had the wrong sign.
// x'' = −x − |x'| x' in its own units, by scipy's DOP853 to 1e-12.
TEST(Drag, BrakesHoweverSlowTheMotion) {
  Scene slides = readSceneText(
      "{gravity: [0, 0], chain: [cart, arm], links: {cart: {mass: 1, joint: {type: prismatic, stiffness: "
      "1.0e-4, drag: 1.0e+6}, initial: {position: "
      "1.0e-6}}, arm: {mass: 1.0e-6, inertia: 0, com: [1.0e-6, 0], pin: [1.0e-6, 0], initial: {angle: "
      "1.57079632679}}}}");
  Scene turns = readSceneText(
      "{gravity: [0, 0], chain: [rod], links: {rod: {mass: 1, inertia: 1, com: [0, 0], pin: [1, 0], joint: "
      "{stiffness: 1.0e-6, drag: 1.0e+6}, initial: {angle: 1.0e-6}}}}");
  turns.integrator.tolerance = 1e-12;
  for (const char* method : {"auto", "radau13", "rodas5p", "dop853", "taylor"}) {
    for (const auto& [scene, end, q, error] : {std::tuple{&slides, 600., 2.19699117e-7, 6e-12},
                                               std::tuple{&turns, 60000., -3.76232808e-8, 6e-8}}) {
      scene->integrator.method = method;
      Simulation simulation(*scene);
      ASSERT_TRUE(simulation.advanceTo(end)) << method << ": " << simulation.fault();
      EXPECT_NEAR(simulation.q()[0], q, error) << method;
      EXPECT_GT(simulation.energyBalance().dissipated, 0) << method;
    }
  }
}

// Without error control there is no tolerance to judge the sign of the rate by.
TEST(Drag, BrakesSlowMotionsInEqualSteps) {
  Scene scene = readSceneText(
      "{gravity: [0, 0], chain: [cart, arm], links: {"
      "cart: {mass: 1, joint: {type: prismatic, stiffness: 39.4784176, drag: 5.0e+9}, initial: {position: "
      "1.0e-10}}, arm: {mass: 1.0e-9, inertia: 0, com: [1.0e-9, 0], pin: [1.0e-9, 0],"
      " joint: {drive: {offset: 1.57}}}}}");
  for (const char* method : {"rk4", "ros34pw2_fixed"}) {
    scene.integrator.method = method;
    scene.integrator.step = 0.001;
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(3)) << simulation.fault();
    EXPECT_NEAR(simulation.q()[0], 1.96098277e-11, 1e-16) << method;  // x'' = −k x − c |x'| x' by scipy
  }
}

TEST(Drag, IsNotThereWithoutItsKey) {
  const Scene scene = flywheel("auto", "0");
  EXPECT_EQ(dragKind().make(scene), nullptr);
  EXPECT_EQ(Dynamics(scene).works(), 0);
}

}  // namespace
}  // namespace planar_chain
