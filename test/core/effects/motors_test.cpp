/// Motors and dead times of commands: motions in closed form by every method, the laws of effects, stability
/// of a loop, and the same bits again.

#include "effects/motors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <tuple>
#include <vector>

#include "effect_laws.h"
#include "ode/methods.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "simd/elementary.h"

namespace planar_chain {
namespace {

constexpr double forever = std::numeric_limits<double>::infinity();

/// A flywheel of J = 0.5 kg m² without gravity.
constexpr double J = 0.5, L = 2, w0 = 8, T = 0.05;
Scene flywheel(const std::string& joint, const std::string& method = "auto", double velocity = 0) {
  return readSceneText(
      "chain: [wheel]\n"
      "gravity: [0, 0]\n"
      "links:\n"
      "  wheel: {mass: 1, inertia: 0.5, com: [0, 0], pin: [1, 0], joint: {" +
      joint + "}, initial: {velocity: " + std::to_string(velocity) +
      "}}\n"
      "integrator: {method: " +
      method + ", tolerance: 1e-10, step: 0.001}\n");
}

/// q and q̇ of the free wheel after a step of u at 0: J q̈ = x, T ẋ = u − x.
std::pair<double, double> afterStep(double u, double t) {
  if (t <= 0) return {0, 0};
  const double rest = 1 - std::exp(-t / T);
  return {u / J * (t * t / 2 - T * t + T * T * rest), u / J * (t - T * rest)};
}

class ByEveryMethod : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Motors, ByEveryMethod, testing::ValuesIn(ode::methodNames()));

TEST_P(ByEveryMethod, TheLagIsThatOfTheFormula) {
  Simulation simulation(flywheel("motor: {time_constant: 0.05}", GetParam()), 4);
  simulation.holdTorque(0, 3, forever);
  ASSERT_TRUE(simulation.advanceTo(0.3)) << simulation.fault();
  simulation.holdTorque(0, -1, forever);
  for (const double t : {0.33, 0.9}) {
    ASSERT_TRUE(simulation.advanceTo(t)) << simulation.fault();
    const auto [q1, qd1] = afterStep(3, t);
    const auto [q2, qd2] = afterStep(-4, t - 0.3);
    EXPECT_NEAR(simulation.q()[0], q1 + q2, 1e-7) << t;
    EXPECT_NEAR(simulation.qd()[0], qd1 + qd2, 1e-7) << t;
    // The lag itself is exact, whatever the method.
    double effort = 0;
    simulation.jointTorques(&effort);
    const double x1 = 3 * (1 - std::exp(-t / T)), x2 = -4 * (1 - std::exp(-(t - 0.3) / T));
    EXPECT_NEAR(effort, x1 + x2, 1e-14) << t;
  }
  EXPECT_NEAR(simulation.energyBalance().residual, 0, 1e-7);
  EXPECT_NEAR(simulation.energyBalance().supplied, simulation.energy().kinetic, 1e-7);
}

TEST_P(ByEveryMethod, TheLineEndsAtTheNoLoadSpeed) {
  // J q̈ = L (1 − q̇/ω_0)
  Simulation simulation(flywheel("effort_limit: 2, motor: {no_load_speed: 8}", GetParam()), 4);
  simulation.holdTorque(0, -50, forever);
  for (const double t : {0.5, 3.0, 100.0}) {
    ASSERT_TRUE(simulation.advanceTo(t)) << simulation.fault();
    const double rate = w0 * (1 - std::exp(-t * L / (J * w0)));
    EXPECT_NEAR(simulation.qd()[0], -rate, 1e-6) << t;
    double effort = 0;
    simulation.jointTorques(&effort);
    EXPECT_NEAR(effort, -L * (1 - rate / w0), 1e-6) << t;
  }
  EXPECT_NEAR(simulation.energyBalance().residual, 0, 1e-5);
  EXPECT_EQ(simulation.cutOffs()[0], 1);  // at −L; the line does not count
}

TEST_P(ByEveryMethod, TheLineBeginsWhereTheLagReachesIt) {
  const std::string joint = "effort_limit: 2, motor: {no_load_speed: 0.8, time_constant: 0.05}";
  constexpr double slow = 0.8;
  // x = L (1 − q̇/ω_0) at t*, by bisection; exponential from there on.
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double t = (low + high) / 2, x = L * (1 - std::exp(-t / T));
    (x < L * (1 - afterStep(L, t).second / slow) ? low : high) = t;
  }
  const double rest = 1 - afterStep(L, low).second / slow;
  Simulation simulation(flywheel(joint, GetParam()), 4);
  simulation.holdTorque(0, L, forever);
  for (const double t : {0.9 * low, 1.1 * low, 0.5}) {
    ASSERT_TRUE(simulation.advanceTo(t)) << simulation.fault();
    const double rate =
        t < low ? afterStep(L, t).second : slow * (1 - rest * std::exp(-(t - low) * L / (J * slow)));
    EXPECT_NEAR(simulation.qd()[0], rate, 1e-7) << t;
  }
  EXPECT_NEAR(simulation.energyBalance().residual, 0, 1e-6);
}

