/// Laws that the motion obeys, what commands do, what failing leaves behind, and what the loop may not do.

#include "planar_chain/simulation.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <new>
#include <string>

#include "lanes/kernel.h"
#include "ode/methods.h"
#include "ode/taylor.h"
#include "planar_chain/kane.h"
#include "planar_chain/scene_reader.h"
#include "run/step_budget.h"
#include "support/random_scene.h"

// Every allocation of this program, by new or by Eigen's malloc, is counted; but for a sanitized build, where
// malloc belongs to the sanitizer.
#ifndef __SANITIZE_ADDRESS__
namespace {
std::atomic<long> allocations{0};
}  // namespace

extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
#endif

namespace planar_chain {
namespace {

using test::randomScene;

constexpr double forever = std::numeric_limits<double>::infinity();

/// One rod of 1 m, 1 kg about its end, J = 1/3 kg m².
Scene rod(Vec2d gravity = {}) {
  return {Chain({{"rod", 1, 1. / 12, {0.5, 0}, {1, 0}}}, {{"rod_joint"}}, gravity), {0}, {0}, {}, {}, {}, 0};
}

#ifndef __SANITIZE_ADDRESS__
/// Limits that are soon met.
Scene limited(const Scene& scene) {
  std::vector<Joint> joints = scene.chain.joints();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    joints[i].lower = scene.q[i] - 0.1;
    joints[i].upper = scene.q[i] + 0.1;
    joints[i].stopStiffness = 1e3;
    joints[i].stopDamping = 1;
  }
  return {
      Chain(scene.chain.links(), joints, scene.chain.gravity()), scene.q, scene.qd, scene.loads, {}, {}, 0};
}

struct Allocating : testing::TestWithParam<std::tuple<const char*, int>> {};

TEST_P(Allocating, NothingInTheLoop) {
  const auto [method, n] = GetParam();
  for (Scene scene : {randomScene(n, 1), limited(randomScene(n, 1))}) {
    scene.integrator.method = method;
    scene.integrator.step = 1e-3;
    Simulation simulation(scene, 16);
    std::vector<LinkMotion> motions(static_cast<std::size_t>(n));
    std::vector<double> tau(static_cast<std::size_t>(n));
    const long before = allocations;
    for (int k = 1; k <= 30; ++k) {
      simulation.advanceTo(k * 0.01);
      simulation.holdTorque(k % n, 0.1, forever);
      simulation.addForce(k % n, {0.5, 0}, {0, 1}, 0, 0.005);
      simulation.holdTorque(k % n, 0.2, forever, k * 0.01 + 0.0123);
      simulation.addTorque(k % n, 0.3, 0.001, k * 0.01 + 0.0047);
      simulation.linkMotions(motions.data());
      simulation.jointTorques(tau.data());
      simulation.energyBalance();
    }
    simulation.clearCommands();
    EXPECT_EQ(allocations, before);
  }
  const long before = allocations;
  const std::vector<double> counted(100);
  EXPECT_GT(allocations, before) << "the counter does not count";
}

/// A parallelogram goes through two change points (ode/leap.h).
TEST(AllocatingNothing, OverAChangePoint) {
  std::ifstream file(SCENES_DIR "/linkage.yaml");
  Simulation simulation(readSceneText({std::istreambuf_iterator<char>(file), {}}));
  ASSERT_TRUE(simulation.advanceTo(0.1));
  const long before = allocations;
  ASSERT_TRUE(simulation.advanceTo(1.5)) << simulation.fault();
  EXPECT_EQ(allocations, before);
}

// By number, and as the segments are gone through.
INSTANTIATE_TEST_SUITE_P(Methods, Allocating,
                         testing::Combine(testing::Values("rk4", "dopri5", "radau13", "taylor", "auto"),
                                          testing::Values(10, 20)));
#endif

TEST(Simulation, IsDeterministic) {
  const Scene scene = randomScene(6, 2);
  Simulation one(scene), other(scene);
  for (int k = 1; k <= 50; ++k) {
    one.advanceTo(k * 0.02);
    other.advanceTo(k * 0.02);
  }
  EXPECT_EQ(one.q(), other.q());
  EXPECT_EQ(one.qd(), other.qd());
}

TEST(Simulation, StartsAtTheSceneToTheLastBit) {
  const Scene scene = randomScene(6, 2);
  const Simulation simulation(scene);
  EXPECT_EQ(simulation.q(), scene.q);
  EXPECT_EQ(simulation.qd(), scene.qd);
  EXPECT_EQ(simulation.time(), 0);
}

TEST(Simulation, SaysWhichRecursionRuns) {
  const auto recursionFor = [](int n) { return Simulation(randomScene(n, 1)).recursion(); };
  EXPECT_EQ(recursionFor(1), "link by link, written out for 1");
  EXPECT_EQ(recursionFor(2), "closed form for two");
  EXPECT_EQ(recursionFor(5), "link by link, written out for 5");
  EXPECT_EQ(recursionFor(12), "link by link, written out for 12");
  const auto inSegments = [](const simd::Kernel& of) {
    return "in " + std::to_string(of.lanes) + " segments side by side (" + of.name + ")";
  };
  EXPECT_EQ(recursionFor(100), inSegments(*simd::kernels().front()));
  // 8 pieces of a short one are not worth joining.
  for (const int n : {13, 20}) EXPECT_EQ(recursionFor(n), inSegments(simd::kernelFor(n, {})));
  Scene plain = randomScene(100, 1);
  plain.integrator.plainKernel = true;
  EXPECT_EQ(Simulation(plain).recursion(), inSegments(simd::kernelBaseline));
}

TEST(Simulation, PowerInEqualsEnergyRate) {
  // E − W_supplied + W_dissipated stays, with loads, springs and dampers. The works are integrated with the
  // motion, so the balance is as exact as the motion: some tolerances, in units of the energy.
  for (const int n : {1, 2, 5, 20}) {
    Scene scene = randomScene(n, 10 + static_cast<unsigned>(n));
    scene.integrator.tolerance = 1e-10;
    Simulation simulation(scene);
    const double scale = 1 + std::abs(simulation.energy().potential) + simulation.energy().kinetic;
    ASSERT_TRUE(simulation.advanceTo(1));
    const EnergyBalance balance = simulation.energyBalance();
    EXPECT_LT(std::abs(balance.residual), 1e-9 * scale) << n;
    EXPECT_GT(std::abs(balance.supplied), 1e-3) << n;
    EXPECT_GT(balance.dissipated, 1e-3) << n;
  }
}

TEST(Simulation, RunsBackwardsToWhereItStarted) {
  // Without dampers and loads the motion is reversible: turn the rates round, and the start comes back.
  Scene scene = randomScene(4, 5, {true, false, false});
  scene.integrator.tolerance = 1e-12;
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(0.7));
  std::vector<double> qd = simulation.qd();
  for (double& rate : qd) rate = -rate;
  simulation.setState(simulation.q(), qd);
  ASSERT_TRUE(simulation.advanceTo(1.4));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(simulation.q()[i], scene.q[i], 1e-10);
    EXPECT_NEAR(-simulation.qd()[i], scene.qd[i], 1e-9);
  }
}

