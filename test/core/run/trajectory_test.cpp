/// Whole trajectories against known answers: exact ones, those of independent programs, a published one, and
/// integrations in quadruple precision by other equations and another method (reference/README.md).

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "planar_chain/simulation.h"
#include "support/reference_data.h"

namespace planar_chain {
namespace {

constexpr double pi = 3.14159265358979323846;

/// Near the least that double allows: here the program's error is a few roundings, times the scene's growth.
constexpr double tight = 1e-12;

/// n equal links along +x, at rest.
Scene uniformChain(int n, const Link& link, double firstStiffness, double stiffness, Vec2d gravity) {
  std::vector<Link> links;
  std::vector<Joint> joints;
  for (int i = 1; i <= n; ++i) {
    links.push_back(link);
    links.back().name = "link_" + std::to_string(i);
    joints.push_back({"joint_" + std::to_string(i), i == 1 ? firstStiffness : stiffness, 0, 0});
  }
  const std::vector<double> zero(static_cast<std::size_t>(n), 0.0);
  return {Chain(links, joints, gravity), zero, zero, {}, {"dopri5", tight, 1e-3}, {}, 0};
}

const Link pointMass{"", 1, 0, {1, 0}, {1, 0}};
constexpr Vec2d earth{0, -9.81};

std::vector<double> absolute(std::vector<double> relative) {
  std::partial_sum(relative.begin(), relative.end(), relative.begin());
  return relative;
}

// ---- Exact ---------------------------------------------------------------------------------------

TEST(Pendulum, FollowsJacobisEllipticFunctions) {
  for (const test::Row& row : test::referenceTable("pendulum.csv")) {
    if (row.text("quantity") == "period") continue;
    SCOPED_TRACE(row.text("motion") + " " + row.text("quantity") + " at t = " + row.text("t"));
    Scene scene = uniformChain(1, pointMass, 0, 0, earth);
    const bool turns = row.text("motion") == "over_the_top";
    if (turns) scene.q = {-pi / 2}, scene.qd = {8};
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(row.number("t")));
    // An error of the energy shifts the period, so errors grow with the time; rates change by 10 rad/s².
    const bool isAngle = row.text("quantity") == "q";
    const double value = isAngle ? simulation.q()[0] : simulation.qd()[0];
    EXPECT_NEAR(value, row.number("value"), (isAngle ? 10 : 50) * tight * (1 + row.number("t")));
  }
}

TEST(Pendulum, ComesBackAfterItsPeriod) {
  // At the turning point q̇ = −g (t − period): an error of the period shows in q̇ alone.
  for (const test::Row& row : test::referenceTable("pendulum.csv")) {
    if (row.text("quantity") != "period" || row.text("motion") != "horizontal") continue;
    Simulation simulation(uniformChain(1, pointMass, 0, 0, earth));
    ASSERT_TRUE(simulation.advanceTo(row.number("value")));
    EXPECT_NEAR(simulation.q()[0], 0, 10 * tight);
    EXPECT_NEAR(simulation.qd()[0] / 9.81, 0, 10 * tight);
    EXPECT_NEAR(simulation.time(), 2.367842, 5e-7);
  }
}

// ---- Other programs and publications --------------------------------------------------------------

TEST(IndependentPrograms, UniformRodsLetGoLying) {
  // Two integrators agreed on these to 7e-11.
  for (const test::Row& row : test::referenceTable("rods.csv")) {
    const Link rod{"", 1, 1. / 12, {0.5, 0}, {1, 0}};
    Simulation simulation(uniformChain(row.index("n"), rod, 0, 0, earth));
    ASSERT_TRUE(simulation.advanceTo(row.number("t")));
    Vec2d tip;
    for (const double theta : absolute(simulation.q())) tip += Rotation<double>::of(theta) * rod.pin;
    EXPECT_NEAR(tip.x, row.number("tip_x"), 7e-11) << row.index("n") << " rods";
    EXPECT_NEAR(tip.y, row.number("tip_y"), 7e-11) << row.index("n") << " rods";
  }
}

TEST(IndependentPrograms, DoublePendulumOfPointMasses) {
  // Two integrators agreed on these to 3e-11.
  for (const test::Row& row : test::referenceTable("double_pendulum.csv")) {
    Simulation simulation(uniformChain(2, pointMass, 0, 0, earth));
    ASSERT_TRUE(simulation.advanceTo(row.number("t")));
    const std::vector<double> theta = absolute(simulation.q());
    EXPECT_NEAR(theta[0], row.number("theta_1"), 3e-11) << row.text("t");
    EXPECT_NEAR(theta[1], row.number("theta_2"), 3e-11) << row.text("t");
  }
}

TEST(Published, BeamOfTheTestSetForInitialValueProblems) {
  constexpr int n = 40;
  constexpr double l = 1. / n, m = 1. / n;
  Scene scene = uniformChain(n, {"", m, m * l * l / 4, {l / 2, 0}, {l, 0}}, 80, 40, {});
  // φ = 1.5 sin² t = 0.75 − 0.75 cos 2t up to t = π
  Load steady;
  steady.name = "steady";
  steady.link = n - 1;
  steady.point = {l, 0};
  steady.force = {-0.75, 0.75};
  steady.stop = pi;
  Load swaying = steady;
  swaying.name = "swaying";
  swaying.law = Sine{1 / pi, -pi / 2};
  scene.loads = {steady, swaying};

  const std::vector<test::Row> rows = test::referenceTable("beam.csv");
  ASSERT_EQ(rows.size(), 2U * n);
  // At these tolerances the angles came within 2.5e-12 and the rates within 1.2e-8: the beam's fastest waves,
  // at 6400 rad/s, are small and are what errs.
  for (const IntegratorSettings& settings :
       {IntegratorSettings{"dopri5", 1e-8, 0}, IntegratorSettings{"dop853", 1e-7, 0},
        IntegratorSettings{"auto", 1e-8, 0}}) {
    scene.integrator = settings;
    scene.integrator.rateTolerance = settings.tolerance;
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(5));
    const std::vector<double> theta = absolute(simulation.q()), omega = absolute(simulation.qd());
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_NEAR(theta[i], rows[i].number("value"), 1e-11) << settings.method;
      EXPECT_NEAR(omega[i], rows[n + i].number("value"), 5e-8) << settings.method;
    }
  }
}