TEST_P(ByEveryMethod, FasterThanTheNoLoadSpeedItIdles) {
  // q̇ = 3 ω_0 exp(−d t/J) down to ω_0; then J q̈ = L − (L/ω_0 + d) q̇. A torque against the motion brakes
  // fully.
  constexpr double d = 0.2;
  const std::string joint = "damping: 0.2, effort_limit: 2, motor: {no_load_speed: 8}";
  const double reached = J / d * std::log(3.0), c = L / w0 + d, end = L / c;
  Simulation simulation(flywheel(joint, GetParam(), 3 * w0), 4);
  simulation.holdTorque(0, L, forever);
  ASSERT_TRUE(simulation.advanceTo(reached - 0.5)) << simulation.fault();
  EXPECT_NEAR(simulation.qd()[0], 3 * w0 * std::exp(-d * (reached - 0.5) / J), 1e-6);
  ASSERT_TRUE(simulation.advanceTo(reached + 1)) << simulation.fault();
  EXPECT_NEAR(simulation.qd()[0], end + (w0 - end) * std::exp(-c / J), 1e-6);
  simulation.holdTorque(0, -L, forever);
  double effort = 0;
  simulation.jointTorques(&effort);
  EXPECT_NEAR(effort, -L - d * simulation.qd()[0], 1e-12);
  EXPECT_NEAR(simulation.energyBalance().residual, 0, 1e-5);
}

TEST_P(ByEveryMethod, MovesAChainAlike) {
  const auto scene = [](const std::string& method) {
    return readSceneText(
        "chain: [a, b]\n"
        "links:\n"
        "  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0],\n"
        "      joint: {effort_limit: 9, motor: {no_load_speed: 3, time_constant: 0.02}, command_delay: "
        "0.004}}\n"
        "  b: {mass: 0.5, inertia: 0.05, com: [0.3, 0], pin: [0.6, 0.1],\n"
        "      joint: {damping: 0.02, effort_limit: 2, motor: {no_load_speed: 5}}}\n"
        "integrator: {method: " +
        method + ", tolerance: 1e-10, step: 0.0005}\n");
  };
  const auto motion = [&](const std::string& method) {
    Simulation simulation(scene(method), 4);
    for (int k = 0; k < 40; ++k) {
      simulation.holdTorque(0, 12 * std::sin(0.4 * k), forever);
      simulation.holdTorque(1, 3 * std::cos(0.3 * k), forever);
      EXPECT_TRUE(simulation.advanceTo((k + 1) * 0.05)) << simulation.fault();
    }
    EXPECT_NEAR(simulation.energyBalance().residual, 0, 1e-4);
    return simulation.q();
  };
  const std::vector<double> reference = motion("dop853"), own = motion(GetParam());
  for (std::size_t i = 0; i < own.size(); ++i) EXPECT_NEAR(own[i], reference[i], 2e-5) << i;
}

// ---- Cut off -------------------------------------------------------------------------------------

/// Two links, the outer of which has a limit of 2 N m, after half a second under this torque.
std::vector<double> underTorque(double torque, const char* motor) {
  const Scene scene = readSceneText(
      "chain: [a, b]\nlinks:\n  a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]}\n"
      "  b: {mass: 0.7, inertia: 0.03, com: [0.25, 0], pin: [0.5, 0], joint: {effort_limit: 2" +
      std::string(motor) + "}}\n");
  Simulation simulation(scene, 4);
  simulation.holdTorque(1, torque, forever);
  simulation.addTorque(1, torque / 4, 0.2, 0.3);
  EXPECT_TRUE(simulation.advanceTo(0.5)) << torque << ": " << simulation.fault();
  EXPECT_LE(std::abs(simulation.energyBalance().residual), 1e-8) << torque;
  return simulation.q();
}

