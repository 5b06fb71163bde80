/// Air drag of a link: it obeys the laws of effect_laws.h, and moves bodies as closed forms say, by every
/// method: a fall to the terminal velocity, and a throw straight up; a coast against the drag alone.

#include "effects/air_drag.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "effect_laws.h"
#include "ode/methods.h"
#include "planar_chain/scene_reader.h"

namespace planar_chain {
namespace {

const char* moves =
    "base: {x: {amplitude: 0.2, frequency: 1.1, phase: 0.4}, angle: {amplitude: 0.6, frequency: 0.8}}\n";
const char* rails =
    "  x: {mass: 2, pin: [0.2, -0.1], inertia: 0.4, drag: {coefficient: 0.7, point: [0.3, 0.4]}, joint: "
    "{type: prismatic, axis: [1, 0.5]},\n"
    "      initial: {position: 0.2, velocity: 1}}\n";
const char* slider =
    "  s: {mass: 0.7, inertia: 0.1, pin: [0.3, 0.1], drag: {coefficient: 0.4, point: [0.1, 0.2]},\n"
    "      joint: {type: prismatic, axis: [1, 0.2]}, initial: {position: 0.4, velocity: -1}}\n";

Scene chainOf(const std::string& names, const std::string& rest, int repeat = 1) {
  return readSceneText("chain: [" + names +
                       "]\nlinks:\n"
                       "  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], drag: 0.3,\n"
                       "      initial: {angle: 0.4, velocity: 2}}\n"
                       "  b: {mass: 0.5, inertia: 0.05, com: [0.3, -0.05], pin: [0.6, 0.1],\n"
                       "      drag: {coefficient: 0.5, point: [0.6, 0.2]},\n"
                       "      initial: {angle: -0.5, velocity: -0.7}, repeat: " +
                       std::to_string(repeat) + "}\n" + rest);
}

TEST(AirDrag, ObeysTheLaws) {
  for (const int repeat : {1, 4, 19}) {
    SCOPED_TRACE(repeat);
    test::EffectLaws(chainOf("a, b", "", repeat), 0.1).expectAll();
  }
  test::EffectLaws(chainOf("a, b", moves, 4), 0.1).expectAll();
}

TEST(AirDrag, ObeysThemWithPrismaticJointsAnywhere) {
  for (const std::string& base : {std::string(), std::string(moves)}) {
    SCOPED_TRACE(base);
    test::EffectLaws(chainOf("x, a, b", rails + base), 0.1).expectAll();
    test::EffectLaws(chainOf("a, s, b", slider + base), 0.1).expectAll();
  }
}

TEST(AirDrag, ObeysThemWithAHeldTip) {
  const std::string tip = "tip: {pin: [1.1, 0.3]}\n";
  const Scene scene = chainOf("a, b", tip, 3);
  test::EffectLaws laws(scene, 0.1);
  laws.expectAllButTangents();
}

class ByEveryMethod : public testing::TestWithParam<std::string> {
 protected:
  Simulation bodyOnARail(const std::string& joint, const std::string& gravity) const {
    return Simulation(
        readSceneText("{chain: [body], gravity: " + gravity +
                      ", links: {body: {mass: 2, drag: 0.5, joint: {type: prismatic, axis: [0, 1]}, " +
                      joint + "}}, integrator: {tolerance: 1e-10, method: " + GetParam() + "}}"));
  }
};

/// m v̇ = −m g + c v²: v = −V tanh(g t/V), y = −(V²/g) ln cosh(g t/V), V = √(m g/c).
TEST_P(ByEveryMethod, FallsToItsTerminalVelocity) {
  constexpr double m = 2, c = 0.5, g = 10;
  const double V = std::sqrt(m * g / c);
  Simulation fall = bodyOnARail("initial: {}", "[0, -10]");
  for (const double t : {0.3, 3.0}) {
    ASSERT_TRUE(fall.advanceTo(t)) << fall.fault();
    EXPECT_NEAR(fall.qd()[0], -V * std::tanh(g * t / V), 1e-8) << t;
    EXPECT_NEAR(fall.q()[0], -V * V / g * std::log(std::cosh(g * t / V)), 1e-8) << t;
  }
  EXPECT_NEAR(fall.energyBalance().residual, 0, 1e-7);
}

/// It rises for (V/g) atan(v_0/V), to (V²/2 g) ln(1 + v_0²/V²), and is back with v_0/√(1 + v_0²/V²).
TEST_P(ByEveryMethod, ComesBackSlowerThanItWasThrown) {
  constexpr double m = 2, c = 0.5, g = 10, v0 = 8;
  const double V = std::sqrt(m * g / c), slower = std::sqrt(1 + v0 * v0 / (V * V));
  const double up = V / g * std::atan(v0 / V), top = V * V / g * std::log(slower);
  const double down = V / g * std::acosh(std::exp(g * top / (V * V)));
  Simulation body = bodyOnARail("initial: {velocity: 8}", "[0, -10]");
  ASSERT_TRUE(body.advanceTo(up)) << body.fault();
  EXPECT_NEAR(body.q()[0], top, 1e-8);
  ASSERT_TRUE(body.advanceTo(up + down)) << body.fault();
  EXPECT_NEAR(body.q()[0], 0, 1e-7);
  EXPECT_NEAR(body.qd()[0], -v0 / slower, 1e-7);
}

std::vector<std::string> methods() {
  std::vector<std::string> names = ode::methodNames();
  names.erase(std::find(names.begin(), names.end(), "taylor"));
  return names;
}
INSTANTIATE_TEST_SUITE_P(AirDrag, ByEveryMethod, testing::ValuesIn(methods()));

TEST(AirDrag, LetsRodas5pTakeLongStepsWhereItIsStiff) {
  const auto stepsOf = [](const char* method) {
    Scene scene = readSceneText(
        "{chain: [a], links: {a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], drag: 1.0e+6, repeat: "
        "4, initial: {angle: 0.4}}}, integrator: {tolerance: 1e-6}}");
    scene.integrator.method = method;
    Simulation simulation(scene);
    EXPECT_TRUE(simulation.advanceTo(1)) << simulation.fault();
    return simulation.statistics().steps;
  };
  EXPECT_LT(10 * stepsOf("rodas5p"), stepsOf("dopri5"));
}

/// On a moving base, with a prismatic joint inside the chain: by Lagrange's equations (sympy) and scipy's
/// DOP853 to 1e-12.
TEST(AirDrag, MovesAChainAsLagrangesEquationsSay) {
  const double after[] = {-1.0300402018239683, 0.609198587092194, 2.107673434765893,
                          -1.9264590863897704, 2.117800225317868, 1.475312353694617};
  Scene scene = chainOf("a, s, b", std::string(slider) + "base: {x: {amplitude: 0.2, frequency: 1.1}}\n");
  scene.integrator.tolerance = 1e-11;
  for (const char* method : {"dop853", "rodas5p", "radau13", "auto"}) {
    scene.integrator.method = method;
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(1)) << simulation.fault();
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(simulation.q()[i], after[i], 1e-8) << method;
      EXPECT_NEAR(simulation.qd()[i], after[3 + i], 1e-7) << method;
    }
    EXPECT_NEAR(simulation.energyBalance().residual, 0, 1e-7) << method;
  }
}