TEST(Simulation, ComesBackAfterThousandsOfStepsByTaylor) {
  // Measured: at most 4e-14; 5e-13 if the series ignores the carry of the angles, or multiplies by a rounded
  // 1/3.
  const Chain chain({{"a", 1, 1. / 12, {0.5, 0}, {1, 0}}, {"b", 1, 1. / 12, {0.5, 0}, {1, 0}}},
                    {{"a"}, {"b"}}, {0, -9.8});
  Scene scene{chain, {0.05 - pi / 2, 0.025 - 0.05}, {0, 0}, {}, {}, {}, 0};
  scene.integrator.method = "taylor";
  scene.integrator.tolerance = 1e-15;
  for (const double end : {1000.0, 1000.3, 1001.0, 1002.0}) {
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(end));
    simulation.setState(simulation.q(), {-simulation.qd()[0], -simulation.qd()[1]});
    ASSERT_TRUE(simulation.advanceTo(2 * end));
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR(simulation.q()[i], scene.q[i], 1e-13) << end;
      EXPECT_NEAR(simulation.qd()[i], 0, 1e-13) << end;
    }
  }
}

TEST(Simulation, TurnsMadeBeforeCostNoDigits) {
  // A swing that starts after a hundred thousand turns is the swing itself: an angle's size is no licence in
  // the error control. So slow (one swing in 1.7 h) that errors of the angle do not show in the rate.
  constexpr double turns = 1e5 * 6.283185307179586476925;
  Scene scene = rod({0, -1e-6});
  scene.integrator.method = "dopri5";
  Simulation near(scene);
  scene.q = {turns};
  Simulation far(scene);
  ASSERT_TRUE(near.advanceTo(6000) && far.advanceTo(6000));
  EXPECT_NEAR(far.q()[0] - turns, near.q()[0], 1e-7);
}

