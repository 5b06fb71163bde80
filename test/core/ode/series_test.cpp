/// Taylor series of motions, and the method that goes along them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/dynamics.h"
#include "effects/commands.h"
#include "lanes/kernel.h"
#include "lanes/motion_series.h"
#include "ode/methods.h"
#include "ode/taylor.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "report/benchmark/counted_system.h"
#include "support/random_scene.h"
#include "test_system.h"

namespace planar_chain {
namespace {

constexpr int order = 16;

/// A scene at a time when all of its loads act, and its series there.
struct Around {
  explicit Around(Scene given, double at = 0.1)
      : scene(std::move(given)), n(scene.chain.size()), t(at), dynamics(scene), y(start()) {
    dynamics.enter(t);
    dynamics.enterState(t, y.data());
    dynamics.reserveSeries(order);
    c.resize(static_cast<std::size_t>(2 * n * (order + 1)));
    dynamics.series(t, y.data(), nullptr, order, c.data());
  }

  std::vector<double> start() const {
    std::vector<double> state(static_cast<std::size_t>(dynamics.size()));
    scene.chain.coordinates().toAbsolute(scene.q.data(), state.data());
    scene.chain.coordinates().toAbsolute(scene.qd.data(), state.data() + n);
    return state;
  }

  double coefficient(int k, int i) const { return c[static_cast<std::size_t>(2 * n * k + i)]; }

  /// The first h at which the last two terms are below 1e-14 of the rates'.
  double reach() const {
    double h = 1;
    for (const int k : {order - 1, order}) {
      double last = 0, rates = 1;
      for (int i = 0; i < 2 * n; ++i) {
        last = std::max(last, k * std::abs(coefficient(k, i)));
        rates = std::max(rates, std::abs(coefficient(1, i)));
      }
      if (last > 0) h = std::min(h, std::pow(1e-14 * rates / last, 1.0 / (k - 1)));
    }
    return h;
  }

  /// How far the polynomial is from obeying the equations of motion at h, against the rates there.
  double violation(double h) {
    std::vector<double> at = y, slope(static_cast<std::size_t>(2 * n)), f(y.size());
    for (int i = 0; i < 2 * n; ++i) {
      double value = 0, rate = 0;
      for (int k = order; k > 0; --k) {
        rate = rate * h + k * coefficient(k, i);
        value = (value + coefficient(k, i)) * h;
      }
      at[static_cast<std::size_t>(i)] += value;
      slope[static_cast<std::size_t>(i)] = rate;
    }
    dynamics.derivative(t + h, at.data(), f.data());
    double worst = 0, size = 1;
    for (std::size_t i = 0; i < slope.size(); ++i) {
      worst = std::max(worst, std::abs(slope[i] - f[i]));
      size = std::max(size, std::abs(f[i]));
    }
    return worst / size;
  }

