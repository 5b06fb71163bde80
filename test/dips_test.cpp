/// Stops that are reached and left again within one step, against scipy with events:
/// test/reference/dips/dip.py.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "effects/passing.h"
#include "planar_chain/simulation.h"
#include "random_scene.h"
#include "reference_data.h"

namespace planar_chain {
namespace {

struct Dip {
  const char* name;
  std::array<double, 3> q;  ///< at 0.3 s
};

class Dips : public testing::TestWithParam<Dip> {};

std::vector<double> after(Scene scene, const char* method, double tolerance, int rows) {
  scene.integrator.method = method;
  scene.integrator.tolerance = tolerance;
  Simulation simulation(scene);
  for (int k = 1; k <= rows; ++k) EXPECT_TRUE(simulation.advanceTo(0.3 * k / rows)) << simulation.fault();
  return simulation.q();
}

TEST_P(Dips, AreSeenByEveryMethod) {
  for (const double beside : {0.0, 1e-9, 1e-6}) {
    Scene scene = test::referenceScene(std::string("dips/") + GetParam().name + ".yaml");
    scene.q[1] += beside;
    // A step ends within the dip.
    const std::vector<double> exact = after(scene, "dopri5", 1e-12, 300);
    if (beside == 0) {
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(exact[i], GetParam().q[i], 1e-10);
    }
    for (const char* method : {"auto", "taylor", "dop853", "dopri5", "rodas5p", "radau13", "ros34pw2"}) {
      for (const double tolerance : {1e-3, 1e-4, 1e-6, 1e-8}) {
        for (const int rows : {1, 6}) {
          const std::vector<double> found = after(scene, method, tolerance, rows);
          for (std::size_t i = 0; i < 3; ++i)
            EXPECT_NEAR(found[i], exact[i], 3 * tolerance) << method << " to " << tolerance << ", " << rows
                                                           << " rows, " << beside << " rad beside the limit";
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Dips,
                         testing::Values(Dip{"hard", {0.940196662562, -1.53308802352, 0.19532430213}},
                                         Dip{"soft", {-1.391405711924, -1.152291724824, 0.194536727158}}),
                         [](const auto& one) { return std::string(one.param.name); });

/// A motor that comes to its torque–speed line and leaves it within a step.
struct Pulse {
  int joint;
  double torque, start, end;
};

std::vector<double> motorsAfter(const char* scene, const std::vector<Pulse>& pulses, double end,
                                const char* method, double tolerance, int rows) {
  Scene read = test::referenceScene(std::string("dips/") + scene + ".yaml");
  read.integrator.method = method;
  read.integrator.tolerance = tolerance;
  Simulation simulation(read, 4);
  for (const Pulse& pulse : pulses)
    EXPECT_TRUE(simulation.addTorque(pulse.joint, pulse.torque, pulse.end - pulse.start, pulse.start));
  for (int k = 1; k <= rows; ++k) EXPECT_TRUE(simulation.advanceTo(end * k / rows)) << simulation.fault();
  std::vector<double> state = simulation.q();
  state.insert(state.end(), simulation.qd().begin(), simulation.qd().end());
  return state;
}

TEST(Motors, ComeToTheirLineAndLeaveItWithinAStep) {
  const std::vector<Pulse> one{{0, -0.5, 0, 0.2}, {0, 0.1, 0.2, 1}},
      three{{2, 8, 0, 0.05}, {2, -0.1, 0.2, 0.3}};
  const std::vector<double> exact = motorsAfter("motors", three, 0.5, "dopri5", 1e-12, 500);
  for (const char* method : {"auto", "taylor", "dop853", "dopri5", "rodas5p", "radau13"}) {
    for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
      for (const int rows : {1, 5, 50}) {
        SCOPED_TRACE(std::string(method) + " to " + std::to_string(tolerance) + ", " + std::to_string(rows) +
                     " rows");
        const std::vector<double> found = motorsAfter("motor", one, 0.25, method, tolerance, rows);
        EXPECT_NEAR(found[0], 1.242007270245, 0.1 * tolerance);  // test/reference/dips/motor.py
        EXPECT_NEAR(found[1], -16.00115176003, 20 * tolerance);
        const std::vector<double> others = motorsAfter("motors", three, 0.5, method, tolerance, rows);
        for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(others[i], exact[i], 0.1 * tolerance);
      }
    }
  }
}

// ---- Polynomials -----------------------------------------------------------------------------------

double valueOf(const Bezier& b, double s) {
  double sum = 0, binomial = 1;
  for (std::size_t k = 0; k < 7; ++k) {
    sum += binomial * std::pow(s, k) * std::pow(1 - s, 6 - k) * b[k];
    binomial *= (6.0 - static_cast<double>(k)) / (static_cast<double>(k) + 1);
  }
  return sum;
}

/// g = Σ c_k s^k of degree 5, and the top that is added.
TEST(BezierPoints, AreThoseOfThePolynomialAndOfItsSlope) {
  test::Random random(3);
  for (int k = 0; k < 20; ++k) {
    std::array<double, 6> c;
    for (double& one : c) one = random.between(-1, 1);
    const double top = random.between(-5, 5);
    const auto derivative = [&](int order, double s) {
      double sum = 0;
      for (int j = order; j < 6; ++j) {
        double factor = c[static_cast<std::size_t>(j)];
        for (int i = 0; i < order; ++i) factor *= j - i;
        sum += factor * std::pow(s, j - order);
      }
      return sum;
    };
    const Bezier g = bezier({derivative(0, 0), derivative(1, 0), derivative(2, 0)},
                            {derivative(0, 1), derivative(1, 1), derivative(2, 1)}, top);
    const Bezier slope = slopeOf(g);
    for (const double s : {0.0, 0.2, 0.5, 0.9, 1.0}) {
      const double r = s - s * s;
      EXPECT_NEAR(valueOf(g, s), derivative(0, s) + top * r * r * r, 1e-13);
      EXPECT_NEAR(valueOf(slope, s), derivative(1, s) + 3 * top * r * r * (1 - 2 * s), 1e-12);
      EXPECT_NEAR(valueOf(halves(g).first, s), valueOf(g, s / 2), 1e-13);
      EXPECT_NEAR(valueOf(halves(g).second, s), valueOf(g, (1 + s) / 2), 1e-13);
    }
  }
}

/// −x at the start and −y at the end, and a bulge between.
TEST(BezierPoints, TellWhereThePolynomialIsAbove) {
  const auto line = [](double x, double y, double top) {
    return bezier({-x, x - y, 0}, {-y, x - y, 0}, top);
  };
  EXPECT_EQ(above(line(1, 1, 63), 0), 1) << "(s − s²)³ is at most 1/64";
  EXPECT_LT(above(line(1, 1, 65), 0), 1);
  EXPECT_EQ(above(line(1, 1, 65), 0.02), 1);
  const double s = above(line(1e-6, 1, 100), 0);
  EXPECT_GT(valueOf(line(1e-6, 1, 100), s), 0);
  // Above at 1, too: before it rises there at last.
  EXPECT_EQ(aboveBefore(line(1, -1, 0), 0), 1);
  const Bezier twice{-0.01, 1, -2, -2, -2, -2, 3};
  const double first = aboveBefore(twice, 0);
  EXPECT_LT(first, 0.3);
  EXPECT_GT(valueOf(twice, first), 0);
}

}  // namespace
}  // namespace planar_chain