TEST(Simulation, LandsOnLoadsSoThatImpulsesAreExact) {
  // 2 N m from 0.1 s to 0.1373 s on J = 1/3: 6 · 0.0373 rad/s, whatever the steps are.
  for (const char* method : {"rk4", "dopri5"}) {
    Scene scene = rod();
    Load push;
    push.name = "push";
    push.joint = 0;
    push.torque = 2;
    push.start = 0.1;
    push.stop = 0.1373;
    scene.loads = {push};
    scene.integrator = {method, 1e-6, 0.01};
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(1));
    EXPECT_NEAR(simulation.qd()[0], 6 * 0.0373, 1e-15) << method;
    EXPECT_NEAR(simulation.q()[0], 6 * 0.0373 * (1 - 0.1 - 0.0373 / 2), 1e-14) << method;
  }
}

TEST(Simulation, RampsAndSinesGiveTheirImpulse) {
  Scene scene = rod();
  Load ramp, sine;
  ramp.name = "ramp";
  ramp.joint = 0;
  ramp.torque = 3;
  ramp.law = Ramp{{0.2, 0.5, 0.6}, {0, 1, 0.5}};
  ramp.stop = 1;  // ∫ = 0.15 + 0.075 + 0.5 · 0.4
  sine.name = "sine";
  sine.link = 0;
  sine.moment = 2;
  sine.law = Sine{1.5, 0.3};
  scene.loads = {ramp, sine};
  scene.integrator.tolerance = 1e-11;
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(1.2));
  const double w = 3 * 3.14159265358979323846;
  const double expected = 3 * (3 * (0.15 + 0.075 + 0.2) + 2 * (std::cos(0.3) - std::cos(w * 1.2 + 0.3)) / w);
  EXPECT_NEAR(simulation.qd()[0], expected, 1e-11);
}

TEST(Auto, LosesLittleByTrials) {
  // Of methods that are no better: against the one that it stays with.
  struct Run {
    int links;
    unsigned seed;
    const char* best;
    double tolerance, end;
  };
  for (const Run& run : {Run{2, 4, "taylor", 1e-8, 5.0}, Run{10, 10, "dop853", 1e-4, 4.0}}) {
    Scene scene = randomScene(run.links, run.seed, {false, false, false});
    scene.integrator.tolerance = run.tolerance;
    const auto statisticsOf = [&](const char* method) {
      scene.integrator.method = method;
      Simulation simulation(scene);
      EXPECT_TRUE(simulation.advanceTo(run.end)) << simulation.fault();
      EXPECT_EQ(simulation.method(), run.best);
      return simulation.statistics();
    };
    const Statistics best = statisticsOf(run.best), chosen = statisticsOf("auto");
    EXPECT_LT(static_cast<double>(chosen.evaluations), 1.06 * static_cast<double>(best.evaluations));
    EXPECT_LT(static_cast<double>(chosen.steps), 1.06 * static_cast<double>(best.steps));
  }
}