  Scene scene;
  int n;
  double t;
  Dynamics dynamics;
  std::vector<double> y, c;
};

class SeriesOf : public testing::TestWithParam<int> {};

TEST_P(SeriesOf, AnyChainObeysItsEquationsOfMotion) {
  // The equations are those of derivative(), which others test. Measured: at most 5e-13.
  const int n = GetParam();
  for (unsigned seed = 1; seed <= 12; ++seed) {
    for (const test::With with : {test::With{false, false, false}, test::With{true, false, false},
                                  test::With{true, true, false}, test::With{true, true, true}}) {
      Around around(test::randomScene(n, seed, with));
      const double h = around.reach();
      ASSERT_GT(h, 1e-4);
      for (const double share : {-1.0, -0.5, 0.25, 0.5, 1.0}) {
        EXPECT_LT(around.violation(share * h), 1e-11)
            << n << " links, seed " << seed << ", h = " << share * h;
      }
    }
  }
}

TEST_P(SeriesOf, AnyChainUnderTorquesAloneObeysThem) {
  const int n = GetParam();
  Scene scene = test::randomScene(n, 5);
  for (Load& load : scene.loads) load.link = Load::none;
  Around around(scene);
  EXPECT_LT(around.violation(around.reach()), 1e-11);
}

TEST_P(SeriesOf, PushedStopsObeysThem) {
  const int n = GetParam();
  Scene scene = test::randomScene(n, 6);
  std::vector<Joint> joints = scene.chain.joints();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    joints[i].upper = scene.q[i] - 0.01;
    joints[i].stopStiffness = 300;
    joints[i].stopDamping = 2;
    scene.qd[i] = std::abs(scene.qd[i]);
  }
  scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
  Around around(scene);
  ASSERT_TRUE(around.dynamics.effects().act());
  EXPECT_LT(around.violation(0.5 * around.reach()), 1e-11);
}

/// Rotors, sliding friction, driven joints and a base, with springs, dampers and loads; each joint is
/// prismatic with this probability.
Scene machine(int n, unsigned seed, double prismatic) {
  Scene scene = test::randomScene(n, seed);
  std::vector<Joint> joints = scene.chain.joints();
  test::Random random(seed);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    joints[i].isPrismatic = random.between(0, 1) < prismatic;
    joints[i].axis = random.vector(1);
    if (i % 3 == 0) joints[i].others.emplace_back("rotor_inertia", 0.1 + 0.2 * static_cast<double>(i % 2));
    if (i % 4 == 1) joints[i].others.emplace_back("friction", 0.3);
    if (i % 5 == 1) joints[i].others.emplace_back("drag", 0.02);
    if (i % 4 != 2) continue;
    joints[i].stiffness = joints[i].damping = 0;
    scene.drives.push_back({static_cast<int>(i), i % 8 == 2
                                                     ? MotionLaw::sine(0.3, 0.7, 0.2, scene.q[i])
                                                     : MotionLaw::spline({-0.5, 0, 0.6}, {0, 0.2, -0.1})});
  }
  scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
  scene.base = BaseLaws{MotionLaw::sine(0.1, 1.3, 0.4, 0), MotionLaw::spline({-1, 0.05, 2}, {0, 0.3, -0.2}),
                        MotionLaw::sine(0.4, 0.5, 1, 0.2)};
  return scene;
}

TEST_P(SeriesOf, MachinesObeyThem) {
  const int n = GetParam();
  for (const double prismatic : {0.0, 0.5}) {
    for (unsigned seed = 1; seed <= 12; ++seed) {
      Around around(machine(n, seed, prismatic));
      ASSERT_TRUE(around.dynamics.hasSeries());
      const double h = around.reach();
      ASSERT_GT(h, 1e-4);
      for (const double share : {-0.5, 0.25, 0.5, 1.0}) {
        EXPECT_LT(around.violation(share * h), 1e-11)
            << n << " links, seed " << seed << ", h = " << share * h << ", prismatic " << prismatic;
      }
    }
  }
}

/// A boom, a link that slides on it, and a tool. slider: more keys of the slider's joint.
std::string telescope(const std::string& slider, const std::string& loads) {
  return "chain: [boom, slider, tool]\nlinks:\n  boom: {mass: 1, inertia: 0.1, com: [0.4, 0], pin: [0.8, 0], "
         "initial: {angle: 0.5, velocity: 1}, joint: {damping: 0.2}}\n  slider: {mass: 0.5, inertia: 0.02, "
         "com: "
         "[0.1, 0.05], pin: [0.3, 0], joint: {type: prismatic, axis: [1, 0.2]" +
         slider +
         "}}\n  tool: {mass: 0.3, inertia: 0.01, com: [0.2, 0], pin: [0.4, 0], initial: {angle: -1}, joint: "
         "{stiffness: 3}}\n" +
         loads;
}

