/// Scenes at the edges: of mass, length, speed, number of links and time. Each against quadruple precision,
/// an exact solution or a published value; by the default method, if nothing else is said.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "planar_chain/value.h"
#include "support/known_chains.h"
#include "support/reference_data.h"

namespace planar_chain {
namespace {

using test::pi;

/// NaN when one is NaN, which no bound passes.
double largestDifference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double difference = std::abs(a[i] - b[i]);
    if (std::isnan(difference)) return difference;
    largest = std::max(largest, difference);
  }
  return largest;
}

std::vector<double> absolute(std::vector<double> relative) {
  for (std::size_t i = 1; i < relative.size(); ++i) relative[i] += relative[i - 1];
  return relative;
}

std::vector<double> relative(std::vector<double> absolute) {
  for (std::size_t i = absolute.size() - 1; i > 0; --i) absolute[i] -= absolute[i - 1];
  return absolute;
}

// ---- Mass, length, speed: quadruple precision ------------------------------------------------------

class Extreme : public testing::TestWithParam<const char*> {};

TEST_P(Extreme, ErrorIsToleranceTimesGrowth) {
  // The bound of trajectory_test, and a thousand tolerances of the motion. Measured: 0.006 of the former.
  const std::string name = GetParam();
  Scene scene = test::referenceScene("extremes/" + name + ".yaml");
  std::vector<double> q, qd;
  double end = 0, rounding = 0;
  for (const test::Row& row : test::referenceTable("extremes/" + name + ".csv")) {
    (row.text("quantity") == "q" ? q : qd).push_back(row.number("value"));
    rounding = std::max(rounding, row.number("rounding"));
    end = row.number("t");
  }
  const double growth = std::max(1.0, std::ldexp(rounding, 53));
  const double turned = std::max(1.0, largestDifference(q, scene.q));
  const double sped = std::max(1.0, largestDifference(qd, scene.qd));
  for (const double tolerance : {1e-8, 1e-9, 1e-10}) {
    scene.integrator.tolerance = tolerance;
    Simulation simulation(scene);
    const double scale = 1 + std::abs(simulation.energy().potential) + simulation.energy().kinetic;
    ASSERT_TRUE(simulation.advanceTo(end)) << simulation.fault();
    ASSERT_EQ(simulation.q().size(), q.size());
    const double angle = largestDifference(simulation.q(), q), rate = largestDifference(simulation.qd(), qd);
    EXPECT_LE(std::max(angle, rate), tolerance * growth / 4) << tolerance;
    EXPECT_LE(angle, 1e3 * tolerance * turned) << tolerance;
    EXPECT_LE(rate, 1e3 * tolerance * sped) << tolerance;
    EXPECT_LE(std::abs(simulation.energyBalance().residual), tolerance * scale) << tolerance;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Extreme,
                         testing::Values("masses_down", "masses_up", "massless_link", "lengths_down",
                                         "lengths_up", "spin", "heavy", "points"),
                         [](const auto& scene) { return std::string(scene.param); });

// ---- The pendulum --------------------------------------------------------------------------------

/// Of ω0² = g/l, let go at rest at φ0 from hanging: φ after t, by sin φ/2 = k cd(ω0 t, k), k = sin φ0/2, and
/// the arithmetic-geometric mean (Abramowitz and Stegun, 16.4).
double swing(double phi0, double w0, double t) {
  const long double k = std::sin(phi0 / 2.0L);
  std::vector<long double> a{1}, c{k};
  long double b = std::cos(phi0 / 2.0L), phi = static_cast<long double>(w0) * t;
  while (c.back() > 1e-19L) {
    const long double mean = (a.back() + b) / 2;
    c.push_back((a.back() - b) / 2);
    b = std::sqrt(a.back() * b);
    a.push_back(mean);
    phi *= 2;
  }
  phi *= a.back();
  for (std::size_t i = a.size() - 1; i > 0; --i) phi = (phi + std::asin(c[i] / a[i] * std::sin(phi))) / 2;
  const long double kSn = k * std::sin(phi);
  return static_cast<double>(2 * std::asin(k * std::cos(phi) / std::sqrt(1 - kSn * kSn)));
}

TEST(Pendulum, OfAMillionSeconds) {
  // 15,758 swings of 1 km and 0.01 rad, to 1e-4 of the amplitude. Errors of the energy shift the phase ever
  // faster; measured: 7e-8.
  Scene scene = test::beads(1, 1000, {9.81, 0});
  scene.q = {0.01};
  scene.integrator.tolerance = 1e-10;
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(1e6));
  EXPECT_NEAR(simulation.q()[0], swing(0.01, std::sqrt(9.81e-3), 1e6), 1e-6);
}