TEST(Auto, TriesNoLowerOrderBesideASeriesThatCostsLittle) {
  Scene scene = readSceneText(
      "{chain: [cart, pole], links: {cart: {mass: 1, joint: {type: prismatic}},\n"
      "  pole: {mass: 0.4, inertia: 0.01, com: [0.25, 0], pin: [0.5, 0], initial: {angle: 1}}}}");
  scene.integrator.tolerance = 1e-6;
  const auto besideSeries = [&](const char* method) {
    scene.integrator.method = method;
    Simulation simulation(scene);
    EXPECT_TRUE(simulation.advanceTo(10)) << simulation.fault();
    const Statistics made = simulation.statistics();
    return made.evaluations - ode::Taylor::orderFor(1e-6) * made.steps;
  };
  // Each trial has an evaluation at least for each of its stages: six.
  EXPECT_NEAR(static_cast<double>(besideSeries("auto")), static_cast<double>(besideSeries("taylor")), 5);
}

// A step of 1e-4 s far beyond stiff stops errs wildly. Interpolation for the first switch within it shortened
// the bracket by roundings, 1e13 times.
TEST(StepBudget, IsAskedSoonWhateverAStepErrs) {
  const Scene scene = readSceneText(
      "chain: [a, b]\n"
      "links:\n"
      "  a: &rod {mass: 1e-3, inertia: 1e-12, com: [0.001, 0], pin: [0.002, 0], initial: {angle: 1e4},\n"
      "           joint: {upper: 0.1, stop_stiffness: 1e6, friction: 1e-3}}\n"
      "  b: *rod\n"
      "integrator: {method: ros34pw2_fixed, step: 1e-4}\n");
  Simulation simulation(scene);
  constexpr long long enough = 20000, withinOneCall = 32 * 100;
  const auto made = [&] { return simulation.statistics().steps + simulation.statistics().rejected; };
  simulation.advanceTo(1, [&] { return made() < enough; });
  EXPECT_GE(made(), enough);
  EXPECT_LT(made(), enough + 2 * withinOneCall);
}

TEST(StepBudget, LeavesOutTheStepsThatTheUserHasChosen) {
  EXPECT_EQ(StepBudget::usual({"auto", 1e-6, 1e-3}, 0.1), 1'000'000);
  EXPECT_EQ(StepBudget::usual({"dopri5", 1e-6, 1e-3}, 3), 3'000'000);
  EXPECT_EQ(StepBudget::usual({"rk4", 1e-6, 0x1p-20}, 4), 4'000'000 + (1 << 22));
}

TEST(Simulation, RoundingOfAStiffSpringDoesNotStarveTheStep) {
  // The spring's torque is rounded to 1e-4 N m, which no shorter step makes smaller against h.
  Scene scene = rod();
  scene.chain = Chain({{"rod", 1, 1. / 12, {0.5, 0}, {1, 0}}}, {{"rod_joint", 1e12, 0, 1 + 1e-9}}, {});
  scene.q = {1};
  scene.integrator = {"dopri5", 1e-6, 0};
  Simulation simulation(scene);
  EXPECT_TRUE(simulation.advanceTo(1e-4)) << simulation.fault();
  EXPECT_LT(simulation.statistics().steps, 3000);
}