TEST(Taylor, MovesPrismaticJointsAsOtherMethodsDo) {
  const std::string wind =
      "loads:\n  wind: {link: slider, force: [2, 1], point: [0.1, 0.2], moment: 0.3, frequency: 1.5}\n  "
      "push: "
      "{joint: slider_joint, torque: 3, frequency: 0.7}\n  hang: {link: tool, force: [0, -2], point: [0.4, "
      "0]}\n";
  const std::string cart =
      "chain: [cart, pole]\nlinks:\n  cart: {mass: 1, joint: {type: prismatic, rotor_inertia: 0.6}}\n  pole: "
      "{mass: 0.4, inertia: 0.01, com: [0.25, 0], pin: [0.5, 0], initial: {angle: 0.4}}\n";
  const std::string carriages =
      "chain: [x, y, pole]\nlinks:\n  x: {mass: 1, joint: {type: prismatic, stiffness: 5}}\n  y: {mass: 0.5, "
      "joint: {type: prismatic, axis: [0.3, 1], stiffness: 30, damping: 0.2}}\n  pole: {mass: 0.4, inertia: "
      "0.01, com: [0.25, 0], pin: [0.5, 0], initial: {angle: 0.4, velocity: 2}}\n";
  const std::string floating =
      "chain: [a, b]\nlinks:\n  a: {mass: 1, inertia: 0.1, com: [0.3, 0], pin: [0.6, 0], joint: {type: "
      "floating}, initial: {angle: 0.3, velocity: 2}}\n  b: {mass: 0.5, inertia: 0.05, com: [0.3, 0], pin: "
      "[0.6, 0], initial: {angle: 1}}\n";
  for (const std::string& text :
       {telescope("", ""), telescope(", stiffness: 200, damping: 2, rest_angle: 0.1", wind),
        telescope(", rotor_inertia: 0.4, drag: 0.3", wind),
        telescope(", drive: {amplitude: 0.1, frequency: 0.8, offset: 0.2}", ""), cart, carriages, floating}) {
    std::vector<std::vector<double>> ends;
    for (const char* method : {"taylor", "dop853", "radau13"}) {
      Scene scene = readSceneText(text);
      scene.integrator.method = method;
      scene.integrator.tolerance = 1e-13;
      Simulation simulation(scene);
      ASSERT_TRUE(simulation.advanceTo(1)) << method << ": " << simulation.fault();
      ends.push_back(simulation.q());
      ends.back().insert(ends.back().end(), simulation.qd().begin(), simulation.qd().end());
    }
    for (const std::vector<double>& other : {ends[1], ends[2]}) {
      for (std::size_t i = 0; i < other.size(); ++i) EXPECT_NEAR(ends[0][i], other[i], 1e-11) << text << i;
    }
  }
}

TEST(Series, OfACartAndItsPoleObeysThem) {
  const std::string bare = R"(
chain: [cart, pole]
links:
  cart: {mass: 0.7, pin: [0.1, 0.2], initial: {position: 0.3, velocity: -0.8}, joint: {type: prismatic, axis: [3, -1]%S}}
  pole: {mass: 0.4, inertia: 0.01, com: [0.3, 0.1], pin: [0.5, 0.0], initial: {angle: 0.9, velocity: 4.0}, joint: {damping: %D}}
)";
  const std::string loads = R"(
loads:
  on_cart: {link: cart, force: [3.0, 1.0], frequency: 2.0}
  on_pole: {link: pole, force: [-1.0, 2.0], point: [0.4, 0.1], moment: 0.2, times: [0.0, 1.0], values: [1.0, 3.0]}
  between: {joint: pole_joint, torque: 0.3, frequency: 3.0}
)";
  const auto with = [&](const std::string& slide, const std::string& damping) {
    std::string text = bare;
    text.replace(text.find("%S"), 2, slide);
    text.replace(text.find("%D"), 2, damping);
    return text;
  };
  for (const std::string& text :
       {with("", "0"), with(", stiffness: 20, damping: 0.4, rest_angle: 0.1", "0.05, drag: 0.02"),
        with("", "0.05") + loads}) {
    Around around(readSceneText(text));
    ASSERT_TRUE(around.dynamics.seriesAreWorthwhile()) << text;
    const double h = around.reach();
    ASSERT_GT(h, 1e-3) << text;
    for (const double share : {-1.0, -0.5, 0.5, 1.0}) EXPECT_LT(around.violation(share * h), 1e-11) << text;
  }
}