// ---- Quadruple precision -------------------------------------------------------------------------

struct Reference {
  Scene scene;
  double end = 0;
  std::vector<double> q, qd;
  /// What rounding the scene to double may change of q or q̇: no program in double comes surely closer.
  double rounding = 0;
  /// By how much the scene multiplies errors: rounding over 2^-53.
  double growth() const { return std::max(1.0, std::ldexp(rounding, 53)); }

  explicit Reference(const std::string& name)
      : scene(test::referenceScene("trajectories/" + name + ".yaml")) {
    for (const test::Row& row : test::referenceTable("trajectories/" + name + ".csv")) {
      (row.text("quantity") == "q" ? q : qd).push_back(row.number("value"));
      rounding = std::max(rounding, row.number("rounding"));
      end = row.number("t");
    }
  }
};

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

/// NaN when one is NaN.
double median(std::vector<double> a) {
  for (const double x : a) {
    if (std::isnan(x)) return x;
  }
  std::nth_element(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(a.size() / 2), a.end());
  return a[a.size() / 2];
}

class QuadruplePrecision : public testing::TestWithParam<const char*> {};

TEST_P(QuadruplePrecision, ErrorIsToleranceTimesGrowth) {
  // The tolerance bounds what a second of steps adds; the scene multiplies it. Measured: at most 0.12 of
  // that. And the energy balance, which needs no reference, is kept to the tolerance.
  Reference reference(GetParam());
  for (const IntegratorSettings& settings :
       {IntegratorSettings{"dopri5", 1e-8, 0}, IntegratorSettings{"dop853", 1e-10, 0},
        IntegratorSettings{"taylor", 1e-8, 0}, IntegratorSettings{"rodas5p", 1e-8, 0},
        IntegratorSettings{"auto", 1e-8, 0}}) {
    reference.scene.integrator = settings;
    Simulation simulation(reference.scene);
    const double scale = 1 + std::abs(simulation.energy().potential) + simulation.energy().kinetic;
    ASSERT_TRUE(simulation.advanceTo(reference.end)) << settings.method << ": " << simulation.fault();
    ASSERT_EQ(simulation.q().size(), reference.q.size());
    const double bound = settings.tolerance * reference.growth() / 4;
    EXPECT_LE(largestDifference(simulation.q(), reference.q), bound) << settings.method;
    EXPECT_LE(largestDifference(simulation.qd(), reference.qd), bound) << settings.method;
    EXPECT_LE(std::abs(simulation.energyBalance().residual), settings.tolerance * scale) << settings.method;
  }
}