TEST(Simulation, NoStepJumpsOverAWave) {
  // At a tolerance that any step meets, a quarter of a period a step is what still sees the wave.
  Scene scene = rod();
  Load sine;
  sine.name = "sine";
  sine.joint = 0;
  sine.torque = 2;
  sine.law = Sine{1.5, 0};
  scene.loads = {sine};
  scene.integrator = {"dopri5", 1, 0};
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(20.2));
  const double w = 3 * 3.14159265358979323846;
  EXPECT_NEAR(simulation.qd()[0], 3 * 2 * (1 - std::cos(w * 20.2)) / w, 1e-3);
  EXPECT_GE(simulation.statistics().steps, 4 * 1.5 * 20.2);
}

TEST(Commands, TimedOnesAddAndEndToTheBit) {
  Simulation simulation(rod(), 8);
  ASSERT_TRUE(simulation.advanceTo(0.01));
  EXPECT_TRUE(simulation.addTorque(0, 1, 0.0373));
  ASSERT_TRUE(simulation.advanceTo(0.02));
  EXPECT_TRUE(simulation.addForce(0, {1, 0}, {0, 0}, 2, 0.0173));
  for (int k = 3; k <= 10; ++k) ASSERT_TRUE(simulation.advanceTo(k * 0.01));
  EXPECT_NEAR(simulation.qd()[0], 3 * (0.0373 + 2 * 0.0173), 1e-15);
}

TEST(Commands, StartToTheBitAndWhatIsLeftOfThemActs) {
  Simulation simulation(rod(), 8);
  ASSERT_TRUE(simulation.advanceTo(0.01));
  EXPECT_TRUE(simulation.addTorque(0, 1, 0.0373, 0.0234));                // wholly ahead
  EXPECT_TRUE(simulation.addForce(0, {1, 0}, {0, 0}, 2, 0.015, 0.0005));  // 0.0055 s are left of it
  EXPECT_TRUE(simulation.holdTorque(0, 4, 0.09, 0.0811));
  EXPECT_THROW(simulation.addTorque(0, 1, 0.009, 0), std::invalid_argument) << "over";
  EXPECT_THROW(simulation.holdTorque(0, 1, 0.01, 0), std::invalid_argument) << "over";
  ASSERT_TRUE(simulation.advanceTo(0.0234));
  EXPECT_NEAR(simulation.qd()[0], 3 * 2 * 0.0055, 1e-15);
  for (int k = 3; k <= 10; ++k) ASSERT_TRUE(simulation.advanceTo(k * 0.01));
  EXPECT_NEAR(simulation.qd()[0], 3 * (2 * 0.0055 + 0.0373 + 4 * 0.0089), 1e-15);
}

TEST(Commands, HeldOnesWaitInOrderOfTheirStarts) {
  Simulation simulation(rod(), 3);
  EXPECT_TRUE(simulation.holdTorque(0, 3, forever, 0.3));
  EXPECT_TRUE(simulation.holdTorque(0, 1, forever, 0.1));
  EXPECT_TRUE(simulation.holdTorque(0, 2, forever, 0.2));
  EXPECT_FALSE(simulation.holdTorque(0, 4, forever, 0.4)) << "there is room for three";
  EXPECT_TRUE(simulation.holdTorque(0, 10, forever)) << "what is held now needs no room";
  ASSERT_TRUE(simulation.advanceTo(0.4));
  EXPECT_NEAR(simulation.qd()[0], 3 * (10 * 0.1 + 1 * 0.1 + 2 * 0.1 + 3 * 0.1), 1e-14);
  EXPECT_TRUE(simulation.holdTorque(0, 5, forever, 0.5));
  simulation.clearCommands();
  ASSERT_TRUE(simulation.advanceTo(1));
  EXPECT_NEAR(simulation.qd()[0], 3 * 1.6, 1e-14);
}