TEST(Series, OfACartAndItsPoleIsThatOfTheDenseEquations) {
  // M x + h α = −M d·g − d·Σ′ and h x + J α = −S×g for each order, in long double; Σ′: S̈ as if α were 0.
  const Scene scene = readSceneText(R"(
chain: [cart, pole]
links:
  cart: {mass: 0.7, joint: {type: prismatic, axis: [3, -1]}}
  pole: {mass: 0.4, inertia: 0.01, com: [0.3, 0.1], pin: [0.5, 0.0]}
)");
  using Real = long double;
  const std::size_t most = 36;
  const Link& pole = scene.chain.links()[1];
  const Real dx = scene.chain.joints()[0].axis.x, dy = scene.chain.joints()[0].axis.y, g = 9.81L;
  const Real mx = Real(pole.mass) * Real(pole.com.x), my = Real(pole.mass) * Real(pole.com.y);
  const Real M = 0.7L + 0.4L, J = 0.01L + mx * Real(pole.com.x) + my * Real(pole.com.y);
  std::vector<Real> s{0.3L}, theta{0.9L}, v{-0.8L}, omega{4}, x, c{std::cos(theta[0])},
      sine{std::sin(theta[0])};
  const auto h = [&](Real cosine, Real sineOf) {
    return (mx * cosine - my * sineOf) * dy - (mx * sineOf + my * cosine) * dx;
  };
  for (std::size_t k = 0; k < most; ++k) {
    const Real next = static_cast<Real>(k) + 1;
    const auto product = [&](std::size_t last, const std::vector<Real>& a, const std::vector<Real>& b) {
      Real sum = 0;
      for (std::size_t j = 0; j <= k; ++j) sum += a[j] * b[last - j];
      return sum;
    };
    c.push_back(-product(k, omega, sine) / next);
    sine.push_back(product(k, omega, c) / next);
    Real along = -next * h(product(k + 1, omega, c), product(k + 1, omega, sine));
    Real turning = -g * (mx * c[k] - my * sine[k]);
    for (std::size_t j = 0; j < k; ++j) turning -= x[j] * h(c[k - j], sine[k - j]);
    if (k == 0) along -= M * g * dy;
    const Real h0 = h(c[0], sine[0]), determinant = M * J - h0 * h0;
    x.push_back((J * along - h0 * turning) / determinant);
    s.push_back(v[k] / next);
    theta.push_back(omega[k] / next);
    v.push_back(x[k] / next);
    omega.push_back((M * turning - h0 * along) / determinant / next);
  }

  for (const simd::Kernel* kernel : simd::kernels()) {
    for (std::size_t last = 1; last < most; ++last) {
      constexpr double untouched = 7;
      MotionSeries series(scene.chain, static_cast<int>(last), *kernel);
      std::vector<double> found(4 * last + 8, untouched);
      std::copy_n(std::vector<double>{0.3, 0.9, -0.8, 4}.begin(), 4, found.begin());
      series.find(static_cast<int>(last), {nullptr, nullptr, nullptr, {0, 9.81}}, nullptr, found.data());
      for (std::size_t k = 1; k <= last; ++k) {
        const Real expected[] = {s[k], theta[k], v[k], omega[k]};
        const Real size = std::max(std::abs(v[k]), std::abs(omega[k]));
        for (std::size_t i = 0; i < 4; ++i) {
          EXPECT_NEAR(found[4 * k + i], static_cast<double>(expected[i]), 1e-13 * static_cast<double>(size))
              << kernel->name << ", number " << i << ", order " << k << " of " << last;
        }
      }
      EXPECT_EQ(found[4 * last + 4], untouched);
    }
  }
}