TEST(Pendulum, FallsFromTheTop) {
  // From rest at ψ0 from the top, tan ψ/4 = ψ0/8 exp(ω0 t), but for O(ψ0²). The fall multiplies errors by
  // 1/ψ0, and what turns its angle of about π/2 into one from the top is rounded to 1e-16: 1e-10 of ψ0.
  const double w0 = std::sqrt(9.81), psi0 = 1e-6;
  const long double top = 1.57079632679489661923L;
  Scene scene = test::beads(1, 1, {0, -9.81});
  scene.q = {pi / 2 + psi0};
  const auto exactPsi0 = static_cast<double>(scene.q[0] - top);
  scene.integrator.tolerance = 1e-12;
  Simulation simulation(scene);
  for (const double t : {1., 2., 3., 4., 5.}) {
    ASSERT_TRUE(simulation.advanceTo(t));
    const double psi = 4 * std::atan(exactPsi0 / 8 * (std::exp(w0 * t) + std::exp(-w0 * t)));
    EXPECT_NEAR((simulation.q()[0] - pi / 2) / psi, 1, 1e-8) << t;
  }
}

TEST(Pendulum, BalancedAtTheTopFallsWhenRoundingSaysSo) {
  // fl(π/2) is ψ0 = 6e-17 before the top. The doubles there are 2.2e-16 apart, so until the angle leaves the
  // first one, it falls as if it were at ψ0 still: by 0.1 s too late. Steps of 0.01 s, as no error estimate
  // sees anything so small. What follows is the separatrix, ψ̇ = 2 ω0 sin ψ/2.
  const double w0 = std::sqrt(9.81), psi0 = 6.123e-17;
  Scene scene = test::beads(1, 1, {0, -9.81});
  scene.q = {pi / 2};
  Simulation simulation(scene);
  for (int k = 1; k <= 1250; ++k) ASSERT_TRUE(simulation.advanceTo(k * 0.01));
  const double psi = pi / 2 - simulation.q()[0];
  const double late = 12.5 - std::log(8 * std::tan(psi / 4) / psi0) / w0;
  EXPECT_GT(late, 0);
  EXPECT_LT(late, 0.15);
  EXPECT_NEAR(-simulation.qd()[0] / (2 * w0 * std::sin(psi / 2)), 1, 1e-10);

  // Where the top is a number of the machine, nothing moves.
  scene = test::beads(3, 1, {-9.81, 0});
  Simulation still(scene);
  ASSERT_TRUE(still.advanceTo(100));
  EXPECT_EQ(still.q(), scene.q);
}

TEST(Pendulum, OnAThreadOfBeads) {
  // A tip 2e8 times a bead, struck where it hangs straight: it swings as if the thread were rigid, as what
  // the beads' own weight bends is of the order (n m/M)². From the lowest point: a quarter period later.
  constexpr double g = 9.81, rate = 1.5, tolerance = 1e-6;
  for (const int n : {20, 200}) {
    const double l = 1. / n;
    Scene scene = test::beads(n, l, {g, 0});
    std::vector<Link> links = scene.chain.links();
    links.back().mass = 2e8;
    scene.chain = Chain(links, scene.chain.joints(), {g, 0});
    scene.qd[0] = rate;
    double inertia = 0, moment = 0;
    for (int i = 1; i <= n; ++i) {
      const double m = links[static_cast<std::size_t>(i - 1)].mass;
      inertia += m * i * l * i * l;
      moment += m * i * l;
    }
    const double w0 = std::sqrt(moment * g / inertia), k = rate / (2 * w0);
    const double quarter = std::comp_ellint_1(k) / w0;
    scene.integrator.tolerance = tolerance;
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(0.5)) << simulation.fault();
    std::vector<LinkMotion> motions(static_cast<std::size_t>(n));
    simulation.linkMotions(motions.data());
    const Vec2d tip = motions.back().com;
    EXPECT_NEAR(std::atan2(tip.y, tip.x), swing(2 * std::asin(k), w0, 0.5 - quarter), tolerance) << n;
  }
}

// ---- Ten thousand links --------------------------------------------------------------------------

/// The angles of links whose pins are off a straight line by w_0 = 0 … w_n, small.
template <class Deflection>
std::vector<double> anglesOf(Deflection w, int n, double l) {
  std::vector<double> theta;
  for (int j = 1; j <= n; ++j) theta.push_back(static_cast<double>((w(j) - w(j - 1)) / l));
  return theta;
}

TEST(TenThousandLinks, SpinAsARigidRod) {
  Scene scene = test::beads(10000, 1e-4, {});
  scene.qd[0] = 2;
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(1));
  for (const double theta : absolute(simulation.q())) EXPECT_NEAR(theta, 2, 1e-11);
  for (const double omega : absolute(simulation.qd())) EXPECT_NEAR(omega, 2, 1e-11);
}

