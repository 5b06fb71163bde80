/// The guard: what it sees, what the fallbacks do about it, and that it leaves good runs alone.

#include "run/energy_guard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "ode/methods.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

using test::randomScene;

constexpr double J = 1. / 3;

/// A rod on a spring, k = J w²: q = 0.1 cos w t.
Scene oscillator(double w) {
  Joint joint;
  joint.name = "rod_joint";
  joint.stiffness = J * w * w;
  return {Chain({{"rod", 1, 1. / 12, {0.5, 0}, {1, 0}}}, {joint}, {}), {0.1}, {0}, {}, {}, {}, 0};
}

/// The guard of a scene with other settings.
struct Watch {
  Watch(Scene given, const IntegratorSettings& settings)
      : scene(std::move(given)), dynamics(scene), guard((scene.integrator = settings, scene), dynamics) {}

  Scene scene;
  Dynamics dynamics;
  EnergyGuard guard;
};

TEST(EnergyGuard, SeesWhatTheToleranceDoesNotExplain) {
  const Scene scene = oscillator(10);
  for (const double tolerance : {1e-4, 1e-8}) {
    Watch watch(scene, {"dopri5", tolerance, 0});
    EnergyGuard& guard = watch.guard;
    ode::State state(2);
    state.y << 0.1, 0;
    guard.begin(state, state.y.data());
    state.t = 0.1;
    state.y << 0.1 * std::cos(1), -std::sin(1);
    EXPECT_TRUE(guard.accept(state, state.y.data(), 1));
    state.y[1] *= 1 + 2 * tolerance;
    EXPECT_TRUE(guard.accept(state, state.y.data(), 1)) << "an error that the tolerance allows";
    const ode::State good = guard.lastGood();
    state.y[1] *= 1 + 2e4 * tolerance;
    EXPECT_FALSE(guard.accept(state, state.y.data(), 1));
    const double excess = J / 2 * (state.y[1] * state.y[1] - good.y[1] * good.y[1]);
    EXPECT_NEAR(guard.gap(), excess, 2e-4 * excess) << "and what was let pass just before";
    EXPECT_EQ(guard.lastGood().y, good.y) << "the last good state stays";
    state.y = good.y;
    state.y[0] += 3 * tolerance;
    EXPECT_TRUE(guard.accept(state, state.y.data(), 1))
        << "an angle that little off moves no more energy than this";
    state.y[1] = std::nan("");
    EXPECT_FALSE(guard.accept(state, state.y.data(), 1));
  }
}

TEST(EnergyGuard, SeesWhatAlmostLeavesTheNumbers) {
  // Energies of 1e164 J, whose product no double holds, and more than any double holds.
  const Scene scene = oscillator(10);
  for (const double rate : {1e82, 1e160}) {
    Watch watch(scene, {"auto", 1e-6, 0});
    EnergyGuard& guard = watch.guard;
    ode::State state(2);
    state.y << 0.1, 0;
    guard.begin(state, state.y.data());
    state.t = 0.001;
    state.y << 1e78, rate;
    EXPECT_FALSE(guard.accept(state, state.y.data(), 1)) << rate;
    EXPECT_EQ(guard.lastGood().y[1], 0);
  }
}

TEST(EnergyGuard, AddsUpTheGapsOfASecond) {
  // A fixed step may be off by a tenth of the energy in a second: by a twentieth once, but not thrice.
  const Scene scene = oscillator(10);
  Watch watch(scene, {"rk4", 0, 0.01});
  EnergyGuard& guard = watch.guard;
  ode::State state(2);
  state.y << 0, 1;
  guard.begin(state, state.y.data());
  const auto grow = [&] {
    state.t += 0.01;
    state.y[1] *= std::sqrt(1.05);
    return guard.accept(state, state.y.data(), 1);
  };
  EXPECT_TRUE(grow());
  state.t += 2;
  EXPECT_TRUE(guard.accept(state, state.y.data(), 1));
  EXPECT_TRUE(grow());
  EXPECT_TRUE(grow());
  EXPECT_TRUE(grow());
  EXPECT_TRUE(grow());
  EXPECT_FALSE(grow()) << "moved counts before and after: a fifth of the kinetic energy";
}

TEST(EnergyGuard, IsNoBlinderThanRounding) {
  const Scene scene = oscillator(10);
  Watch watch(scene, {"dopri5", 1e-15, 0});
  EnergyGuard& guard = watch.guard;
  ode::State state(2);
  state.y << 0, 1;
  guard.begin(state, state.y.data());
  state.y[1] = 1 + 1e-15;
  EXPECT_TRUE(guard.accept(state, state.y.data(), 1));
  state.y[1] = 1 + 5e-12;
  EXPECT_FALSE(guard.accept(state, state.y.data(), 1));
}

TEST(EnergyGuard, RescuesAMethodOutsideItsRegionOfStability) {
  // RK4 is stable up to w h = 2.83: a little beyond, an eighth of the step is enough; far beyond, it is not.
  for (const double wh : {3.5, 100.0}) {
    Scene scene = oscillator(1000);
    scene.integrator = {"rk4", 1e-8, wh / 1000};
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(0.1)) << simulation.fault();
    EXPECT_GT(simulation.statistics().rescues, 0);
    const EnergyBalance balance = simulation.energyBalance();
    EXPECT_NEAR(balance.residual, 0, 0.1 * balance.now.total());
    if (wh > 50) {
      EXPECT_EQ(simulation.method(), "rodas5p");
      EXPECT_NEAR(simulation.q()[0], 0.1 * std::cos(100), 1e-6);
    }
  }
}