TEST(Series, ThatIsNotFiniteLeavesNoTraceInTheNext) {
  for (const char* slide : {"", ", joint: {type: prismatic}"}) {
    for (const int n : {1, 2, 3, 9}) {
      if (*slide != '\0' && n != 2) continue;
      std::string names, links;
      for (int j = 0; j < n; ++j) {
        const std::string name = "l" + std::to_string(j);
        names += (j > 0 ? ", " : "") + name;
        links += "  " + name + ": {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]" + (j > 0 ? "" : slide) +
                 "}\n";
      }
      const Scene scene = readSceneText("chain: [" + names + "]\nlinks:\n" + links);
      for (const simd::Kernel* kernel : simd::kernels()) {
        const auto find = [&](MotionSeries& series, double rate) {
          std::vector<double> c(static_cast<std::size_t>(2 * n * (order + 1)), 0.3);
          c[static_cast<std::size_t>(2 * n - 1)] = rate;
          series.find(order, {nullptr, nullptr, nullptr, {0, 9.81}}, nullptr, c.data());
          return c;
        };
        MotionSeries used(scene.chain, order, *kernel), fresh(scene.chain, order, *kernel);
        EXPECT_FALSE(std::isfinite(find(used, std::numeric_limits<double>::quiet_NaN()).back()));
        EXPECT_EQ(find(used, 2), find(fresh, 2)) << slide << n << kernel->name;
      }
    }
  }
}

TEST(Series, OfAChainWithAHeldTipObeysThem) {
  const std::string bare = R"(
chain: [crank, coupler, rocker]
tip: {pin: [1.2, 0.0]}
links:
  crank: {mass: 2.0, inertia: 0.05, com: [0.1, 0.0], pin: [0.3, 0.0], initial: {angle: 1.0, velocity: 10.0}%S}
  coupler: {mass: 0.5, inertia: 0.04, com: [0.5, 0.1], pin: [1, 0], initial: {angle: -0.45, velocity: -12.3}%S}
  rocker: {mass: 0.4, inertia: 0.02, com: [0.4, 0.0], pin: [0.8, 0.0], initial: {angle: -1.89, velocity: 4}}
)";
  const std::string loads = R"(
