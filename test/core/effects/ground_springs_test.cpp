/// Springs from a link to the ground: they obey the laws of effect_laws.h, slack or not, and move bodies as
/// closed forms say, by every method. effects/ground_springs.h has their formulas.

#include "effects/ground_springs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "dynamics/equilibrium.h"
#include "effect_laws.h"
#include "ode/methods.h"
#include "planar_chain/scene_reader.h"

namespace planar_chain {
namespace {

const char* moves =
    "base: {x: {amplitude: 0.2, frequency: 1.1, phase: 0.4}, angle: {amplitude: 0.6, frequency: 0.8, offset: "
    "0.3}}\n";

/// One spring pulls, one has no length at rest, one pushes, one would but is slack, and one relaxes: it is
/// longer than at rest, but gets shorter so fast that its damper would push.
std::string springsOf(const std::string& first, const std::string& last) {
  return "springs:\n"
         "  pulls: {link: " +
         first +
         ", ground: [-3, 1], stiffness: 30, damping: 2, rest_length: 0.5}\n"
         "  bushing: {link: " +
         last +
         ", ground: [1, 0], stiffness: 7, damping: 0.4}\n"
         "  pushes: {link: " +
         last +
         ", point: [0.2, 0.1], ground: [0.2, 5], stiffness: 5, damping: 0.3, "
         "rest_length: 9}\n"
         "  idle: {link: " +
         last +
         ", ground: [4, -3], stiffness: 500, rest_length: 50, slack: true}\n"
         "  rope: {link: " +
         first +
         ", point: [0.1, 0.3], ground: [5, 4], stiffness: 20, damping: 1, "
         "rest_length: 0.4, slack: true}\n"
         "  relaxes: {link: " +
         last +
         ", point: [0.6, 0.1], ground: [-1, 4], stiffness: 3, damping: 900, "
         "rest_length: 1, slack: true}\n";
}

std::string chainOf(const std::string& names, const std::string& more, int repeat = 1) {
  return "chain: [" + names +
         "]\nlinks:\n"
         "  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], initial: {angle: 0.4, velocity: 2}}\n"
         "  b: {mass: 0.5, inertia: 0.05, com: [0.3, -0.05], pin: [0.6, 0.1],\n"
         "      initial: {angle: -0.5, velocity: -0.7}, repeat: " +
         std::to_string(repeat) + "}\n" + more;
}

TEST(GroundSprings, ObeyTheLaws) {
  for (const int repeat : {1, 4, 19}) {
    SCOPED_TRACE(repeat);
    const std::string last = repeat > 1 ? "b_" + std::to_string(repeat) : "b";
    test::EffectLaws(readSceneText(chainOf("a, b", springsOf("a", last), repeat)), 0.1).expectAll();
    test::EffectLaws(readSceneText(chainOf("a, b", springsOf("a", last) + moves, repeat)), 0.1).expectAll();
  }
}

TEST(GroundSprings, ObeyThemWithPrismaticJointsAnywhere) {
  const char* rails =
      "  x: {mass: 2, pin: [0.2, -0.1], inertia: 0.4, joint: {type: prismatic, axis: [1, 0.5], damping: "
      "0.3},\n"
      "      initial: {position: 0.2, velocity: 1}}\n";
  const char* plane =
      "  x: {mass: 2, pin: [0.2, -0.1], joint: {type: prismatic, drive: {amplitude: 0.2, frequency: 1.3}}}\n"
      "  y: {mass: 0.7, pin: [0, 0.3], joint: {type: prismatic, axis: [0.2, 1], damping: 2},\n"
      "      initial: {position: -0.1, velocity: -2}}\n";
  const char* inside =
      "  s: {mass: 0.7, inertia: 0.1, pin: [0.3, 0.1], joint: {type: prismatic, axis: [1, 0.2]},\n"
      "      initial: {position: 0.4, velocity: -1}}\n";
  for (const std::string& base : {std::string(), std::string(moves)}) {
    SCOPED_TRACE(base);
    for (const auto& [names, links, first] :
         {std::tuple("x, a, b", rails, "x"), {"x, y, a, b", plane, "y"}, {"a, s, b", inside, "s"}}) {
      SCOPED_TRACE(names);
      test::EffectLaws(readSceneText(chainOf(names, links + springsOf(first, "b") + base)), 0.1).expectAll();
    }
  }
}

TEST(GroundSprings, ObeyThemWithAHeldTip) {
  test::EffectLaws laws(readSceneText(chainOf("a, b", springsOf("a", "b_3") + "tip: {pin: [1.1, 0.3]}\n", 3)),
                        0.1);
  laws.expectAllButTangents();
}

/// A body on a rail, with a spring along it.
class ByEveryMethod : public testing::TestWithParam<std::string> {
 protected:
  Simulation bodyOnARail(const std::string& spring, const std::string& initial) const {
    return Simulation(
        readSceneText("{chain: [body], gravity: [0, 0], links: {body: {mass: 2, joint: {type: "
                      "prismatic}, initial: " +
                      initial + "}}, springs: {rope: {link: body, ground: [-3, 0], " + spring +
                      "}}, integrator: {tolerance: 1e-10, method: " + GetParam() + "}}"));
  }
};

TEST_P(ByEveryMethod, SwingAsADampedMass) {
  // x = L − L_0: 2 ẍ + 4 ẋ + 52 x = 0, x(0) = 1, ẋ(0) = 0: x = e^−t (cos 5 t + sin 5 t / 5)
  Simulation body = bodyOnARail("stiffness: 52, damping: 4, rest_length: 2", "{position: 0}");
  for (const double t : {0.4, 2.0}) {
    ASSERT_TRUE(body.advanceTo(t)) << body.fault();
    EXPECT_NEAR(body.q()[0], std::exp(-t) * (std::cos(5 * t) + std::sin(5 * t) / 5) - 1, 1e-8) << t;
  }
  EXPECT_NEAR(body.energyBalance().residual, 0, 1e-6);
}

TEST_P(ByEveryMethod, FlyFreelyWhereTheyAreSlack) {
  // From x = 1 at rest, ω = 5: slack after π/10 s at −5 m/s; it passes the anchor, and the rope is taut again
  // on the other side, 2 L_0 further; it turns back 1 m behind that after 2 π/10 + 4/5 s.
  Simulation body = bodyOnARail("stiffness: 50, rest_length: 2, slack: true", "{position: 0}");
  ASSERT_TRUE(body.advanceTo(pi / 10)) << body.fault();
  EXPECT_NEAR(body.q()[0], -1, 1e-8);
  ASSERT_TRUE(body.advanceTo(pi / 10 + 0.4)) << body.fault();
  EXPECT_NEAR(body.q()[0], -3, 1e-7);
  EXPECT_NEAR(body.qd()[0], -5, 1e-7);
  ASSERT_TRUE(body.advanceTo(pi / 5 + 0.8)) << body.fault();
  EXPECT_NEAR(body.q()[0], -6, 1e-7);
  EXPECT_NEAR(body.qd()[0], 0, 1e-6);
  ASSERT_TRUE(body.advanceTo(2 * (pi / 5 + 0.8))) << body.fault();
  EXPECT_NEAR(body.q()[0], 0, 1e-6);
  EXPECT_NEAR(body.energyBalance().residual, 0, 1e-5);
}

TEST_P(ByEveryMethod, LetGoWhereTheDamperWouldPush) {
  // It comes back with x = e^−t (…) until k x + d ẋ = 0, then flies on: at ẋ of that moment.
  Simulation body = bodyOnARail("stiffness: 52, damping: 4, rest_length: 2, slack: true", "{position: 0}");
  const auto x = [](double t) { return std::exp(-t) * (std::cos(5 * t) + std::sin(5 * t) / 5); };
  const auto rate = [](double t) { return -5.2 * std::exp(-t) * std::sin(5 * t); };
  double low = 0, high = 0.4;
  for (int k = 0; k < 60; ++k) {
    const double t = (low + high) / 2;
    (52 * x(t) + 4 * rate(t) > 0 ? low : high) = t;
  }
  ASSERT_TRUE(body.advanceTo(0.6)) << body.fault();
  EXPECT_NEAR(body.qd()[0], rate(low), 1e-7);
  EXPECT_NEAR(body.q()[0], x(low) - 1 + (0.6 - low) * rate(low), 1e-7);
  EXPECT_NEAR(body.energyBalance().residual, 0, 1e-7);
}

std::vector<std::string> methods() {
  std::vector<std::string> names = ode::methodNames();
  names.erase(std::find(names.begin(), names.end(), "taylor"));
  return names;
}
INSTANTIATE_TEST_SUITE_P(GroundSprings, ByEveryMethod, testing::ValuesIn(methods()));

/// On a moving base, with a prismatic joint inside the chain and a rope that gets taut after 0.6525 s, slack
/// after 1.1263 s and taut after 1.2799 s: by Lagrange's equations (sympy) and scipy's DOP853 to 1e-12 with
/// located events.
TEST(GroundSprings, MoveAChainAsLagrangesEquationsSay) {
  const double after[] = {3.5182516618842916, -1.27383596637901, -3.4779317736576276,
                          -6.185390814060637, 1.195894092176275, 6.642003205790977};
  Scene scene = readSceneText(chainOf(
      "a, s, b",
      "  s: {mass: 0.7, inertia: 0.1, pin: [0.3, 0.1], joint: {type: prismatic, axis: [1, 0.2]},\n"
      "      initial: {position: 0.4, velocity: -1}}\n"
      "springs:\n"
      "  coil: {link: a, ground: [-1, 1], stiffness: 30, damping: 2, rest_length: 0.5}\n"
      "  rope: {link: b, point: [0.6, 0.1], ground: [2, 1], stiffness: 60, damping: 0.8, rest_length: 1.6, "
      "slack: true}\n"
      "base: {x: {amplitude: 0.2, frequency: 1.1}}\n"));
  scene.integrator.tolerance = 1e-11;
  for (const char* method : {"dop853", "rodas5p", "radau13", "auto"}) {
    scene.integrator.method = method;
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(1.5)) << simulation.fault();
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(simulation.q()[i], after[i], 1e-7) << method;
      EXPECT_NEAR(simulation.qd()[i], after[3 + i], 1e-6) << method;
    }
    EXPECT_NEAR(simulation.energyBalance().residual, 0, 1e-7) << method;
  }
}