TEST(Commands, ThatWaitChangeNoBitBeforeTheyStart) {
  // Whenever they came, if it was before.
  const auto motionWithCommandGivenAt = [](int given) {
    Scene scene = randomScene(6, 3);
    scene.integrator.method = "auto";
    Simulation simulation(scene, 4);
    std::vector<double> values;
    for (int k = 1; k <= 40; ++k) {
      if (k == given) {
        simulation.addTorque(1, 2, 0.0345, 0.7111);
        simulation.holdForce(3, {0.1, 0}, {1, 2}, 0, forever, 0.8222);
      }
      simulation.advanceTo(k * 0.025);
      values.insert(values.end(), simulation.q().begin(), simulation.q().end());
    }
    return values;
  };
  const std::vector<double> early = motionWithCommandGivenAt(1);
  EXPECT_EQ(early, motionWithCommandGivenAt(17));
  EXPECT_EQ(early, motionWithCommandGivenAt(28));
  EXPECT_NE(early, motionWithCommandGivenAt(30));
}

TEST(Commands, HeldOnesAreReplacedAndLapse) {
  Simulation simulation(rod(), 8);
  simulation.holdTorque(0, 5, forever);
  simulation.holdTorque(0, 1, 0.25);
  ASSERT_TRUE(simulation.advanceTo(1));
  EXPECT_NEAR(simulation.qd()[0], 3 * 0.25, 1e-14);
  simulation.holdTorque(0, 1, forever);
  simulation.clearCommands();
  ASSERT_TRUE(simulation.advanceTo(2));
  EXPECT_NEAR(simulation.qd()[0], 3 * 0.25, 1e-14);
}

TEST(Commands, AreLoadsThatActTheSame) {
  // Kane's equations of the scene with its commands for loads, while some lapse and end.
  Scene scene = randomScene(4, 5);
  Simulation simulation(scene, 8);
  EXPECT_TRUE(simulation.commands().empty());
  simulation.holdTorque(1, 2, forever);
  simulation.holdTorque(3, -4, 0.15);
  simulation.holdForce(2, {0.3, -0.2}, {1, 5}, 0.7, forever);
  simulation.addTorque(1, 3, 0.25);
  simulation.addForce(0, {1, 1}, {-2, 3}, -1, 0.35);
  for (const std::size_t left : {5U, 4U, 3U, 2U}) {
    scene.loads = simulation.scene().loads;
    const std::vector<Load> commands = simulation.commands();
    EXPECT_EQ(commands.size(), left);
    scene.loads.insert(scene.loads.end(), commands.begin(), commands.end());
    const auto vector = [](const std::vector<double>& v) -> Eigen::VectorXd {
      return Eigen::Map<const Eigen::VectorXd>(v.data(), 4);
    };
    const Eigen::VectorXd q = vector(simulation.q()), qd = vector(simulation.qd());
    const Eigen::VectorXd kanes = kane(scene.chain, q, qd, activeForces(scene, simulation.time(), q, qd)).qdd;
    Eigen::VectorXd qdd(4);
    simulation.accelerations(qdd.data());
    EXPECT_LT((qdd - kanes).norm(), 1e-11 * kanes.norm()) << left;
    simulation.advanceTo(simulation.time() + 0.15);
  }
}

TEST(Commands, WrongOnesThrowAndChangeNothing) {
  Simulation simulation(rod(), 1), deaf(rod());
  EXPECT_THROW(simulation.holdTorque(0, std::nan(""), forever), std::invalid_argument);
  EXPECT_THROW(simulation.holdTorque(1, 1, forever), std::invalid_argument);
  EXPECT_THROW(simulation.addTorque(0, 1, 0), std::invalid_argument);
  EXPECT_THROW(simulation.addForce(-1, {}, {}, 0, 1), std::invalid_argument);
  EXPECT_THROW(simulation.advanceTo(-1), std::invalid_argument);
  EXPECT_THROW(simulation.setState({std::nan("")}, {0}), std::invalid_argument);
  EXPECT_THROW(deaf.holdTorque(0, 1, forever), std::invalid_argument);
  EXPECT_TRUE(simulation.addTorque(0, 0, 1));
  EXPECT_FALSE(simulation.addTorque(0, 1, 1)) << "there is room for one";
  ASSERT_TRUE(simulation.advanceTo(1));
  EXPECT_EQ(simulation.qd()[0], 0);
}