loads:
  push: {link: coupler, force: [3.0, 1.0], point: [0.4, 0.1], frequency: 2.0}
  turn: {joint: crank_joint, torque: 0.3, frequency: 3.0}
)";
  for (const std::string springs : {"", ", joint: {stiffness: 5, damping: 0.1, rest_angle: 0.2}"}) {
    for (const std::string& more : {std::string(), loads}) {
      std::string text = bare + more;
      for (std::size_t at; (at = text.find("%S")) != std::string::npos;) text.replace(at, 2, springs);
      Around around(readSceneText(text));
      ASSERT_TRUE(around.dynamics.seriesAreWorthwhile()) << text;
      const double h = around.reach();
      ASSERT_GT(h, 1e-3) << text;
      for (const double share : {-1.0, -0.5, 0.5, 1.0}) EXPECT_LT(around.violation(share * h), 1e-11) << text;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Links, SeriesOf, testing::Values(1, 2, 3, 4, 5, 9, 16, 40));

TEST(Series, AreTheSameByEveryKernel) {
  for (const int n : {1, 2, 3, 8, 17}) {
    const Scene scene = test::randomScene(n, 3, {false, false, false});
    const Around around(scene);
    for (const simd::Kernel* kernel : simd::kernels()) {
      MotionSeries series(scene.chain, order, *kernel);
      std::vector<double> c(around.c.size());
      std::copy(around.c.begin(), around.c.begin() + 2 * n, c.begin());
      series.find(order, {nullptr, nullptr, nullptr, -1.0 * scene.chain.gravity()}, nullptr, c.data());
      for (int k = 0; k <= order; ++k) {
        double size = 0, worst = 0;
        for (int i = 0; i < 2 * n; ++i) {
          const auto at = static_cast<std::size_t>(2 * n * k + i);
          size = std::max(size, std::abs(around.c[at]));
          worst = std::max(worst, std::abs(c[at] - around.c[at]));
        }
        EXPECT_LE(worst, 1e-11 * size) << kernel->name << ", " << n << " links, order " << k;
      }
    }
  }
}

TEST(Series, OfAPendulumIsTheTextbooksToEveryOrder) {
  // ẍ = −sin x, with s = sin x and c = cos x: k s_k = Σ_{0<j≤k} j x_j c_{k−j}, k c_k = −Σ_{0<j≤k} j x_j
  // s_{k−j} (Hairer, Nørsett, Wanner, section I.8). Each order may be the last: one body's come four at a
  // time.
  constexpr int most = 36;
  std::vector<long double> x{1.3, 0.4}, s{std::sin(x[0])}, c{std::cos(x[0])};
  for (int k = 1; k < most; ++k) {
    long double sine = 0, cosine = 0;
    for (int j = 1; j <= k; ++j) {
      const long double rate = j * x[static_cast<std::size_t>(j)] / k;
      sine += rate * c[static_cast<std::size_t>(k - j)];
      cosine -= rate * s[static_cast<std::size_t>(k - j)];
    }
    x.push_back(-s[static_cast<std::size_t>(k - 1)] / (k * (k + 1)));
    s.push_back(sine);
    c.push_back(cosine);
  }

  const Chain rod({{"rod", 1, 1, {1, 0}, {1, 0}}}, {{"joint"}}, {2, 0});
  for (const simd::Kernel* kernel : simd::kernels()) {
    for (int last = 1; last < most; ++last) {
      constexpr double untouched = 7;
      MotionSeries series(rod, last, *kernel);
      std::vector<double> found(static_cast<std::size_t>(2 * last + 4), untouched);
      found[0] = 1.3;
      found[1] = 0.4;
      series.find(last, {nullptr, nullptr, nullptr, {-2, 0}}, nullptr, found.data());
      for (std::size_t k = 1; k <= static_cast<std::size_t>(last); ++k) {
        const auto size = static_cast<double>(std::max(std::abs(x[k - 1]), std::abs(x[k])));
        EXPECT_NEAR(found[2 * k], static_cast<double>(x[k]), 1e-14 * size)
            << kernel->name << ", order " << k << " of " << last;
      }
      EXPECT_EQ(found[found.size() - 2], untouched);
      EXPECT_EQ(found.back(), untouched);
    }
  }
}

TEST(Series, OfAChainAllAtRestInEquilibriumIsZero) {
  const Scene scene{Chain({{"rod", 1, 0.1, {0, -0.5}, {0, -1}}, {"bob", 1, 0.1, {0, -0.5}, {0, -1}}},
                          {{"a"}, {"b"}}, {0, -9.81}),
                    {0, 0},
                    {0, 0},
                    {},
                    {},
                    {},
                    0};
  const Around around(scene);
  for (const double coefficient : around.c) EXPECT_EQ(coefficient, 0);
}

TEST(Taylor, TakesItsOrderFromTheTolerance) {
  auto f = ode::test::testSystem();
  int last = 0;
  for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    const int own = ode::Taylor(f, tolerance).facts().order;
    EXPECT_GT(own, last);
    last = own;
  }
}

TEST(Taylor, HasTheOrderThatItSays) {
  auto f = ode::test::testSystem();
  const int promised = ode::Taylor(f, 1e-2).facts().order;
  const double coarse = ode::test::errorOfEqualSteps(ode::Taylor(f, 1e-2), 5);
  const double fine = ode::test::errorOfEqualSteps(ode::Taylor(f, 1e-2), 7);
  EXPECT_NEAR(std::log(coarse / fine) / std::log(7.0 / 5), promised, 1);
}