TEST(Commands, ThatAreCutOffMoveTheChainAsTheirLimitDoes) {
  for (const char* motor : {"", ", motor: {time_constant: 0.01}"}) {
    const std::vector<double> expected = underTorque(3, motor);
    for (const double torque : {1e3, 1e15, 1e100}) EXPECT_EQ(underTorque(torque, motor), expected);
  }
}

TEST(Commands, ThatCancelAreNoneHoweverLarge) {
  const Scene scene = readSceneText(
      "chain: [a]\nlinks: {a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {effort_limit: "
      "2}}}\n");
  Simulation simulation(scene, 4);
  constexpr double huge = 1e100;  // the largest that is accepted
  for (const double torque : {huge, huge, -huge, -huge}) simulation.addTorque(0, torque, 1);
  simulation.holdTorque(0, 1, forever);
  const std::vector<Load> commands = simulation.commands();
  EXPECT_TRUE(
      std::none_of(commands.begin(), commands.end(), [](const Load& one) { return one.name == "limit"; }));
  EXPECT_EQ(simulation.cutOffs()[0], 0);
}

// ---- Dead time -----------------------------------------------------------------------------------

TEST(DeadTime, IsExact) {
  Simulation simulation(flywheel("command_delay: 0.037"), 4);
  ASSERT_TRUE(simulation.advanceTo(0.1));
  simulation.holdTorque(0, 2, forever);
  ASSERT_TRUE(simulation.advanceTo(0.1 + 0.037));
  EXPECT_EQ(simulation.qd()[0], 0);
  double effort = 0;
  simulation.jointTorques(&effort);
  EXPECT_EQ(effort, 2);
  ASSERT_TRUE(simulation.advanceTo(1));
  EXPECT_NEAR(simulation.qd()[0], 2 / J * (1 - 0.137), 1e-12);
}

TEST(DeadTime, HasRoomForEveryCommandThatIsUnderWay) {
  // A command a millisecond for a dead time of 0.3 s, with room for one: ∫ τ is that of the commands before.
  Simulation simulation(flywheel("command_delay: 0.3"), 1);
  double impulse = 0;
  for (int k = 0; k < 1000; ++k) {
    const double torque = std::sin(0.01 * k);
    ASSERT_TRUE(simulation.holdTorque(0, -5, forever));  // replaced at once
    ASSERT_TRUE(simulation.holdTorque(0, torque, forever));
    if (k < 700) impulse += 1e-3 * torque;
    ASSERT_TRUE(simulation.advanceTo((k + 1) * 1e-3));
  }
  EXPECT_NEAR(simulation.qd()[0], impulse / J, 1e-11);
}

TEST(DeadTime, MovesTheEndOfACommandAsWell) {
  Simulation simulation(flywheel("command_delay: 0.2"), 4);
  simulation.addTorque(0, 3, 0.1);
  simulation.holdTorque(0, 1, 0.5, 0.4);  // from 0.6 to 0.7
  ASSERT_TRUE(simulation.advanceTo(0.5));
  EXPECT_NEAR(simulation.qd()[0], 0.3 / J, 1e-12);
  ASSERT_TRUE(simulation.advanceTo(2));
  EXPECT_NEAR(simulation.qd()[0], 0.4 / J, 1e-12);
}

TEST(DeadTime, EndsWithTheCommandsThatAreCleared) {
  Simulation simulation(flywheel("command_delay: 0.2"), 4);
  simulation.holdTorque(0, 1, forever);
  simulation.clearCommands();
  ASSERT_TRUE(simulation.advanceTo(1));
  EXPECT_EQ(simulation.qd()[0], 0);
}

// ---- The state of a motor --------------------------------------------------------------------------

