/// Closed chains that get straight or folded, and go on along their own branch.
///
///     IFToMM's benchmark A02, one loop    θ̈ = −9.81 · 6/5 cos θ, integrated to 1e-14
///     parallelograms                      the pendulum of one link with the same energies
///     equal-armed slider-cranks           their one freedom: (A + B sin² θ) θ̈ = −(½ B sin 2θ θ̇² + S g cos θ)
///     a tip on a circle                   the pendulum in the frame that turns with it
///
/// A parallelogram with cranks of length a, a coupler of length b and its tip b beside the ground pin: all
/// cranks turn by θ, and the coupler stays parallel to the ground. So it is a pendulum with
///
///     J = m_1 r_1² + I_1 + m_2 a² + m_3 (a − r_3)² + I_3        S = m_1 r_1 + m_2 a + m_3 (a − r_3)
///
/// and in every joint θ turns alike, up to its sign: stiffness, damping and friction add up.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "reference/extrapolation.h"

namespace planar_chain {
namespace {

constexpr double a = 0.5;

std::string link(double mass, double inertia, double com, double pin, const std::string& joint, double angle,
                 double velocity) {
  return "{mass: " + toText(mass) + ", inertia: " + toText(inertia) + ", com: [" + toText(com) +
         ", 0], pin: [" + toText(pin) + ", 0], joint: {" + joint + "}, initial: {angle: " + toText(angle) +
         ", velocity: " + toText(velocity) + "}}\n";
}

/// What a parallelogram and its pendulum have in common, and the joints of both.
struct Case {
  const char* name;
  double angle, velocity;
  std::string first, second, third, of;  ///< the joints of the parallelogram, and of the pendulum
  std::string more = "";
  std::string tip = "{pin: [1.2, 0]}";
  double seconds = 5;
};

std::string parallelogram(const Case& of) {
  const double turned = of.angle - 3.14159265358979312;
  return "chain: [a, b, c]\ntip: " + of.tip +
         "\nlinks:\n  a: " + link(1, 0.03, 0.2, a, of.first, of.angle, of.velocity) +
         "  b: " + link(2, 0.1, 0.5, 1.2, of.second, -of.angle, -of.velocity) +
         "  c: " + link(1.5, 0.05, 0.1, a, of.third, turned, of.velocity) + of.more;
}

std::string pendulum(const Case& of) {
  const double J = 1 * 0.04 + 0.03 + 2 * a * a + 1.5 * 0.16 + 0.05, S = 1 * 0.2 + 2 * a + 1.5 * 0.4,
               mass = 4.5;
  return "chain: [a]\nlinks:\n  a: " +
         link(mass, J - S * S / mass, S / mass, a, of.of, of.angle, of.velocity) + of.more;
}

Scene sceneOf(const std::string& text, const char* method, double tolerance) {
  Scene scene = readSceneText(text);
  scene.integrator.method = method;
  scene.integrator.tolerance = tolerance;
  return scene;
}

/// Angle and rate of a joint.
std::vector<double> endOf(const std::string& text, const char* method, double tolerance, double seconds,
                          std::size_t joint = 0) {
  const Scene scene = sceneOf(text, method, tolerance);
  Simulation simulation(scene);
  EXPECT_TRUE(simulation.advanceTo(seconds)) << method << " at " << tolerance << ": " << simulation.fault();
  EXPECT_LT(simulation.closureError(), 1e-12 * scene.chain.reach());
  return {simulation.q()[joint], simulation.qd()[joint]};
}

const std::vector<Case> cases{
    {"round", 1, 12, "", "", "", "", "", "{pin: [1.2, 0]}", 3},
    {"swing", 1, 2, "", "", "", ""},
    {"springs", 1, 9, "stiffness: 8, rest_angle: 0.3", "damping: 0.05", "damping: 0.1",
     "stiffness: 8, rest_angle: 0.3, damping: 0.15"},
    {"friction", 1, 12, "friction: 1.5", "", "", "friction: 1.5"},
    {"damped", 1, 9, "", "damping: 20", "damping: 1", "damping: 21",
     "loads: {push: {joint: a_joint, torque: 60}}\n", "{pin: [1.2, 0]}", 3},
    {"loads", 1, 12, "", "", "", "",
     "loads: {shake: {joint: a_joint, torque: 3, frequency: 1.3}, push: {joint: a_joint, torque: 2, start: "
     "0.5, "
     "stop: 0.6}}\n"},
    {"moving", 1, 12, "", "", "", "",
     "base: {x: {amplitude: 0.3, frequency: 0.8}, y: {amplitude: 0.1, frequency: 1.1}}\n",
     "{pin: {x: {amplitude: 0.3, frequency: 0.8, offset: 1.2}, y: {amplitude: 0.1, frequency: 1.1}}}"},
};

class ChangePoints : public testing::TestWithParam<Case> {};

/// The growth of these motions is below 100: the largest, of a chain that turns round for 5 s, is 60.
TEST_P(ChangePoints, AreGoneThroughByEveryMethod) {
  const Case& of = GetParam();
  const std::vector<double> exact = endOf(pendulum(of), "dop853", 1e-13, of.seconds);
  for (const char* method : {"auto", "dopri5", "dop853", "rodas5p", "radau13", "ros34pw2"}) {
    for (const double tolerance : {1e-4, 1e-7, 1e-10}) {
      if (tolerance < 1e-9 && method == std::string("ros34pw2")) continue;  // its order is low
      const std::vector<double> end = endOf(parallelogram(of), method, tolerance, of.seconds);
      EXPECT_NEAR(end[0], exact[0], 100 * tolerance) << method << " at " << tolerance;
      EXPECT_NEAR(end[1], exact[1], 1000 * tolerance) << method << " at " << tolerance;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Parallelograms, ChangePoints, testing::ValuesIn(cases),
                         [](const auto& of) { return std::string(of.param.name); });

/// Nothing acts, so the cranks turn at their first rate. An error of the rate grows with the time that is
/// left.
TEST(ChangePoint, OfAParallelogramWithoutGravity) {
  const Case free{"", 1, 5, "", "", "", "", "gravity: [0, 0]\n"};
  for (const char* method : {"auto", "dopri5", "dop853", "taylor", "rodas5p", "radau13"})
    EXPECT_NEAR(endOf(parallelogram(free), method, 1e-11, 5)[0], 26, 2e-10) << method;
}

/// https://www.iftomm-multibody.org/benchmark, problem A02: uniform rods, l = m = 1.
TEST(ChangePoint, OfTheBenchmarkA02) {
  const std::string rod = "{mass: 1, inertia: 0.08333333333333333, com: [0.5, 0], pin: [1, 0], initial: ";
  const std::string text = "chain: [a, b, c]\ntip: {pin: [1, 0]}\nlinks:\n  a: " + rod +
                           "{angle: 1.5707963267948966, velocity: -1}}\n  b: " + rod +
                           "{angle: -1.5707963267948966, velocity: 1}}\n  c: " + rod +
                           "{angle: -1.5707963267948966, velocity: -1}}\n";
  for (const char* method : {"auto", "dopri5", "dop853", "taylor", "rodas5p", "radau13"})
    EXPECT_NEAR(endOf(text, method, 1e-10, 10)[0], -30.3439449710, 1e-8) << method;
}

/// The tip goes round the ground pin at Ω, and the coupler with it. With ψ between the cranks and the
/// coupler, J ψ̈ = −Ω² (m_2 a r_2 + m_3 (a − r_3) b) sin ψ.
TEST(ChangePoint, OfAParallelogramThatTurns) {
  const double frequency = 0.7, Omega = 2 * 3.14159265358979312 * frequency;
  Case turning{"",
               1,
               3 + Omega,
               "",
               "",
               "",
               "",
               "gravity: [0, 0]\n",
               "{pin: {x: {amplitude: 1.2, frequency: 0.7, phase: 1.5707963267948966}, y: {amplitude: 1.2, "
               "frequency: 0.7}}}"};
  Scene scene = sceneOf(parallelogram(turning), "dop853", 1e-10);
  scene.qd = {3 + Omega, -3, 3};
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(5)) << simulation.fault();

  const double J = 0.86, S = 2 * a * 0.5 + 1.5 * 0.4 * 1.2;
  const double exact = endOf("chain: [a]\ngravity: [" + toText(Omega * Omega) +
                                 ", 0]\nlinks:\n  a: " + link(4, J - S * S / 4, S / 4, a, "", 1, 3),
                             "dop853", 1e-13, 5)[0];
  EXPECT_NEAR(simulation.q()[0] - Omega * 5, exact, 1e-8);
}

/// (A + B sin² θ) θ̈ = −(½ B sin 2θ θ̇² + S g cos θ)
double oneFreedom(double A, double B, double S, double angle, double rate, double seconds) {
  const auto f = [&](long double, const std::vector<long double>& y, std::vector<long double>& slope) {
    const long double sine = std::sin(y[0]);
    slope = {y[1], -(B / 2 * std::sin(2 * y[0]) * y[1] * y[1] + S * 9.81L * std::cos(y[0])) /
                       (A + B * sine * sine)};
  };
  std::vector<long double> y{angle, rate};
  Extrapolation<long double, decltype(f)>(f, 8, 1e-16).integrate(0, seconds, y);
  return static_cast<double>(y[0]);
}

TEST(ChangePoint, OfSliderCranksWithEqualArms) {
  const double r1 = 0.2, r2 = 0.15, m1 = 1, m2 = 0.8, I1 = 0.03, I2 = 0.02, piston = 0.4;
  const std::string onLine =
      "chain: [crank, rod]\ntip: {line: {point: [0, 0], direction: [1, 0]}}\nlinks:\n  crank: " +
      link(m1, I1, r1, a, "", 0.5, 6) + "  rod: " + link(m2, I2, r2, a, "", -1, -12);
  const double exact = oneFreedom(m1 * r1 * r1 + I1 + m2 * (a - r2) * (a - r2) + I2, 4 * m2 * a * r2,
                                  m1 * r1 + m2 * (a - r2), 0.5, 6, 4);
  const double pi = 3.14159265358979312, place = 2 * a * std::cos(0.5);
  const std::string withPiston =
      "chain: [piston, rod, crank]\ntip: {pin: [0, 0]}\nlinks:\n  piston: {mass: 0.4, pin: [0, 0], joint: "
      "{type: "
      "prismatic, axis: [1, 0]}, initial: {position: " +
      toText(place) + ", velocity: " + toText(-2 * a * std::sin(0.5) * 6) +
      "}}\n  rod: " + link(m2, I2, r2, a, "", pi - 0.5, -6) + "  crank: " + link(m1, I1, r1, a, "", 1, 12);
  const double second =
      oneFreedom(m1 * (a - r1) * (a - r1) + I1 + m2 * r2 * r2 + I2,
                 4 * piston * a * a + m2 * (4 * a * a - 4 * a * r2), m2 * r2 + m1 * (a - r1), 0.5, 6, 4);
  for (const char* method : {"auto", "dop853", "rodas5p", "radau13"}) {
    EXPECT_NEAR(endOf(onLine, method, 1e-10, 4)[0], exact, 1e-8) << method;
    EXPECT_NEAR(pi - endOf(withPiston, method, 1e-10, 4, 1)[0], second, 1e-8) << method;
  }
}

/// Steps may end within a leap, and measurements be taken there. A state that is saved there goes on as it
/// would.
TEST(ChangePoint, IsGoneThroughInShortSteps) {
  const Case& of = cases[0];
  Simulation simulation(
      sceneOf(parallelogram(of) + "sensors: {encoders: {joints: [a_joint], rate: 5000}}\n", "auto", 1e-10), 0,
      true);
  Simulation exact(
      sceneOf(pendulum(of) + "sensors: {encoders: {joints: [a_joint], rate: 5000}}\n", "dop853", 1e-13), 0,
      true);
  std::unique_ptr<Simulation> twin;
  for (int k = 1; k <= 300; ++k) {
    ASSERT_TRUE(simulation.advanceTo(2e-3 * k) && exact.advanceTo(2e-3 * k)) << simulation.fault();
    EXPECT_NEAR(simulation.q()[0], exact.q()[0], 1e-9) << k;
    EXPECT_NEAR(simulation.q()[0] + simulation.q()[1], 0, 1e-9) << k;
    const std::vector<Measurement> found = simulation.measure(), expected = exact.measure();
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i)
      EXPECT_NEAR(found[i].values[0], expected[i].values[0], 1e-9) << k;
    if (twin) {
      ASSERT_TRUE(twin->advanceTo(2e-3 * k));
      EXPECT_EQ(twin->q(), simulation.q()) << k;
    }
    if (k % 10 == 0) twin = simulation.copy();
  }
}

/// Where the cranks hang straight down, they come to rest in a change point.
TEST(ChangePoint, StopsAChainThatComesToRestInIt) {
  const Case hanging{"", 0.3, 0, "damping: 0.3", "", "", "", "gravity: [9.81, 0]\n"};
  const Case resting{"", 0, 0, "", "", "", "", ""};
  for (const Case& of : {hanging, resting}) {
    for (const char* method : {"auto", "dop853", "rodas5p"}) {
      Simulation simulation(sceneOf(parallelogram(of), method, 1e-8));
      EXPECT_FALSE(simulation.advanceTo(200)) << method;
      EXPECT_NE(simulation.fault().find("has come to rest straight or folded"), std::string::npos)
          << simulation.fault();
      for (const double rate : simulation.qd()) EXPECT_NEAR(rate, 0, 1e-5);
    }
  }
}

TEST(ChangePoint, HasNoDerivatives) {
  Simulation simulation(sceneOf(parallelogram(cases[0]), "auto", 1e-8));
  try {
    simulation.transition(1);
    FAIL() << "derivatives beyond a change point";
  } catch (const std::domain_error& refused) {
    EXPECT_NE(std::string(refused.what()).find("no derivatives beyond"), std::string::npos) << refused.what();
  }
}

}  // namespace
}  // namespace planar_chain