TEST(Taylor, ForeseesTheErrorOfAStep) {
  auto f = ode::test::testSystem();
  ode::Taylor taylor(f, 1e-8);
  const ode::State start = ode::test::testStart();
  for (const double h : {0.1, 0.4}) {
    ASSERT_TRUE(taylor.foresees(start, h));
    const Eigen::VectorXd foreseen = taylor.error();
    taylor.step(0, h, start.y);
    EXPECT_EQ(foreseen, taylor.error());
    EXPECT_GT(foreseen.maxCoeff(), 0);
  }
}

TEST(Taylor, MakesItsStepsAsLongAsTheirErrorsMayBe) {
  auto f = ode::test::testSystem();
  ode::State state = ode::test::testStart();
  const ode::Tolerance tolerance{1e-8, Eigen::ArrayXd::Constant(f.size(), 2)};
  const auto steps = ode::test::adaptiveSteps(std::make_unique<ode::Taylor>(f, 1e-8), tolerance);
  ASSERT_EQ(steps->integrate(state, 2, 2, 100), ode::Outcome::arrived);
  EXPECT_LE(steps->count().accepted, 4);
}

TEST(Taylor, SeesTheErrorWhereItsLastCoefficientVanishes) {
  // sin t² has t^18/9! and no t^19.
  auto f = ode::test::testSystem();
  ode::Taylor taylor(f, 1e-4);
  ASSERT_EQ(taylor.facts().order, 19);
  const double h = 0.3;
  ASSERT_TRUE(taylor.foresees(ode::test::testStart(), h));
  EXPECT_GE(taylor.error()[0], std::pow(h, 18) / 362880);
}

TEST(Taylor, SeesTheErrorWhereOnlyEveryFourthCoefficientIsLeft) {
  // cos t² has orders 0, 4, … 24, 28: neither the last one nor that before.
  auto f = ode::test::testSystem();
  ode::Taylor taylor(f, 1e-10);
  ASSERT_EQ(taylor.facts().order, 27);
  for (const double h : {0.5, 1.0, 1.5}) {
    ASSERT_TRUE(taylor.foresees(ode::test::testStart(), h));
    EXPECT_GE(taylor.error()[1], std::pow(h, 28) / 87178291200) << h;
  }
}

TEST(Taylor, FindsOneSeriesAStepAndNoneForAStepMadeShorter) {
  const Scene scene = test::randomScene(2, 8, {false, false, false});
  Around around(scene);
  ode::Taylor taylor(around.dynamics, 1e-6);
  const Eigen::VectorXd y = Eigen::Map<const Eigen::VectorXd>(around.y.data(), 4);
  const long long before = around.dynamics.evaluations();
  for (const double h : {0.2, 0.1, 0.05}) taylor.step(0, h, y);
  EXPECT_EQ(around.dynamics.evaluations() - before, taylor.facts().order);
  taylor.forget();
  taylor.step(0, 0.05, y);
  EXPECT_EQ(around.dynamics.evaluations() - before, 2 * taylor.facts().order);
}

TEST(Taylor, SumsWorksOnlyWhereSomethingDoesThem) {
  for (const bool hasSprings : {false, true}) {
    const Scene scene = test::randomScene(2, 8, {hasSprings, false, false});
    Dynamics dynamics(
        scene, std::make_unique<CommandEffect>(scene.chain, 1));  // room for a command, so there are works
    dynamics.enter(0);
    benchmarks::CountedSystem counted(dynamics);
    ode::Taylor taylor(counted, 1e-6);
    taylor.step(0, 0.1, Eigen::VectorXd::Constant(dynamics.size(), 0.3));
    EXPECT_EQ(counted.integrals, hasSprings ? taylor.facts().order / 2 + 1 : 0);
    EXPECT_EQ(taylor.increment().tail(2), Eigen::VectorXd::Zero(2));
  }
}

}  // namespace
}  // namespace planar_chain