TEST(AMotor, StartsAnewAfterAResetAndGivesTheSameBits) {
  Simulation simulation(flywheel("effort_limit: 2, motor: {no_load_speed: 0.8, time_constant: 0.05}, "
                                 "command_delay: 0.01"),
                        4);
  const auto run = [&] {
    std::vector<double> states;
    for (int k = 0; k < 100; ++k) {
      simulation.holdTorque(0, 3 * std::sin(0.2 * k), forever);
      EXPECT_TRUE(simulation.advanceTo((k + 1) * 0.01));
      states.push_back(simulation.q()[0]);
      states.push_back(simulation.qd()[0]);
    }
    return states;
  };
  const std::vector<double> first = run();
  simulation.reset();
  double effort = 1;
  simulation.jointTorques(&effort);
  EXPECT_EQ(effort, 0);
  const std::vector<double> second = run();
  EXPECT_EQ(0, std::memcmp(first.data(), second.data(), first.size() * sizeof(double)));
}

TEST(AMotor, KeepsItsTorqueWhenAStateIsSetAndHasFinishedAtRest) {
  Simulation simulation(flywheel("stiffness: 4, motor: {time_constant: 0.05}"), 4);
  simulation.holdTorque(0, 1, forever);
  ASSERT_TRUE(simulation.advanceTo(0.05));
  simulation.setState({0}, {0});
  double effort = 0;
  simulation.jointTorques(&effort);
  EXPECT_NEAR(effort, 1 - std::exp(-1.0), 1e-14);
  simulation.settle();
  EXPECT_NEAR(simulation.q()[0], 0.25, 1e-9);
  ASSERT_TRUE(simulation.advanceTo(1));
  EXPECT_NEAR(simulation.q()[0], 0.25, 1e-9);
}

TEST(AMotor, TakesATorqueAndGoesOnFromThere) {
  Simulation simulation(flywheel("motor: {time_constant: 0.05}"), 4);
  simulation.holdTorque(0, 3, forever);
  simulation.setMotorTorques({3});
  EXPECT_EQ(simulation.motorTorques(), std::vector<double>{3});
  ASSERT_TRUE(simulation.advanceTo(0.1));
  EXPECT_NEAR(simulation.qd()[0], 0.1 * 3 / J, 1e-9);
  simulation.setMotorTorques({-1});  // J q̇ = ∫ 3 − 4 exp(−t/T)
  ASSERT_TRUE(simulation.advanceTo(0.2));
  EXPECT_NEAR(simulation.motorTorques()[0], 3 - 4 * std::exp(-2.0), 1e-14);
  EXPECT_NEAR(simulation.qd()[0], (0.2 * 3 - 4 * T * (1 - std::exp(-2.0))) / J, 1e-9);
}

TEST(AMotor, RefusesATorqueThatItCannotHave) {
  Simulation lagging(flywheel("effort_limit: 2, motor: {time_constant: 0.05}"), 1);
  Simulation prompt(flywheel("effort_limit: 2"), 1);
  prompt.holdTorque(0, 5, forever);
  EXPECT_EQ(prompt.motorTorques(), std::vector<double>{2});
  prompt.setMotorTorques({2 + 1e-9});  // as of holding torques
  const auto expectRefused = [](Simulation& simulation, double torque, const std::string& words) {
    try {
      simulation.setMotorTorques({torque});
      ADD_FAILURE() << torque;
    } catch (const Refused& refused) {
      EXPECT_EQ(refused.what(), words);
    }
  };
  expectRefused(lagging, -2.5, "motor_torques/0: expected a torque from -2 to 2 N m, got -2.5");
  expectRefused(prompt, 1, "motor_torques/0: expected 2 N m, as commanded: wheel_joint has no lag, got 1");
  EXPECT_THROW(lagging.setMotorTorques({1, 1}), std::invalid_argument);
  EXPECT_EQ(lagging.motorTorques(), std::vector<double>{0});
}

TEST(AMotor, IsAmongTheCommandsInForceWithTheTorqueThatActs) {
  Simulation simulation(flywheel("effort_limit: 2, motor: {no_load_speed: 8}", "auto", 4), 4);
  simulation.holdTorque(0, 5, forever);
  ASSERT_TRUE(simulation.advanceTo(1e-9));
  const std::vector<Load> commands = simulation.commands();
  ASSERT_EQ(commands.size(), 1u);
  EXPECT_NEAR(commands[0].torque, 1, 1e-8);
}

