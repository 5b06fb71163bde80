/// A tolerance that changes on the way, and the node's rule for it.

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>

#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "ros/messages/rests.h"
#include "ros/node/tolerance_control.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

/// Ticks of 10 ms to 1 s; the tolerance changes at ticks 30 and 60.
void runWithChanges(Simulation& simulation) {
  for (int k = 1; k <= 100; ++k) {
    if (k == 30) simulation.setTolerance(1e-3);
    if (k == 60) simulation.setTolerance(1e-6);
    ASSERT_TRUE(simulation.advanceTo(0.01 * k)) << simulation.fault();
  }
}

TEST(Tolerance, ThatChangesOnTheWayGivesTheSameBitsAgain) {
  for (const std::string& method : ode::methodNames()) {
    Scene scene = test::randomScene(5, 1);
    scene.integrator = {method, 1e-8, 1e-3};
    Simulation first(scene), second(scene), tight(scene);
    runWithChanges(first);
    runWithChanges(second);
    EXPECT_EQ(first.q(), second.q()) << method;
    ASSERT_TRUE(tight.advanceTo(1));
    const bool isFixed = ode::hasFixedStep(method);
    EXPECT_EQ(first.tolerance(), isFixed ? 0 : 1e-6) << method;
    for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(first.q()[i], tight.q()[i], 0.01) << method;
    first.reset();
    EXPECT_EQ(first.tolerance(), isFixed ? 0 : 1e-8) << method;
    runWithChanges(first);
    EXPECT_EQ(first.q(), second.q()) << method << ", after a reset";
  }
}

TEST(Tolerance, TakesTheRateToleranceAlong) {
  Scene scene = test::randomScene(3, 1);
  scene.integrator.rateTolerance = 1e-6;
  Simulation simulation(scene);
  simulation.setTolerance(1e-4);
  EXPECT_DOUBLE_EQ(*simulation.scene().integrator.rateTolerance, 1e-2);
  EXPECT_THROW(simulation.setTolerance(2), std::invalid_argument);
  EXPECT_THROW(simulation.setTolerance(std::nan("")), std::invalid_argument);
  EXPECT_EQ(simulation.tolerance(), 1e-4);
}

/// A pole of so many times 3 kg on a driven slide.
Simulation onADrivenSlide(double times) {
  const auto scaled = [=](double value) { return std::to_string(times * value); };
  return Simulation(
      readSceneText("chain: [slide, pole]\nlinks:\n"
                    "  slide: {mass: " +
                    scaled(1) +
                    ", pin: [0, 0], joint: {type: prismatic, axis: [1, 0],\n"
                    "          drive: {times: [0.5, 0.7, 1], values: [0, -0.5, 0.2]}}}\n"
                    "  pole: {mass: " +
                    scaled(3) + ", inertia: " + scaled(0.25) +
                    ", com: [0.5, 0], pin: [1, 0],\n"
                    "         joint: {damping: " +
                    scaled(0.125) +
                    "}, initial: {angle: 1}}\n"
                    "integrator: {tolerance: 1e-9}\n"));
}

// The work of the drive, which begins at 0, asked for its error in J: a machine in g and mm took ten times
// the steps, one of 1e16 kg none.
TEST(Tolerance, IsTheSameInAllUnitsOfMass) {
  Simulation light = onADrivenSlide(1), heavy = onADrivenSlide(std::ldexp(1, 40));
  ASSERT_TRUE(light.advanceTo(1)) << light.fault();
  ASSERT_TRUE(heavy.advanceTo(1)) << heavy.fault();
  EXPECT_EQ(light.q(), heavy.q());
  EXPECT_EQ(light.statistics().steps, heavy.statistics().steps);
}

constexpr double period = 0.005;  // s