TEST_P(QuadruplePrecision, IsReachedToWhatDoubleAllows) {
  // Some thousand steps round once each; √4000 of these, added at random, are 63. The median of runs that
  // round differently, as chance makes one of them three times better or worse. Measured: dopri5 at most 13,
  // auto, which takes fewer and longer steps, at most 23; a single run may come out ten times worse.
  Reference reference(GetParam());
  RecordProperty("growth", std::to_string(reference.growth()));
  for (const std::string method : {"dopri5", "auto"}) {
    std::vector<double> angles, rates;
    for (const double nearly : {1.0, 1.01, 1.02, 1.03, 1.04}) {
      reference.scene.integrator = {method, nearly * tight, 0};
      Simulation simulation(reference.scene);
      ASSERT_TRUE(simulation.advanceTo(reference.end)) << simulation.fault();
      ASSERT_EQ(simulation.q().size(), reference.q.size());
      angles.push_back(largestDifference(simulation.q(), reference.q) / reference.rounding);
      rates.push_back(largestDifference(simulation.qd(), reference.qd) / reference.rounding);
    }
    const double angle = median(angles);
    const double rate = median(rates);
    EXPECT_LE(angle, 60) << method;
    EXPECT_LE(rate, 60) << method;
    RecordProperty(method + "_angle_error_in_roundings", std::to_string(angle));
    RecordProperty(method + "_rate_error_in_roundings", std::to_string(rate));
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, QuadruplePrecision,
                         testing::Values("pendulum_1", "double_2", "damped_2", "springs_3", "push_3",
                                         "sine_4", "ramp_4", "everything_5", "points_6", "heavy_tip_8",
                                         "stiff_6", "spin_12", "swing_12", "rope_30", "rope_100"),
                         [](const auto& scene) { return std::string(scene.param); });

// ---- Laws over whole trajectories ------------------------------------------------------------------

TEST(Law, TimeRunsBackwards) {
  // There and back, each way within ErrorIsToleranceTimesGrowth's bound; the way back multiplies the error
  // of the way there once more, but from a state that the scene has not chosen.
  for (const char* name : {"double_2", "points_6", "spin_12", "rope_30"}) {
    Reference reference(name);
    reference.scene.loads.clear();
    reference.scene.integrator = {"dopri5", tight, 0};
    Simulation simulation(reference.scene);
    ASSERT_TRUE(simulation.advanceTo(reference.end));
    std::vector<double> back = simulation.qd();
    for (double& rate : back) rate = -rate;
    simulation.setState(simulation.q(), back);
    ASSERT_TRUE(simulation.advanceTo(2 * reference.end));
    back = simulation.qd();
    for (double& rate : back) rate = -rate;
    EXPECT_LE(largestDifference(simulation.q(), reference.scene.q), tight * reference.growth()) << name;
    EXPECT_LE(largestDifference(back, reference.scene.qd), tight * reference.growth()) << name;
  }
}

TEST(Law, AngularMomentumGrowsByTheMomentAboutThePin) {
  // No gravity, the first joint free: springs, dampers and torques inside change nothing; a moment M on a
  // body adds M t.
  Reference reference("everything_5");
  Scene& scene = reference.scene;
  std::vector<Joint> joints = scene.chain.joints();
  joints[0].stiffness = joints[0].damping = 0;
  scene.chain = Chain(scene.chain.links(), joints, {});
  Load inside, outside;
  inside.name = "inside";
  inside.joint = 2;
  inside.torque = 3;
  inside.law = Sine{1.25, 0.5};
  outside.name = "outside";
  outside.link = 3;
  outside.moment = 0.75;
  scene.integrator = {"dopri5", tight, 0};
  for (const double moment : {0.0, outside.moment}) {
    scene.loads = {inside};
    if (moment != 0) scene.loads.push_back(outside);
    Simulation simulation(scene);
    const auto momentum = [&] {
      const std::vector<double> theta = absolute(simulation.q()), omega = absolute(simulation.qd());
      return angularMomentum(scene.chain, theta.data(), omega.data());
    };
    const double before = momentum();
    const double energy = simulation.energy().total();
    ASSERT_TRUE(simulation.advanceTo(1.5));
    EXPECT_NEAR(momentum() - before, moment * 1.5, 10 * tight * (1 + std::abs(before)));
    EXPECT_GT(std::abs(simulation.energy().total() - energy), 0.1) << "nothing happened";
  }
}

}  // namespace
}  // namespace planar_chain