TEST(GroundSprings, OfNoStrengthAreAbsent) {
  const std::string none = "springs: {rope: {link: b, ground: [1, 1], stiffness: 0}}\n";
  Simulation with(readSceneText(chainOf("a, b", none))), without(readSceneText(chainOf("a, b", "")));
  ASSERT_TRUE(with.advanceTo(1) && without.advanceTo(1));
  EXPECT_EQ(with.q(), without.q());
  EXPECT_EQ(with.statistics().evaluations, without.statistics().evaluations);
}

/// Where the recursion for joints of any kind runs anyway, a trace of a spring changes no bit.
TEST(GroundSprings, OfATraceChangeNothing) {
  const std::string joints =
      chainOf("x, a, b", "  x: {mass: 2, joint: {type: prismatic}, initial: {velocity: 1}}\n");
  const std::string trace = "springs: {rope: {link: b, ground: [1, 1], stiffness: 1.0e-200}}\n";
  for (const char* method : {"dopri5", "rodas5p", "radau13", "rk4"}) {
    const auto endOf = [&](const std::string& text) {
      Scene scene = readSceneText(text);
      scene.integrator.method = method;
      Simulation simulation(scene);
      EXPECT_TRUE(simulation.advanceTo(0.5)) << simulation.fault();
      return std::pair(simulation.q(), simulation.qd());
    };
    EXPECT_EQ(endOf(joints + trace), endOf(joints)) << method;
  }
}