TEST(EnergyGuard, ComesBackToTheScenesMethod) {
  // Beyond RK4's limit only while the rod is swung about by a stop, which is hit once.
  Scene scene = oscillator(1);
  Joint joint = scene.chain.joints()[0];
  joint.stiffness = 0;
  joint.upper = 0.2;
  joint.stopStiffness = J * 1e6;
  scene.chain = Chain(scene.chain.links(), {joint}, {});
  scene.qd = {1};
  scene.integrator = {"rk4", 1e-8, 0.01};
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(0.15)) << simulation.fault();
  EXPECT_GT(simulation.statistics().rescues, 0);
  for (int tick = 16; tick <= 100; ++tick) ASSERT_TRUE(simulation.advanceTo(0.01 * tick));
  EXPECT_EQ(simulation.method(), "rk4");
  EXPECT_NEAR(simulation.qd()[0], -1, 0.05) << "within a tenth of the energy";
}

Scene shipped(const std::string& name) {
  std::ifstream file(std::string(SCENES_DIR) + "/" + name + ".yaml");
  std::ostringstream text;
  text << file.rdbuf();
  return readSceneText(text.str());
}

TEST(EnergyGuard, LeavesGoodRunsAlone) {
  std::vector<Scene> scenes;
  for (const char* name : {"pendulum", "double_pendulum", "triple", "driven", "rope", "beam"}) {
    scenes.push_back(shipped(name));
  }
  for (const unsigned seed : {1u, 2u, 3u, 4u}) scenes.push_back(randomScene(5, seed));
  for (Scene& scene : scenes) {
    for (const char* method : {"auto", "dopri5", "rodas5p", "ros34pw2"}) {
      for (const double tolerance : {1e-3, 1e-6}) {
        scene.integrator = {method, tolerance, 1e-3};
        Simulation simulation(scene);
        ASSERT_TRUE(simulation.advanceTo(0.5)) << simulation.fault();
        EXPECT_EQ(simulation.statistics().rescues, 0)
            << scene.chain.size() << " links by " << method << " at " << tolerance;
      }
    }
  }
}

TEST(EnergyGuard, BalancesTheEnergyOfDampedVibrations) {
  // A vibration of 1e-4 rad and 0.1 rad/s at a tolerance of 1e-2: only rate_tolerance asks for it.
  Scene scene = oscillator(1000);
  scene.q = {1e-4};
  const double energy = J / 2 * 0.1 * 0.1;
  for (const char* method : {"rodas5p", "ros34pw2"}) {
    scene.integrator = {method, 1e-2, 0};
    Simulation loose(scene);
    ASSERT_TRUE(loose.advanceTo(1));
    EXPECT_NEAR(loose.energyBalance().residual, -energy, 0.01 * energy) << method;
    EXPECT_EQ(loose.statistics().rescues, 0) << method;
    scene.integrator.rateTolerance = 1e-2;
    Simulation tight(scene);
    ASSERT_TRUE(tight.advanceTo(1));
    EXPECT_NEAR(tight.energyBalance().residual, 0, 0.2 * energy) << method;
    EXPECT_NEAR(tight.qd()[0], -0.1 * std::sin(1000), 1e-2) << method;
  }
}

TEST(EnergyGuard, RefusesToGoOnWhereNothingHelps) {
  // Two links at 1e20 rad/s: a second would take more steps than there are numbers in it.
  for (const std::string& method : ode::methodNames()) {
    Scene scene = randomScene(2, 1);
    scene.qd = {1e20, -2e20};
    scene.integrator = {method, 1e-8, 1e-3};
    Simulation simulation(scene);
    EXPECT_FALSE(simulation.advanceTo(1));
    EXPECT_NE(simulation.fault().find(method + " gave up at t = 0 s"), std::string::npos);
    EXPECT_EQ(simulation.time(), 0);
    EXPECT_EQ(simulation.qd(), scene.qd);
    simulation.setState(scene.q, {1, 2});
    EXPECT_TRUE(simulation.advanceTo(0.1)) << simulation.fault();
  }
}

TEST(Blast, ThatTimeCannotResolveIsTheReason) {
  for (const double friction : {1e25, 1e100}) {
    Scene scene = randomScene(2, 1);
    std::vector<Joint> joints = scene.chain.joints();
    for (Joint& joint : joints) joint.others.emplace_back("friction", friction);
    scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
    scene.qd = {1, 1};
    Simulation simulation(scene);
    EXPECT_FALSE(simulation.advanceTo(1));
    EXPECT_NE(simulation.fault().find("time cannot resolve"), std::string::npos) << simulation.fault();
  }
}

// The series of a torque of 1e200 has coefficients that are infinite and NaN.
TEST(Blast, BeyondAllNumbersEndsEveryMethodAtTheLastGoodState) {
  for (const std::string& method : ode::methodNames()) {
    Load blast;
    blast.joint = 0;
    blast.torque = 1e200;
    blast.start = 1.3;
    Simulation simulation(Scene{Chain({{"rod", 2, 0.3, {0.4, 0}, {1, 0}}}, {{"rod_joint"}}, {}),
                                {0},
                                {0},
                                {blast},
                                {method, 1e-8, 1e-3},
                                {},
                                0});
    EXPECT_FALSE(simulation.advanceTo(2)) << method;
    EXPECT_EQ(simulation.time(), 1.3) << method;
    EXPECT_EQ(simulation.q()[0], 0) << method;
  }
}

}  // namespace
}  // namespace planar_chain
