/// Machines whose joints rub, each of which once stuck or slid otherwise than the law of dry friction says,
/// or stopped. They were found among random ones. What is known of their motion: it is the same by every
/// method, and no joint at rest bears more than its breakaway torque.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "dynamics/closed_state.h"
#include "dynamics/dynamics.h"
#include "effects/effect_kind.h"
#include "effects/stick_slip.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "support/reference_data.h"

namespace planar_chain {
namespace {

constexpr double duration = 1.2;  // s

/// The angles at the end. rows: times at which it stops on the way.
std::vector<double> after(Scene scene, const char* method, double tolerance, int rows) {
  SCOPED_TRACE(std::string(method) + " to " + std::to_string(tolerance) + ", " + std::to_string(rows) +
               " rows");
  scene.integrator.method = method;
  scene.integrator.tolerance = tolerance;
  Simulation simulation(scene);
  std::vector<double> tau(scene.q.size());
  for (int k = 1; k <= rows; ++k) {
    if (!simulation.advanceTo(k * duration / rows)) {
      ADD_FAILURE() << simulation.fault();
      break;
    }
    simulation.jointTorques(tau.data());
    for (std::size_t i = 0; i < tau.size(); ++i) {
      const Joint& joint = scene.chain.joints()[i];
      if (!mayStick(joint) || simulation.qd()[i] != 0) continue;
      const double breakaway = std::max(joint.other("friction"), joint.other("breakaway"));
      EXPECT_LT(std::abs(tau[i]), 1.01 * breakaway) << joint.name << " at " << simulation.time() << " s";
    }
  }
  return simulation.q();
}

class Sticking : public testing::TestWithParam<const char*> {};

TEST_P(Sticking, IsTheSameByEveryMethod) {
  const Scene scene = test::referenceScene(std::string("sticking/") + GetParam() + ".yaml");
  const std::vector<double> exact = after(scene, "dopri5", 1e-11, 1200);
  for (const char* method : {"auto", "dop853", "dopri5", "rodas5p", "radau13"}) {
    for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
      for (const int rows : {1, 60}) {
        const std::vector<double> found = after(scene, method, tolerance, rows);
        // One case is less exact, 0.12 of the tolerance: rodas5p makes a tenth fewer steps there than with
        // the Jacobian of before, which had drives at another time.
        const bool isLess = std::string(GetParam()) == "within_a_step" && std::string(method) == "rodas5p" &&
                            tolerance == 1e-10 && rows == 60;
        const double share = isLess ? 0.15 : 0.1;
        for (std::size_t i = 0; i < exact.size(); ++i)
          EXPECT_NEAR(found[i], exact[i], share * tolerance * (1 + std::abs(exact[i])))
              << method << " to " << tolerance << ", joint " << i;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Machines, Sticking,
                         testing::Values("circles", "circles_with_breakaway", "left_over_rates", "locked",
                                         "within_a_step"),
                         [](const auto& one) { return std::string(one.param); });

/// The wheel turns back for less than a millisecond, far within a step of a series of high order.
TEST(TurningWheel, PassesItsRestByEveryMethod) {
  constexpr double angle = 2.277994142, rate = 11.234587586;  // test/reference/sticking/turning_wheel.py
  for (const char* method : {"auto", "taylor", "dop853", "dopri5", "rodas5p", "radau13"}) {
    for (const double tolerance : {1e-8, 1e-10}) {
      for (const int rows : {3, 30}) {
        SCOPED_TRACE(std::string(method) + ", " + std::to_string(rows) + " rows");
        Scene scene = test::referenceScene("sticking/turning_wheel.yaml");
        scene.integrator.method = method;
        scene.integrator.tolerance = tolerance;
        Simulation simulation(scene);
        for (int k = 1; k <= rows; ++k) EXPECT_TRUE(simulation.advanceTo(0.3 * k / rows));
        EXPECT_NEAR(simulation.q()[0], angle, 1e-8);
        EXPECT_NEAR(simulation.qd()[0], rate, 1e-6);
      }
    }
  }
}

/// A cart comes to rest at the last bit of a step: at 0.1 + 0.1 + 0.1, where a row is at 0.3. What moves
/// beside it moves on as before.
TEST(Switch, AtTheEndOfAStepOfOneBitChangesNothingElse) {
  for (const char* method : {"auto", "dopri5", "radau13", "rodas5p", "rk4"}) {
    for (const double tolerance : {1e-4, 1e-8, 1e-12}) {
      SCOPED_TRACE(std::string(method) + " to " + std::to_string(tolerance));
      Scene scene = readSceneText(
          "chain: [cart, y, wheel]\ngravity: [0, 0]\nlinks:\n"
          "  cart: {mass: 0, joint: {type: prismatic, friction: 5}}\n"
          "  y: {mass: 0.5, joint: {type: prismatic, axis: [0, 1]}, initial: {velocity: 1}}\n"
          "  wheel: {mass: 0.5, inertia: 0.02, com: [0, 0], pin: [0.5, 0], initial: {velocity: 2}}\n");
      scene.integrator.method = method;
      scene.integrator.tolerance = tolerance;
      scene.integrator.step = 1e-3;
      Simulation simulation(scene, 2);
      simulation.addTorque(0, 15, 0.1, 0.1);
      simulation.addTorque(0, -5, 0.1, 0.2);
      for (int k = 1; k <= 10; ++k) EXPECT_TRUE(simulation.advanceTo(k / 10.0)) << simulation.fault();
      const double exact[] = {0.1, 1, 2};
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(simulation.q()[i], exact[i], 1e-11);
    }
  }
}

// What holds a slide although its torque is a little larger counts the reach, as the tolerance does.
TEST(Sticking, OfASlideMissesAShareOfTheReach) {
  for (const char* method : {"auto", "radau13"}) {
    Scene scene = readSceneText(
        "{gravity: [0, 0], chain: [cart, arm], links: {"
        "cart: {mass: 1, joint: {type: prismatic, friction: 1}},"
        " arm: {mass: 1.0e-9, inertia: 0, com: [1.0e-3, 0], pin: [1.0e-3, 0], initial: {angle: "
        "1.57079632679}}},"
        " loads: {push: {joint: cart_joint, torque: 1.00000000009}}}");
    scene.integrator.method = method;
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(10)) << simulation.fault();
    EXPECT_NEAR(simulation.q()[0], 4.5e-9, 1e-10) << method;
  }
}

/// The angles at the end of a run with these rows.
std::vector<double> at(const std::vector<double>& rows, Scene scene, const char* method, double tolerance) {
  scene.integrator = {};
  scene.integrator.method = method;
  scene.integrator.tolerance = tolerance;
  Simulation simulation(scene);
  for (const double t : rows) EXPECT_TRUE(simulation.advanceTo(t)) << simulation.fault();
  return simulation.q();
}

std::vector<double> evenly(double step, int count) {
  std::vector<double> rows;
  for (int k = 1; k <= count; ++k) rows.push_back(k * step);
  return rows;
}

/// Joints of closed chains that come to rest and go back at once. A step of 1e-13 s, by the places that its
/// projection gave it, showed a rest that was none: the joint stuck for ever, under 100 times its friction.
TEST(Sticking, IsPassedInAClosedChain) {
  const struct {
    const char *scene, *method;
    double tolerance;
    std::vector<double> rows;
  } runs[] = {{"passes_rest", "auto", 1e-8, evenly(0.01, 30)},
              {"passes_rest_with_motors",
               "dop853",
               1e-5,
               {0.0292213703854296, 0.05713748388244, 0.49055944217087455}},
              {"passes_rest_on_a_line", "ros34pw2", 1e-7, {0.5}},
              {"turns_back_alone", "dop853", 1e-4, {0.98}}};
  for (const auto& run : runs) {
    const Scene scene = test::referenceScene(std::string("sticking/") + run.scene + ".yaml");
    const std::vector<double> found = at(run.rows, scene, run.method, run.tolerance),
                              exact = at({run.rows.back()}, scene, "radau13", 1e-11);
    for (std::size_t i = 0; i < exact.size(); ++i)
      EXPECT_NEAR(found[i], exact[i], run.tolerance) << run.scene << ", joint " << i;
  }
}

// A joint comes to rest with an error in its rate, as coarse tolerances leave one. Either it sticks and the
// others follow, or it slides as it moves.
TEST(Sticking, LeavesNothingDueInAClosedChain) {
  const Scene scene = test::referenceScene("sticking/passes_rest.yaml");
  const int n = scene.chain.size();
  const Coordinates coordinates = scene.chain.coordinates();
  Dynamics dynamics(scene);
  std::vector<double> q = scene.q, drift(3, 0), rates{0, 1, 0};
  closeState(scene, 0, q, drift);
  closeState(scene, 0, q, rates);
  const auto stateWith = [&](double rate) {
    std::vector<double> qd = drift;
    for (std::size_t i = 0; i < 3; ++i)
      qd[i] += (rate - drift[1]) / (rates[1] - drift[1]) * (rates[i] - drift[i]);
    Eigen::VectorXd y = Eigen::VectorXd::Zero(dynamics.size());
    coordinates.toAbsolute(q.data(), y.data());
    coordinates.toAbsolute(qd.data(), y.data() + n);
    return y;
  };
  const auto largestEvent = [&](const Eigen::VectorXd& y) {
    double largest = ode::never;
    for (const ode::EventFunctions* events : dynamics.effects().events()) {
      Eigen::VectorXd g = Eigen::VectorXd::Constant(events->most(), ode::never);
      events->values(0, y.data(), g.data());
      largest = std::max(largest, g.maxCoeff());
    }
    return largest;
  };
  for (const double rate : {-1e-5, 1e-5}) {
    dynamics.enter(0);
    dynamics.enterState(0, stateWith(-rate).data());
    Eigen::VectorXd y = stateWith(rate);
    ASSERT_GT(largestEvent(y), 0);
    dynamics.fire(0, y.data());
    EXPECT_LE(largestEvent(y), 0) << rate;
    ode::State state(dynamics, y);
    ASSERT_TRUE(dynamics.project(state, state));
    EXPECT_LT((state.restoredBy(dynamics) - y).cwiseAbs().maxCoeff(), 1e-13) << rate;
  }
}

/// A cart that drags two rods along, the last on a line, in units of L m and T s.
std::vector<double> closedMotion(double L, double T) {
  const std::string l = toText(L), half = toText(L / 2), inertia = toText(L * L / 12);
  const std::string rod = ": {mass: 1, inertia: " + inertia + ", com: [" + half + ", 0], pin: [" + l + ", 0]";
  Scene scene = readSceneText(
      "{gravity: [0, " + toText(-9.81 * L / (T * T)) + "], chain: [cart, a, b], links: {" +
      "cart: {mass: 2, joint: {type: prismatic, friction: " + toText(0.1 * L / (T * T)) +
      ", breakaway: " + toText(100 * L / (T * T)) + "}, initial: {velocity: " + toText(0.05 * L / T) +
      "}}, a" + rod + ", initial: {angle: -1.2}}, b" + rod + "}}, tip: {line: {point: [0, " +
      toText(-1.5 * L) + "], direction: [1, 0]}}}");
  scene.integrator.tolerance = 1e-12;
  Simulation simulation(scene);
  EXPECT_TRUE(simulation.advanceTo(T)) << simulation.fault();
  std::vector<double> q = simulation.q();
  q[0] /= L;
  return q;
}

TEST(Sticking, OfASlideInAClosedChainKnowsNoUnit) {
  const std::vector<double> expected = closedMotion(1, 1), found = closedMotion(1e-6, 1e4);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found[i], expected[i], 1e-9) << i;
}

}  // namespace
}  // namespace planar_chain