TEST(AirDrag, OfNoStrengthIsAbsent) {
  Scene with = chainOf("a, b", "");
  std::vector<Link> links = with.chain.links();
  for (Link& link : links) link.others.set("drag", 0);
  with.chain = Chain(links, with.chain.joints(), with.chain.gravity());
  Scene without = with;
  for (Link& link : links) link.others.clear();
  without.chain = Chain(links, with.chain.joints(), with.chain.gravity());
  Simulation one(with), other(without);
  ASSERT_TRUE(one.advanceTo(1) && other.advanceTo(1));
  EXPECT_EQ(one.q(), other.q());
  EXPECT_EQ(one.qd(), other.qd());
  EXPECT_EQ(one.statistics().evaluations, other.statistics().evaluations);
}

/// Where the recursion for joints of any kind runs anyway, a trace of drag changes no bit of the motion.
TEST(AirDrag, OfATraceChangesNothing) {
  Scene traced = chainOf("x, a, b", rails);
  for (const char* method : {"dopri5", "rodas5p", "radau13", "rk4"}) {
    const auto endOf = [&](double drag) {
      std::vector<Link> links = traced.chain.links();
      for (Link& link : links) link.others.set("drag", drag);
      Scene scene = traced;
      scene.chain = Chain(links, traced.chain.joints(), traced.chain.gravity());
      scene.integrator.method = method;
      Simulation simulation(scene);
      EXPECT_TRUE(simulation.advanceTo(0.5)) << simulation.fault();
      return std::pair(simulation.q(), simulation.qd());
    };
    EXPECT_EQ(endOf(1e-300), endOf(0)) << method;
  }
}

TEST(AirDrag, HasNoTaylorSeries) {
  try {
    chainOf("a, b", "integrator: {method: taylor}\n");
    FAIL() << "taylor is taken";
  } catch (const Refused& refused) {
    EXPECT_EQ(
        toString(refused.faults()),
        "integrator/method: expected another method than taylor, as there is no Taylor series with 2 air "
        "drags, got \"taylor\"");
  }
}

}  // namespace
}  // namespace planar_chain