TEST(GroundSprings, LetRodas5pTakeLongStepsWhereTheyAreStiff) {
  const auto stepsOf = [](const char* method) {
    Scene scene =
        readSceneText(chainOf("a, b",
                              "springs: {rope: {link: b_2, ground: [1, 1], stiffness: 1.0e+6, damping: "
                              "1.0e+5}, strut: {link: b_4, ground: [-1, 0], stiffness: 1.0e+6, damping: "
                              "1.0e+5, rest_length: 2}}\n",
                              4));
    scene.integrator.method = method;
    scene.integrator.tolerance = 1e-6;
    Simulation simulation(scene);
    EXPECT_TRUE(simulation.advanceTo(1)) << simulation.fault();
    return simulation.statistics().steps;
  };
  EXPECT_LT(10 * stepsOf("rodas5p"), stepsOf("dopri5"));
}

// ---- Equilibria --------------------------------------------------------------------------------------

/// The largest acceleration of a scene at rest.
double leftOver(const Scene& scene) {
  Simulation simulation(scene);
  Eigen::VectorXd qdd(scene.chain.size());
  simulation.accelerations(qdd.data());
  return qdd.cwiseAbs().maxCoeff();
}

TEST(GroundSprings, HangABodyOnARail) {
  // m g = k x
  const Scene scene = readSceneText(
      "{chain: [body], gravity: [0, -10], links: {body: {mass: 2, joint: {type: prismatic, axis: [0, 1]}}}, "
      "springs: {rope: {link: body, ground: [0, 3], stiffness: 40, rest_length: 2, slack: true}}, start: "
      "rest}");
  EXPECT_NEAR(scene.q[0], 3 - 2 - 0.5, 1e-12);
}