TEST(TenThousandLinks, SpinWithAWave) {
  // The second mode (limits_test.cpp), w = j³ − (3 n (n + 1) − 1)/5 j, has the frequency √5 Ω for any n.
  // What is not linear is of the order of the square of its amplitude.
  constexpr double spin = 2, amplitude = 1e-5;
  for (const int n : {100, 10000}) {
    Scene scene = test::beads(n, 1. / n, {});
    const double N = static_cast<double>(n) * (n + 1);
    const auto w = [&](double j) { return amplitude * j * (j * j - (3 * N - 1) / 5) / (N * n); };
    const std::vector<double> mode = anglesOf(w, n, 1. / n);
    scene.q = relative(mode);
    scene.qd[0] = spin;
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(1));
    const std::vector<double> theta = absolute(simulation.q());
    double worst = 0;
    for (std::size_t j = 0; j < mode.size(); ++j) {
      worst = std::max(worst, std::abs(theta[j] - (spin + mode[j] * std::cos(std::sqrt(5.) * spin))));
    }
    EXPECT_LE(worst, 1e-9);
  }
}

TEST(TenThousandLinks, HangAndSwingInTheirFirstMode) {
  // Half a period of u_i = L_i(x) (known_chains.h) turns it round.
  constexpr double amplitude = 1e-3;
  for (const int n : {100, 10000}) {
    Scene scene = test::beads(n, 1. / n, {9.81, 0});
    const long double x = test::hangingFrequencySquared(n, test::besselZeros[0]);
    const std::vector<long double> L = test::laguerre(n, x);
    const auto w = [&](int j) { return amplitude * L[static_cast<std::size_t>(n - j)]; };
    const std::vector<double> mode = anglesOf(w, n, 1. / n);
    scene.q = relative(mode);
    scene.integrator.tolerance = 1e-6;
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(pi / static_cast<double>(std::sqrt(x * 9.81L * n))));
    const std::vector<double> theta = absolute(simulation.q());
    double worst = 0;
    for (std::size_t j = 0; j < mode.size(); ++j) worst = std::max(worst, std::abs(theta[j] + mode[j]));
    EXPECT_LE(worst, 1e-8);
  }
}

TEST(TenThousandLinks, BendIntoACircleUnderAMoment) {
  // A clamped, damped bar comes to rest where each joint bends by M/k, however far that is from straight. The
  // moment begins late: the last of 10,000 links follows it within 1e-16 s, less than the clock can tell.
  for (const int n : {100, 1000, 10000}) {
    Scene scene = test::jointedBar(n, 0.5);
    Load load;
    load.name = "moment";
    load.link = n - 1;
    load.moment = 1;
    load.start = 1;
    scene.loads = {load};
    scene.integrator.tolerance = n < 10000 ? 1e-6 : 1e-4;
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(20)) << simulation.fault();
    const std::vector<double> theta = absolute(simulation.q());
    double worst = 0;
    for (int j = 0; j < n; ++j)
      worst = std::max(worst, std::abs(theta[static_cast<std::size_t>(j)] - (j + 0.5) / n));
    EXPECT_LE(worst, 1e-8);
  }
}

// ---- Beyond the numbers ------------------------------------------------------------------------

TEST(Torques, WhoseWorkIsNotFiniteEndTheRunWithAReason) {
  // They cancel, so that the motion is calm: no series and no error estimate shows them.
  const std::string link = ": {mass: 1, inertia: 0.0833, com: [0.5, 0], pin: [1, 0], initial: {angle: ";
  const std::string load = ": {joint: b_joint, start: 0.5, stop: 0.51, torque: ";
  Scene scene = readSceneText("{chain: [a, b], links: {a" + link + "0.3}}, b" + link + "0.5}}}, loads: {one" +
                              load + "1.0e308}, other" + load + "-1.0e308}}}");
  for (const char* method : {"auto", "taylor", "dop853", "radau13"}) {
    scene.integrator.method = method;
    Simulation simulation(scene);
    int row = 0;
    while (row < 100 && simulation.advanceTo(0.01 * row)) ++row;  // a fault must not be a loop without end
    EXPECT_EQ(row, 51) << method;
    EXPECT_NE(simulation.fault().find("the motion leaves the finite numbers"), std::string::npos)
        << method << ": " << simulation.fault();
  }
}

// ---- Published -----------------------------------------------------------------------------------

