/// Events that a caller watches: none is missed or found twice, times are exact, and a reset of the state in
/// a loop is a fresh start.

#include "planar_chain/events.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"

namespace planar_chain {
namespace {

using Numbers = std::vector<double>;

const std::vector<std::string> methods{"auto", "dopri5", "dop853", "taylor", "rodas5p", "radau13", "rk4"};

Scene sceneOf(const std::string& text, const std::string& method, double tolerance = 1e-12) {
  const std::string step = method == "rk4" ? ", step: 0.002" : "";
  return readSceneText(text + "\nintegrator: {method: " + method + ", tolerance: " + toText(tolerance) +
                       step + "}");
}

/// Falls along y.
const std::string ball =
    "chain: [ball]\nlinks: {ball: {mass: 1, pin: [0, 0], joint: {type: prismatic, axis: [0, 1]}, "
    "initial: {position: 1}}}";
/// q = cos 3t
const std::string spring =
    "chain: [block]\ngravity: [0, 0]\nlinks: {block: {mass: 1, pin: [0, 0], joint: {type: prismatic, axis: "
    "[1, 0], "
    "stiffness: 9}, initial: {position: 1}}}";
const std::string pendulum =
    "chain: [rod]\nlinks: {rod: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], initial: {angle: -0.3}}}";

/// Where q passes a value.
MotionEvent passing(double value, long long terminal = 0, int direction = 0) {
  return {[value](double, const Numbers& q, const Numbers&) { return q[0] - value; }, terminal, direction};
}

struct ByMethod : testing::TestWithParam<std::string> {};

/// A parabola, exact in every method. The state is set at once where g is 0, a little past it or just as the
/// event left it; no direction tells the fall from the rise.
TEST_P(ByMethod, ABallBouncesAsInItsClosedForm) {
  constexpr double g = 9.81;
  for (const double restitution : {1.0, 0.7}) {
    Simulation simulation(sceneOf(ball, GetParam()));
    double expected = std::sqrt(2 / g), speed = g * expected;
    for (int bounce = 0; bounce < 12; ++bounce) {
      FoundEvents found;
      ASSERT_TRUE(simulation.advanceTo(100, {passing(0, 1)}, found));
      ASSERT_EQ(found.terminal, 0u) << bounce;
      ASSERT_EQ(found.all.size(), 1u);
      EXPECT_NEAR(simulation.time(), expected, 1e-13 * (1 + bounce)) << bounce;
      EXPECT_EQ(found.all[0].t, simulation.time());
      EXPECT_EQ(found.all[0].q, simulation.q());
      EXPECT_EQ(found.all[0].qd, simulation.qd());
      EXPECT_LE(std::abs(simulation.q()[0]), 1e-14);
      EXPECT_NEAR(simulation.qd()[0], -speed, 1e-12 * (1 + bounce));
      speed *= restitution;
      simulation.setState(bounce % 2 == 0 ? simulation.q() : Numbers{0}, {-restitution * simulation.qd()[0]});
      expected += 2 * speed / g;
    }
  }
}

/// Dips of 4e-4 s between the ends of steps, and everything else, over many periods.
TEST_P(ByMethod, NoneIsMissedBetweenTheSteps) {
  constexpr double end = 9;
  const double tolerance = GetParam() == "rk4" ? 1e-6 : 1e-9;
  for (const double value : {0.3, -0.99999991, 0.99999991, 1.1}) {
    std::vector<double> expected;
    for (int k = -1; k < 10 && std::abs(value) < 1; ++k) {
      for (const double side : {-1.0, 1.0}) {
        const double t = (2 * M_PI * k + side * std::acos(value)) / 3;
        if (t > 0 && t < end) expected.push_back(t);
      }
    }
    Simulation simulation(sceneOf(spring, GetParam()));
    FoundEvents found;
    for (const double row : {0.2, 4.0, end}) ASSERT_TRUE(simulation.advanceTo(row, {passing(value)}, found));
    ASSERT_EQ(found.all.size(), expected.size()) << value;
    const double slope = 3 * std::sqrt(std::abs(1 - value * value));
    for (std::size_t k = 0; k < expected.size(); ++k) {
      EXPECT_NEAR(found.all[k].t, expected[k], tolerance / slope) << value << ' ' << k;
      EXPECT_LE(std::abs(found.all[k].q[0] - value), 1e-14);
    }
  }
}

/// The step size and the error estimate behind an event at which the state is set are those of a simulation
/// that starts there.
TEST_P(ByMethod, SettingTheStateAtAnEventIsAFreshStart) {
  Simulation simulation(sceneOf(pendulum, GetParam(), 1e-9));
  FoundEvents found;
  ASSERT_TRUE(simulation.advanceTo(10, {passing(-1, 1)}, found));
  ASSERT_TRUE(found.terminal);
  simulation.setState(simulation.q(), {-0.8 * simulation.qd()[0]});
  Scene scene = sceneOf(pendulum, GetParam(), 1e-9);
  scene.q = simulation.q();
  scene.qd = simulation.qd();
  Simulation fresh(scene);
  const double begin = simulation.time();
  const Statistics before = simulation.statistics();
  for (const double t : {0.001, 0.01, 0.5}) {
    ASSERT_TRUE(simulation.advanceTo(begin + t));
    ASSERT_TRUE(fresh.advanceTo(t));
    EXPECT_NEAR(simulation.q()[0], fresh.q()[0], 1e-13);
    EXPECT_NEAR(simulation.qd()[0], fresh.qd()[0], 1e-13);
    EXPECT_EQ(simulation.statistics().steps - before.steps, fresh.statistics().steps);
    EXPECT_NEAR(simulation.statistics().localError, fresh.statistics().localError, 0.01);  // tolerances
  }
  EXPECT_LT(std::abs(simulation.energyBalance().residual), 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Events, ByMethod, testing::ValuesIn(methods));

TEST(Events, DirectionsAndNumbersCount) {
  Simulation simulation(sceneOf(spring, "auto"));
  FoundEvents found;
  // Zeros at (½ + k) π/3: it falls, rises, falls, …
  ASSERT_TRUE(
      simulation.advanceTo(100, {passing(0, 0, -1), passing(0), passing(0, 2, 1), passing(5, 1)}, found));
  EXPECT_EQ(found.terminal, 2u);
  EXPECT_NEAR(simulation.time(), 3.5 * M_PI / 3, 1e-11);
  std::string order;
  for (const FoundEvent& one : found.all) order += std::to_string(one.which);
  EXPECT_EQ(order,
            "01"
            "12"
            "01"
            "12");
  // Goes on behind it, and counts anew in what is found anew.
  FoundEvents next;
  ASSERT_TRUE(simulation.advanceTo(100, {passing(0, 1)}, next));
  EXPECT_NEAR(simulation.time(), 4.5 * M_PI / 3, 1e-11);
  // With what was found, numbers go on over several ways.
  FoundEvents all;
  double t = simulation.time();
  while (!all.terminal) ASSERT_TRUE(simulation.advanceTo(t += 0.1, {passing(0, 3)}, all));
  EXPECT_NEAR(simulation.time(), 7.5 * M_PI / 3, 1e-11);
}

TEST(Events, AZeroAtTheStartOrAtTheEndOfAWay) {
  Simulation simulation(sceneOf(spring, "auto"));
  FoundEvents found;
  const MotionEvent atRest{[](double, const Numbers&, const Numbers& qd) { return qd[0]; }};
  const MotionEvent atHalf{[](double t, const Numbers&, const Numbers&) { return t - 0.5; }};
  ASSERT_TRUE(simulation.advanceTo(0.5, {atRest, atHalf}, found));  // it starts at rest
  ASSERT_EQ(found.all.size(), 1u);
  EXPECT_EQ(found.all[0].t, 0.5);
  ASSERT_TRUE(simulation.advanceTo(1, {atRest, atHalf}, found));
  EXPECT_EQ(found.all.size(), 1u);
  ASSERT_TRUE(simulation.advanceTo(1.1, {atRest, atHalf}, found));
  ASSERT_EQ(found.all.size(), 2u);
  EXPECT_NEAR(found.all[1].t, M_PI / 3, 1e-10);
  found = {};
  ASSERT_TRUE(simulation.advanceTo(1.1, {atRest}, found));  // no way
  EXPECT_TRUE(found.all.empty());
}

/// Friction, stops, a drive, a held tip, sensors: the scene's own events and those of the caller.
TEST(Events, AmongTheEventsOfTheScene) {
  const std::string slides =
      "chain: [block]\ngravity: [0, -10]\nlinks: {block: {mass: 1, pin: [0, 0], joint: {type: prismatic, "
      "axis: [1, 0], "
      "friction: 2, upper: 0.64, lower: -9}, initial: {velocity: 2}}}";
  const MotionEvent atRest{[](double, const Numbers&, const Numbers& qd) { return qd[0]; }};
  for (const char* method : {"auto", "dopri5", "rodas5p"}) {
    // q = 2t − t² to its stop, and back; then it sticks.
    Simulation simulation(sceneOf(slides, method));
    FoundEvents found;
    ASSERT_TRUE(simulation.advanceTo(5, {atRest, passing(0.63)}, found));
    std::string order;
    for (const FoundEvent& one : found.all) order += std::to_string(one.which);
    EXPECT_EQ(order, "1010") << method;  // in, turns, out, sticks
    EXPECT_NEAR(found.all[0].t, 1 - std::sqrt(0.37), 1e-11);
    EXPECT_EQ(simulation.qd()[0], 0);
  }
  const std::string driven =
      "chain: [a, b]\nlinks:\n  a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {drive: "
      "{amplitude: 0.5, "
      "frequency: 1}}}\n  b: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]}";
  Simulation simulation(sceneOf(driven, "auto", 1e-6));
  FoundEvents found;
  ASSERT_TRUE(simulation.advanceTo(3, {passing(0.25)}, found));
  ASSERT_EQ(found.all.size(), 6u);
  for (int k = 0; k < 6; ++k) {
    const double expected = k / 2 + (k % 2 == 0 ? 1. / 12 : 5. / 12);
    EXPECT_NEAR(found.all[static_cast<std::size_t>(k)].t, expected, 1e-14);
  }
}

TEST(Events, ATipThatIsHeldAndAMotionOfManyTurns) {
  std::ostringstream text;
  text << std::ifstream(SCENES_DIR "/four_bar.yaml").rdbuf();
  Simulation closed(readSceneText(text.str()));
  const double start = closed.q()[0];
  FoundEvents found;
  ASSERT_TRUE(closed.advanceTo(3, {passing(start + 0.01)}, found));
  ASSERT_FALSE(found.all.empty());
  for (const FoundEvent& one : found.all) EXPECT_LE(std::abs(one.q[0] - start - 0.01), 1e-13);

  // 1e4 rad/s: whole turns are taken off the state, and counted.
  Simulation spinning(
      readSceneText("chain: [rod]\ngravity: [0, 0]\nlinks: {rod: {mass: 1, inertia: 0.1, com: [0.5, 0], "
                    "pin: [1, 0], initial: {velocity: 10000}}}"));
  found = {};
  ASSERT_TRUE(spinning.advanceTo(1, {passing(500), passing(7777, 1), passing(5000)}, found));
  ASSERT_EQ(found.all.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    const double value[] = {500, 5000, 7777};
    EXPECT_NEAR(found.all[k].t, value[k] / 1e4, 1e-12);
    EXPECT_NEAR(found.all[k].q[0], value[k], 1e-11);
  }
}

TEST(Events, TheMotionDoesNotDependOnThem) {
  for (const std::string& method : methods) {
    Simulation with(sceneOf(pendulum, method, 1e-8)), without(sceneOf(pendulum, method, 1e-8));
    FoundEvents found;
    for (const double t : {1.0, 2.5, 6.0}) {
      ASSERT_TRUE(with.advanceTo(t, {passing(-1), passing(-2, 0, 1)}, found));
      ASSERT_TRUE(without.advanceTo(t));
      EXPECT_NEAR(with.q()[0], without.q()[0], 1e-7);
      EXPECT_EQ(with.statistics().steps, without.statistics().steps) << method;
    }
    EXPECT_GT(found.all.size(), 3u);
  }
}

TEST(Events, ASavedStateGoesOnBehindItsEvent) {
  Simulation simulation(sceneOf(spring, "dop853"));
  FoundEvents found, again;
  ASSERT_TRUE(simulation.advanceTo(9, {passing(0, 1)}, found));
  Simulation other(sceneOf(spring, "dop853"));
  other.restore(simulation.save());
  for (Simulation* its : {&simulation, &other}) {
    // A reset without a way: what was just below 0 rises from there.
    its->setState(its->q(), {0.05});
    again = {};
    ASSERT_TRUE(its->advanceTo(9, {passing(0, 1)}, again));
    EXPECT_NEAR(its->time(), M_PI / 6 + M_PI / 3, 1e-11);
  }
  EXPECT_EQ(simulation.q(), other.q());
}

TEST(Events, WhatCannotBeWatchedIsRefused) {
  Simulation simulation(sceneOf(spring, "auto"));
  FoundEvents found;
  const auto refusal = [&](MotionEvent event) {
    try {
      simulation.advanceTo(1, {passing(0), std::move(event)}, found);
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_EQ(refusal({}), "events/1: expected a function g(t, q, qd), got none");
  EXPECT_EQ(refusal({passing(0).g, -1}), "events/1/terminal: expected a number >= 0, got -1");
  EXPECT_EQ(simulation.time(), 0);
  const auto nan = [](double, const Numbers& q, const Numbers&) { return std::sqrt(q[0] - 0.9); };
  EXPECT_EQ(refusal({nan}).find("events/1: expected a finite number at t = 0."), 0u);
  const auto throws = [](double t, const Numbers&, const Numbers&) -> double {
    if (t > 0.3) throw std::runtime_error("that is enough");
    return 1;
  };
  EXPECT_EQ(refusal({throws}), "that is enough");
  // The state is that of a step's end, and goes on.
  EXPECT_NEAR(simulation.q()[0], std::cos(3 * simulation.time()), 1e-10);
  EXPECT_TRUE(simulation.advanceTo(1));
  EXPECT_NEAR(simulation.q()[0], std::cos(3.0), 1e-10);
}

}  // namespace
}  // namespace planar_chain