/// Routh and Hurwitz: J q̈ = x, T ẋ = u − x, u = −K q − D q̇ give J T s³ + J s² + D s + K = 0, which is stable
/// if J D > J T K: up to K = D/T. A controller that holds u for h delays it by τ = h/2 on average. With
/// exp(−τ s) = 1 − τ s the condition is (J − D τ)(D − K τ) > J T K: K is lower by τ/T + τ D/J, here 0.11 %.
TEST(AMotor, LosesStabilityAtTheGainOfTheory) {
  constexpr double h = 1e-4, D = 1, critical = D / T;
  // The rate of growth by q̇ at the first and the last zero of q after half a second.
  const auto growth = [&](double gain) {
    Scene scene = flywheel("motor: {time_constant: 0.05}");
    scene.q = {0.1};
    Simulation simulation(scene, 2);
    std::vector<double> times, rates;
    for (int k = 0; k < 40000; ++k) {
      const double before = simulation.q()[0], rate = simulation.qd()[0];
      simulation.holdTorque(0, -gain * before - D * rate, forever);
      EXPECT_TRUE(simulation.advanceTo((k + 1) * h));
      const double after = simulation.q()[0];
      if (k < 5000 || (before < 0) == (after < 0)) continue;
      const double part = before / (before - after);
      times.push_back((k + part) * h);
      rates.push_back(std::abs(rate + part * (simulation.qd()[0] - rate)));
    }
    return std::log(rates.back() / rates.front()) / (times.back() - times.front());
  };
  const double below = growth(0.99 * critical), above = growth(1.01 * critical);
  EXPECT_LT(below, 0);
  EXPECT_GT(above, 0);
  const double zero = 0.99 + 0.02 * below / (below - above);
  EXPECT_NEAR(zero, 1 - h / 2 * (1 / T + D / J), 1e-4);
}

TEST(AMotor, OfStrengthZeroGivesTheMotionOfNone) {
  const auto run = [](const std::string& joint) {
    Simulation simulation(flywheel("damping: 0.1, effort_limit: 2" + joint), 4);
    for (int k = 0; k < 50; ++k) {
      simulation.holdTorque(0, 3 * std::sin(0.2 * k), forever);
      EXPECT_TRUE(simulation.advanceTo((k + 1) * 0.01));
    }
    const Statistics made = simulation.statistics();
    return std::tuple(simulation.q()[0], simulation.qd()[0], made.steps, made.evaluations);
  };
  EXPECT_EQ(run(""), run(", motor: {time_constant: 0}, command_delay: 0"));
}

// ---- The laws ------------------------------------------------------------------------------------------

/// Motors with commands, as an effect of the scene, which has no commands. Acts where the first joint has a
/// motor.
class CommandedKind : public EffectKind {
 public:
  std::unique_ptr<Effect> make(const Scene& scene) const override {
    if (!isIn(scene)) return nullptr;
    auto effect = makeCommands(scene.chain, 4);
    for (int i = 0; i < scene.chain.size(); ++i)
      effect->hold({Load::none, {}, {}, 0, i, torqueIn(i), -1, forever}, 0);
    return effect;
  }
  static bool isIn(const Scene& scene) { return scene.chain.joints()[0].has("effort_limit"); }
  static double torqueIn(int i) { return i % 2 == 0 ? 1.5 : -0.7; }
  void addDense(const Scene& scene, double t, const Eigen::VectorXd& /*q*/, const Eigen::VectorXd& qd,
                const DenseActions& to) const override {
    for (int i = 0; i < scene.chain.size() && isIn(scene); ++i) {
      const Joint& joint = scene.chain.joints()[index(i)];
      const double u = torqueIn(i), side = u > 0 ? 1 : -1, lag = joint.other(timeConstant);
      const double x = lag > 0 ? u * (1 - std::exp(-t / lag)) : u;
      const double line = joint.other("effort_limit") * (1 - side * qd(i) / joint.other(noLoadSpeed));
      to.tau(i) += side * std::min(side * x, std::max(0.0, line));
    }
  }
  void summarize(const Scene&, SceneWords&) const override {}
};