TEST(GroundSprings, HoldAPendulumUpright) {
  // An inverted pendulum between two springs falls over if they are soft: the spring's moment about the pin
  // is 2 k h² θ, that of the weight m g l θ.
  const auto angleWith = [](const char* stiffness) {
    return readSceneText(
               std::string("{chain: [rod], gravity: [0, -10], links: {rod: {mass: 1, inertia: 0.1, "
                           "com: [0, 1], pin: [0, 2], initial: {angle: 0.2}}}, springs: {one: {link: "
                           "rod, point: [0, 2], ground: [100, 2], rest_length: 99, stiffness: ") +
               stiffness +
               "}, other: {link: rod, point: [0, 2], ground: [-100, 2], rest_length: 99, stiffness: " +
               stiffness + "}}, start: rest}")
        .q[0];
  };
  EXPECT_NEAR(angleWith("1.4"), 0, 1e-8);
  EXPECT_GT(std::abs(angleWith("1.0")), 0.1);
}

TEST(GroundSprings, HaveEquilibriaOfChains) {
  const std::string rest = "start: rest\n";
  for (const auto& [names, links] :
       {std::pair("a, b", ""),
        {"x, a, b", "  x: {mass: 2, joint: {type: prismatic, stiffness: 3}}\n"},
        {"a, s, b",
         "  s: {mass: 0.7, inertia: 0.1, pin: [0.3, 0.1], joint: {type: prismatic, stiffness: 90}}\n"}}) {
    for (const int repeat : {1, 5}) {
      SCOPED_TRACE(names);
      const std::string last = repeat > 1 ? "b_5" : "b";
      const Scene scene = readSceneText(chainOf(names, links + springsOf("a", last) + rest, repeat));
      EXPECT_LT(leftOver(scene), 1e-8);
      // Downhill: it is a minimum, from which a push does not lead away.
      Scene pushed = scene;
      for (std::size_t i = 0; i < pushed.q.size(); ++i)
        pushed.q[i] += 0.01 * std::cos(static_cast<double>(i));
      const std::vector<double> again = equilibriumOf(pushed, 0, pushed.q);
      for (std::size_t i = 0; i < again.size(); ++i) EXPECT_NEAR(again[i], scene.q[i], 1e-7) << i;
    }
  }
  const Scene held =
      readSceneText(chainOf("a, b", springsOf("a", "b_3") + "tip: {pin: [1.1, 0.3]}\n" + rest, 3));
  EXPECT_LT(leftOver(held), 1e-8);
}

/// A carriage held at rest: the base carries its weight and the spring's force, about the ground pin.
TEST(GroundSprings, PullACarriageWhoseBaseTakesTheMoment) {
  Simulation simulation(readSceneText(
      "{chain: [cart], gravity: [0, -10], links: {cart: {mass: 2, com: [0.1, 0], joint: {type: prismatic, "
      "drive: "
      "{offset: 0.2}}}}, springs: {coil: {link: cart, point: [0.3, 0.4], ground: [0.5, 2.4], stiffness: 30, "
      "rest_length: 0.5}}}"));
  const BaseWrench wrench = simulation.baseWrench();
  EXPECT_NEAR(wrench.force.x, 0, 1e-12);
  EXPECT_NEAR(wrench.force.y, -20 + 45, 1e-12);
  EXPECT_NEAR(wrench.torque, 0.3 * -20 + 0.5 * 45, 1e-12);
}

// ---- Scenes ------------------------------------------------------------------------------------------

TEST(GroundSprings, AreJudged) {
  Link link{"a", 1, 1, {}, {1, 0}};
  link.springs = {{"rope", {0, 0}, {1, NAN}, 0, -1, -2, true}};
  try {
    Chain chain({link}, {{"j"}}, {0, -9.81});
    FAIL() << "a chain with a faulty spring is made";
  } catch (const Refused& refused) {
    EXPECT_EQ(toString(refused.faults()),
              "links/a/springs/rope/ground/1: expected a number in m, got nan; "
              "links/a/springs/rope/stiffness: expected a number > 0 N/m of a slack spring, got 0; "
              "links/a/springs/rope/damping: expected a number >= 0 N s/m, got -1; "
              "links/a/springs/rope/rest_length: expected a number > 0 m of a slack spring, got -2");
  }
}

TEST(GroundSprings, HaveNoTaylorSeries) {
  try {
    readSceneText(chainOf("a, b", springsOf("a", "b") + "integrator: {method: taylor}\n"));
    FAIL() << "taylor is taken";
  } catch (const Refused& refused) {
    EXPECT_EQ(
        toString(refused.faults()),
        "integrator/method: expected another method than taylor, as there is no Taylor series with 6 ground "
        "springs, got \"taylor\"");
  }
}

}  // namespace
}  // namespace planar_chain