TEST(GivenMotion, IsModerateInItsFirstPieceToo) {
  const MotionLaw still = MotionLaw::sine(0, 0, 0, 0);
  EXPECT_TRUE(still.to(0, 0.005, 1e-3, 1e6).isModerate());
  EXPECT_FALSE(still.to(0, 0.005, 0, 1e14).isModerate()) << "4e16 per s²";
  MotionPoint point;
  point.time = 1e-4;
  point.value = 1e8;
  point.rate = 0;
  EXPECT_FALSE(still.then(0, 0, {point}).isModerate()) << "6e16 per s²";
  EXPECT_TRUE(still.isModerate());
}

TEST(Failure, IsSaidAtOnceKeepsTheLastGoodStateAndResetLeadsBack) {
  // Every method tries a few steps, shorter and shorter, before it gives up.
  Load blast;
  blast.name = "blast";
  blast.joint = 0;
  blast.torque = 1e200;
  blast.start = 0.3;
  for (const std::string& method : ode::methodNames()) {
    for (const double q : {0.1, 0.0}) {
      Scene scene = rod();
      scene.q = {q};
      scene.integrator = {method, 1e-8, 0.01};
      Simulation spared(scene);
      scene.loads = {blast};
      Simulation simulation(scene, 10);
      for (int k = 1; k <= 60; ++k) EXPECT_TRUE(simulation.advanceTo(k * 0.005)) << method;
      EXPECT_FALSE(simulation.advanceTo(0.305)) << method;
      EXPECT_NE(simulation.fault().find(method + " gave up at t = 0.3"), std::string::npos)
          << simulation.fault();
      EXPECT_NE(simulation.fault().find("the last good state is kept"), std::string::npos) << method;
      ASSERT_TRUE(spared.advanceTo(0.3));
      EXPECT_EQ(simulation.time(), 0.3) << method;
      EXPECT_NEAR(simulation.q()[0], spared.q()[0], 1e-6) << method;
      EXPECT_NEAR(simulation.qd()[0], spared.qd()[0], 1e-6) << method;

      EXPECT_FALSE(simulation.advanceTo(1)) << method;
      EXPECT_EQ(simulation.time(), 0.3) << method;
      simulation.reset();
      EXPECT_EQ(simulation.fault(), "");
      EXPECT_EQ(simulation.q()[0], q);
      EXPECT_EQ(simulation.time(), 0);
      EXPECT_TRUE(simulation.advanceTo(0.01)) << method;
    }
  }
}

TEST(Reset, GivesTheSameBitsAgainWhateverWentBefore) {
  for (const char* method : {"auto", "dop853", "radau13", "rk4"}) {
    Scene scene = randomScene(6, 2);
    scene.integrator.method = method;
    Simulation simulation(scene, 8);
    const auto motion = [&] {
      std::vector<double> values;
      for (int k = 1; k <= 60; ++k) {
        if (k == 20) simulation.addTorque(2, 3, 0.123);
        simulation.advanceTo(k * 0.05);
        values.insert(values.end(), simulation.q().begin(), simulation.q().end());
        values.insert(values.end(), simulation.qd().begin(), simulation.qd().end());
      }
      values.push_back(static_cast<double>(simulation.statistics().steps));
      return values;
    };
    const std::vector<double> first = motion();
    simulation.holdTorque(1, 100, forever, 3.5);
    simulation.advanceTo(4);
    simulation.holdTorque(0, -50, forever, 5);
    simulation.setState(scene.qd, scene.q);
    simulation.advanceTo(4.1);
    simulation.reset();
    EXPECT_EQ(simulation.time(), 0);
    EXPECT_EQ(first, motion()) << method;
  }
}

}  // namespace
}  // namespace planar_chain