TEST(AMotor, ObeysTheLawsOfEffects) {
  static const CommandedKind kind;
  const OtherEffectKinds kinds(kind);
  // Joint by joint: on the line, free with a lag, idle, braking.
  const Scene scene = readSceneText(
      "chain: [a, b, c, d]\n"
      "gravity: [0, 0]\n"
      "links:\n"
      "  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], initial: {angle: 0.4, velocity: 3},\n"
      "      joint: {effort_limit: 2, motor: {no_load_speed: 5}, stiffness: 2}}\n"
      "  b: {mass: 0.5, inertia: 0.05, com: [0.3, 0], pin: [0.6, 0.1], initial: {angle: -1, velocity: 0.5},\n"
      "      joint: {effort_limit: 2, motor: {no_load_speed: 50, time_constant: 0.2}}}\n"
      "  c: {mass: 0.5, inertia: 0.05, com: [0.3, 0], pin: [0.6, 0.1], initial: {angle: 1, velocity: 4},\n"
      "      joint: {effort_limit: 2, motor: {no_load_speed: 2, time_constant: 0.3}}}\n"
      "  d: {mass: 0.5, inertia: 0.05, com: [0.3, 0], pin: [0.6, 0.1], initial: {angle: 1, velocity: 4},\n"
      "      joint: {effort_limit: 2, motor: {no_load_speed: 2, time_constant: 0.3}}}\n");
  test::EffectLaws(scene, 0.1).expectAll();
}

TEST(Exponential, IsThatOfTheLibrary) {
  for (double x = -700; x < 700; x += 0.37) {
    EXPECT_NEAR(simd::exp(x) / std::exp(x), 1, 1e-15) << x;
  }
  EXPECT_EQ(simd::exp(0), 1);
  EXPECT_EQ(simd::exp(-1e9), 0);
  EXPECT_EQ(simd::exp(-forever), 0);
}

/// On a base, implicit methods ask how fast the torque of the first joint changes: not before the command.
TEST(Motor, OnABaseThatTurnsIsSmoothFromACommandOn) {
  for (const char* motor : {"effort_limit: 8, motor: {no_load_speed: 20}", "motor: {time_constant: 1e-6}"}) {
    for (const char* method : {"auto", "radau13", "rodas5p", "ros34pw2", "ros34pw2_fixed"}) {
      const Scene scene = readSceneText(
          "chain: [a]\nbase: {angle: {amplitude: 0.3, frequency: 1}}\nlinks: {a: {mass: 1, inertia: 0.1, "
          "com: "
          "[0.5, 0], pin: [1, 0], joint: {" +
          std::string(motor) + "}, initial: {angle: 0.9}}}\nintegrator: {tolerance: 1e-6, method: " + method +
          "}\n");
      Simulation simulation(scene, 1);
      simulation.addTorque(0, 1, 10, 0.3);
      EXPECT_TRUE(simulation.advanceTo(0.4)) << simulation.fault();
      EXPECT_LT(simulation.statistics().steps, 1500) << motor << ", " << method;
      EXPECT_EQ(simulation.statistics().rescues, 0) << motor << ", " << method;
      EXPECT_NEAR(simulation.energyBalance().residual, 0, 1e-6) << motor << ", " << method;
    }
  }
}

/// Friction swallows the motor's torque. The other joint turns on the moving base as without it.
TEST(Motor, ThatLagsInAJointThatIsHeldMovesNothing) {
  for (const char* method : {"auto", "taylor", "dop853", "radau13"}) {
    for (const double tolerance : {1e-5, 1e-8}) {
      const auto end = [&](double torque) {
        Scene scene = readSceneText(
            "chain: [a, b]\ngravity: [0, 0]\nbase: {y: {amplitude: 0.1, frequency: 1.0}}\nlinks:\n"
            "  a: {mass: 1, inertia: 0.1, com: [0, 0], pin: [1, 0], initial: {velocity: 0.8}}\n"
            "  b: {mass: 1, inertia: 0.1, com: [0, 0], pin: [1, 0], joint: {friction: 10, motor: "
            "{time_constant: 1e-4}}}\n");
        scene.integrator.method = method;
        scene.integrator.tolerance = tolerance;
        Simulation simulation(scene, 1);
        if (torque > 0) {
          EXPECT_TRUE(simulation.addTorque(1, torque, 0.1, 0.2));
        }
        EXPECT_TRUE(simulation.advanceTo(1)) << simulation.fault();
        return simulation.q()[0];
      };
      EXPECT_NEAR(end(0.1), end(0), 0.1 * tolerance) << method;
    }
  }
}

}  // namespace
}  // namespace planar_chain