TEST(FoldedChain, FallsFasterThanFreely) {
  // Half of the thread hangs down, half up beside it: let go, its end falls in 0.8472 of the time of free
  // fall, n → ∞. The error is about 1.2/n: 0.85903 at n = 101, 0.85377 at n = 201.
  double fall[2];
  for (const int which : {0, 1}) {
    const int n = which == 0 ? 101 : 201;
    Scene scene = test::beads(n, 1. / n, {1, 0});
    scene.q[static_cast<std::size_t>(n / 2)] = scene.q[static_cast<std::size_t>(n / 2 + 1)] = pi / 2;
    scene.integrator.tolerance = 1e-6;
    Simulation simulation(scene);
    std::vector<LinkMotion> motions(static_cast<std::size_t>(n));
    const auto speed = [&] {
      simulation.linkMotions(motions.data());
      return motions.back().velocity.x;
    };
    ASSERT_TRUE(simulation.advanceTo(1));
    double before = speed(), now = before;
    while (now > 0 && simulation.time() < 2) {
      before = now;
      ASSERT_TRUE(simulation.advanceTo(simulation.time() + 1e-3));
      now = speed();
    }
    fall[which] = (simulation.time() - 1e-3 * now / (now - before)) / std::sqrt(2.);
    EXPECT_LE(std::abs(simulation.energyBalance().residual), 1e-6);
    EXPECT_GT(fall[which], 0.8472);
  }
  EXPECT_NEAR((201 * fall[1] - 101 * fall[0]) / 100, 0.8472, 0.002);
}

/// A cart on a spring, with a pendulum and perhaps a stop, of this length, m.
Scene cartOfLength(double length, bool stops, const std::string& method) {
  const auto of = [&](double size, double power = 1) { return toText(size * std::pow(length, power)); };
  Scene scene = readSceneText("{chain: [cart, arm], gravity: [0, -" + of(9.81) +
                              "], links: {cart: {mass: 1, joint: {type: prismatic, stiffness: 1.0e+4" +
                              (stops ? ", stop_stiffness: 1.0e+5, upper: " + of(0.1) : "") +
                              "}, initial: {position: -" + of(0.2) + ", velocity: " + of(1) +
                              "}}, arm: {mass: 0.5, inertia: " + of(0.02, 2) + ", com: [" + of(0.4) +
                              ", 0], pin: [" + of(0.8) + ", 0], initial: {angle: 0.5, velocity: 1}}}}");
  scene.integrator.method = method;
  scene.integrator.tolerance = 1e-10;
  return scene;
}

// Rounding and errors of a slide count as shares of the reach: with those of a metre, these erred by up to
// 2e-7, or gave up.
TEST(Extreme, SlidesOfTinyMachinesAreAsExactAsOfLargeOnes) {
  constexpr double length = 1e-6;
  for (const char* method : {"auto", "radau13", "dop853", "rodas5p", "taylor"}) {
    for (const bool stops : {false, true}) {
      Simulation large(cartOfLength(1, stops, method)), tiny(cartOfLength(length, stops, method));
      ASSERT_TRUE(large.advanceTo(2) && tiny.advanceTo(2)) << method << ": " << tiny.fault();
      EXPECT_NEAR(tiny.q()[0] / length, large.q()[0], 1e-9) << method << stops;
      EXPECT_NEAR(tiny.q()[1], large.q()[1], 1e-9) << method << stops;
    }
  }
}

/// A driven cart with a rod between stops, in units of T s.
Scene driven(double T, const std::string& method) {
  const auto of = [&](double size, double power) { return toText(size * std::pow(T, power)); };
  Scene scene = readSceneText(
      "{chain: [cart, rod], gravity: [0, " + of(-9.81, -2) +
      "], links: {cart: {mass: 3, joint: {type: prismatic, drive: {amplitude: 0.24, frequency: " +
      of(2.319, -1) +
      "}}}, rod: {mass: 2.38, inertia: 0.042, com: [0.159, 0], pin: [0.379, 0], initial: {angle: -0.39}, "
      "joint: "
      "{stiffness: " +
      of(11, -2) + ", rest_angle: 0.22, lower: -0.49, upper: 0.39, stop_stiffness: " + of(500, -2) + "}}}}");
  scene.integrator.method = method;
  scene.integrator.tolerance = 1e-10;
  return scene;
}

// A rate of 1e5 m/s is exact to 1e-11 m/s, not to 1e-15 of a short chain's reach: that took steps of 1e-14 s.
TEST(Extreme, FastCartsOfShortChainsDoNotStall) {
  constexpr double T = 1.1e-5;
  for (const char* method : {"auto", "radau13", "dop853", "rodas5p"}) {
    Simulation slow(driven(1, method)), fast(driven(T, method));
    ASSERT_TRUE(slow.advanceTo(1)) << slow.fault();
    int row = 0;
    while (row < 100 && fast.advanceTo(row * 0.01 * T) && fast.statistics().steps < 100000) ++row;
    ASSERT_EQ(row, 100) << method << ": " << fast.statistics().steps << " steps, " << fast.fault();
    ASSERT_TRUE(fast.advanceTo(T));
    EXPECT_NEAR(fast.q()[1], slow.q()[1], 1e-8) << method;
  }
}

}  // namespace
}  // namespace planar_chain