TEST(ToleranceControl, YieldsByTensWhileTicksAreLate) {
  ToleranceControl control(1e-6, 5e-4);
  EXPECT_EQ(control.after(3, 0.005, period), 1e-6) << "late by less than the operating system may take";
  EXPECT_EQ(control.after(0.5, 0.02, period), 1e-6) << "late, but faster than the clock";
  EXPECT_DOUBLE_EQ(control.after(3, 0.02, period), 1e-5);
  EXPECT_DOUBLE_EQ(control.after(3, 0.03, period), 1e-4);
  EXPECT_EQ(control.after(3, 0.04, period), 5e-4);
  EXPECT_EQ(control.after(3, 0.05, period), 5e-4) << "the loosest";
}

/// s of ticks in time of this load until the tolerance changes; 100 if it does not.
double timeUntilChange(ToleranceControl& control, double load) {
  const double before = control.after(load, -0.001, period);
  for (int k = 1; k < 20000; ++k) {
    if (control.after(load, -0.001, period) != before) return k * period;
  }
  return 100;
}

TEST(ToleranceControl, ComesBackWhenThereIsTimeAndLaterAfterAFailure) {
  ToleranceControl control(1e-6, 1e-2);
  control.after(3, 0.02, period);
  EXPECT_EQ(timeUntilChange(control, 0.5), 100) << "ten times tighter might be too much";
  EXPECT_LT(timeUntilChange(control, 0.1), 100);
  EXPECT_EQ(timeUntilChange(control, 0.1), 100) << "it is as wanted";
  control.after(3, 0.02, period);
  EXPECT_NEAR(timeUntilChange(control, 0.1), 1, 2 * period);
  control.after(3, 0.02, period);
  EXPECT_NEAR(timeUntilChange(control, 0.1), 2, 2 * period) << "it came back too early";
}

TEST(Advice, NamesWhatHelps) {
  IntegratorSettings settings{"auto", 1e-8, 1e-3};
  EXPECT_EQ(adviceFor(settings, 1e-8, 4, 20, period, 200),
            "a tick of 5 ms takes 20 ms, with 20 steps: a tolerance of about 1e-05 would help; with "
            "integrator/loosest_tolerance it yields to that only while it must");
  IntegratorSettings yielding = settings;
  yielding.loosestTolerance = 1e-4;
  EXPECT_NE(adviceFor(yielding, 1e-4, 2, 20, period, 200).find("integrator/loosest_tolerance of about 3e-03"),
            std::string::npos);
  EXPECT_NE(adviceFor(yielding, 1e-4, 0.9, 20, period, 200).find("it catches up"), std::string::npos);
  EXPECT_NE(adviceFor(settings, 1e-8, 0.4, 1, period, 200).find("it catches up"), std::string::npos);
  settings.rateTolerance = 1e-8;
  EXPECT_NE(adviceFor(settings, 1e-8, 4, 20, period, 200).find("would help, or a larger rate_tolerance;"),
            std::string::npos);
  EXPECT_EQ(adviceFor(settings, 1e-8, 4, 1, period, 200),
            "a tick of 5 ms takes 20 ms, with 1 step: publish/rate of at most 50 Hz would help");
  EXPECT_NE(adviceFor(settings, 1e-8, 100, 20, period, 200).find("no tolerance is loose enough"),
            std::string::npos);
  EXPECT_NE(
      adviceFor({"rk4", 1e-8, 1e-3}, 1e-8, 4, 5, period, 200).find("integrator/step of at least 0.004 s"),
      std::string::npos);
}

/// However fast messages come, so many take so much time.
TEST(Rests, LeaveTheRecorderItsTime) {
  Rests rests(40, 0.02);
  const auto begin = std::chrono::steady_clock::now();
  for (int k = 0; k < 201; ++k) rests.waitForOne();
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 5 * std::chrono::milliseconds(20));

  Rests few(2, 1000);
  EXPECT_TRUE(few.allowOne());
  EXPECT_TRUE(few.allowOne());
  EXPECT_FALSE(few.allowOne());
}

}  // namespace
}  // namespace planar_chain
