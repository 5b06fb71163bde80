/// Chains with prismatic joints: carts, planes, arms that slide out of each other.
///
///     trajectories      against dense equations of Lagrange (reference/ends/make.py), by five methods
///     cart and pole     ω² = (m_c + m) g/(m_c l), and the textbook's A and B
///     inclined rail     a chain at right angles to it keeps its angles, s̈ = −g sin β
///     everything else   q̈ and A agree with kane.h, and the energy balance closes

#include "model/prismatic.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "effects/effect_kind.h"
#include "known_motion.h"
#include "planar_chain/kane.h"
#include "planar_chain/linear_model.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "reference/ends/values.h"

namespace planar_chain {
namespace {

const std::string pole = R"(
  pole: {mass: 0.5, inertia: 0.01, com: [0.4, 0.05], pin: [0.8, 0], joint: {damping: %D1},
         initial: {angle: -1.2, velocity: 0.4}}
  lower: {mass: 0.3, inertia: 0.004, com: [0.2, -0.03], pin: [0.5, 0.1], joint: {stiffness: %K, damping: %D2},
          initial: {angle: 0.7, velocity: -1}}
)";

std::string poles(double d1 = 0, double k = 0, double d2 = 0) {
  std::string text = pole;
  const auto put = [&text](const std::string& mark, double value) {
    text.replace(text.find(mark), mark.size(), std::to_string(value));
  };
  put("%D1", d1);
  put("%K", k);
  put("%D2", d2);
  return text;
}

std::string cart(const std::string& joint = "axis: [1, 0]", const std::string& mass = "2.0") {
  return "chain: [cart, pole, lower]\nlinks:\n  cart: {mass: " + mass +
         ", pin: [0.0, 0.1], joint: {type: prismatic, " + joint +
         "}, initial: {position: 0.1, velocity: 0.2}}" + poles();
}

const std::string tilted =
    "chain: [cart, pole, lower]\nlinks:\n  cart: {mass: 2.0, pin: [0.0, 0.1], initial: {position: 0.1, "
    "velocity: 0.2}, joint: {type: prismatic, axis: [3, -1], stiffness: 30, rest_angle: 0.2, damping: 0.4}}" +
    poles(0.02, 0.5, 0.01);
const std::string plane =
    "chain: [x, y, pole, lower]\nlinks:\n  x: {mass: 2.0, pin: [0.0, 0.1], joint: {type: prismatic, "
    "stiffness: 5}, initial: {position: 0.1, velocity: 0.2}}\n  y: {mass: 0.4, pin: [0.05, 0], com: [0.1, "
    "0.1], joint: {type: prismatic, axis: [0.3, 1], stiffness: 40, damping: 0.3}, initial: {position: -0.2, "
    "velocity: 0.5}}" +
    poles();

const std::string turned =
    "chain: [cart, pole, lower]\nlinks:\n  cart: {mass: 2.0, com: [0.2, -0.1], inertia: 0.3, pin: [0.0, "
    "0.1], initial: "
    "{position: 0.1, velocity: 0.2}, joint: {type: prismatic, stiffness: 20}}" +
    poles(0.05) +
    "base: {x: {amplitude: 0.03, frequency: 1.7}, angle: {amplitude: 0.5, frequency: 0.4, offset: 0.3}}\n";
const std::string turnedPlane =
    "chain: [x, y, pole, lower]\nlinks:\n  x: {mass: 2.0, com: [0.1, 0.2], pin: [0.0, 0.1], joint: {type: "
    "prismatic, "
    "stiffness: 30}, initial: {position: 0.1, velocity: 0.2}}\n  y: {mass: 0.4, pin: [0.05, 0], com: [0.1, "
    "0.1], joint: {type: prismatic, axis: [0.3, 1], stiffness: 40, damping: 0.3}, initial: {position: -0.2, "
    "velocity: 0.5}}" +
    poles() + "base: {y: {amplitude: 0.02, frequency: 1.1}, angle: {amplitude: 0.4, frequency: 0.7}}\n";

const std::string floating =
    "chain: [pole, lower]\nlinks:\n  pole: {mass: 0.5, inertia: 0.01, com: [0.4, 0.05], pin: [0.8, 0], "
    "joint: {type: floating}, initial: {position: [0.5, 1], linear_velocity: [1, 4], angle: -1.2, velocity: "
    "0.4}}\n  lower: {mass: 0.3, inertia: 0.004, com: [0.2, -0.03], pin: [0.5, 0.1], initial: {angle: 0.7, "
    "velocity: -1}}\n";

Eigen::VectorXd vectorOf(const std::vector<double>& numbers) {
  return Eigen::VectorXd::Map(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

// ---- Trajectories ----------------------------------------------------------------------------------

class Trajectory : public testing::TestWithParam<const char*> {};

TEST_P(Trajectory, AgreesWithDenseEquations) {
  for (const test::KnownMotion& known :
       std::initializer_list<test::KnownMotion>{{"level", cart(), reference::level},
                                                {"tilted", tilted, reference::tilted},
                                                {"plane", plane, reference::plane},
                                                {"floating", floating, reference::floating},
                                                {"massless", cart("axis: [1, 0]", "0"), reference::massless},
                                                {"turned", turned, reference::turned},
                                                {"turnedPlane", turnedPlane, reference::turnedPlane}}) {
    test::expectMotion(known, GetParam(), 1e-7);
  }
}

INSTANTIATE_TEST_SUITE_P(By, Trajectory, testing::Values("auto", "dop853", "taylor", "rodas5p", "radau13"));

// ---- Known answers ---------------------------------------------------------------------------------

constexpr double m_c = 1.3, m = 0.4, l = 0.7, g = 9.81;

Scene cartPole(const std::string& more = "") {
  return readSceneText(
      "chain: [cart, pole]\nlinks:\n  cart: {mass: 1.3, joint: {type: prismatic, axis: [1, 0]}}\n  pole: "
      "{mass: 0.4, inertia: 0, com: [0.7, 0], pin: [0.7, 0], initial: {angle: -1.5707963267948966}}\n" +
      more);
}

/// The keys of every kind; a key of one's own, too.
TEST(PrismaticJoints, HaveUnitsOfTheirOwn) {
  for (const EffectKind* kind : effectKinds()) {
    for (const JointKey& key : kind->jointKeys()) {
      const std::string words = inUnitsOfPrismatic(key.range.which);
      EXPECT_EQ(words.find("rad"), std::string::npos) << key.name << ": " << words;
      EXPECT_EQ(words.find("N m"), std::string::npos) << key.name << ": " << words;
    }
  }
}

TEST(CartAndPole, HasTheFrequencyOfBothMasses) {
  const Scene scene = cartPole();
  const LinearModel model = linearModel(scene, 0, vectorOf(scene.q), vectorOf(scene.qd));
  // The pole hangs: δθ̈ = −(m_c + m) g/(m_c l) δθ, s̈ = −m g/m_c δ(slope) …
  EXPECT_NEAR(-model.A(3, 1), (m_c + m) * g / (m_c * l), 1e-12);
  Simulation simulation(cartPole("integrator: {tolerance: 1e-12}"));
  const double amplitude = 1e-4, omega = std::sqrt((m_c + m) * g / (m_c * l));
  simulation.setState({0, -pi / 2 + amplitude}, {0, 0});
  ASSERT_TRUE(simulation.advanceTo(5));
  EXPECT_NEAR(simulation.q()[1] + pi / 2, amplitude * std::cos(5 * omega), 1e-10);
  // the centre of mass stays
  EXPECT_NEAR((m_c + m) * simulation.q()[0] + m * l * std::cos(simulation.q()[1]),
              m * l * std::sin(amplitude), 1e-12);
}

TEST(CartAndPole, HasTheTextbooksAAndB) {
  const Scene scene = cartPole();
  const Eigen::Vector2d up(0.3, pi / 2), still(0, 0);
  const LinearModel model = linearModel(scene, 0, up, still);
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  A(0, 2) = A(1, 3) = 1;
  A(2, 1) = m * g / m_c;  // θ counts against the slope: s̈ = m g/m_c δθ
  A(3, 1) = (m_c + m) * g / (m_c * l);
  EXPECT_LT((model.A - A).cwiseAbs().maxCoeff(), 1e-12) << model.A;
  Eigen::Vector4d B(0, 0, 1 / m_c, 1 / (m_c * l));
  EXPECT_LT((model.B.col(0) - B).cwiseAbs().maxCoeff(), 1e-12) << model.B;
}

TEST(InclinedRail, KeepsAChainAtRightAnglesToIt) {
  const double beta = 0.4;
  Scene scene = readSceneText(
      "chain: [cart, a, b]\nlinks:\n  cart: {mass: 1.3, joint: {type: prismatic, axis: [1, 0]}}\n  a: {mass: "
      "0.4, inertia: 0.02, com: [0.3, 0], pin: [0.7, 0]}\n  b: {mass: 0.2, inertia: 0.01, com: [0.5, 0], "
      "pin: [1, 0]}\nintegrator: {tolerance: 1e-10}\n");
  std::vector<Joint> joints = scene.chain.joints();
  joints[0].axis = {2 * std::cos(beta), 2 * std::sin(beta)};
  scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
  scene.q = {0, beta - pi / 2, 0};
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(2));
  EXPECT_NEAR(simulation.q()[1], beta - pi / 2, 1e-10);
  EXPECT_NEAR(simulation.q()[2], 0, 1e-10);
  EXPECT_NEAR(simulation.q()[0], -0.5 * g * std::sin(beta) * 4, 1e-8);
  EXPECT_NEAR(simulation.qd()[0], -g * std::sin(beta) * 2, 1e-8);
}

// ---- Free chains -------------------------------------------------------------------------------------

/// Two equal rods without gravity, straight, at these rates against the ground.
Scene twoRods(double first, double second, double tolerance) {
  Scene scene = readSceneText(
      "chain: [a, b]\ngravity: [0, 0]\nlinks:\n  a: {mass: 1, inertia: 0.083333333333333333, com: [0.5, 0], "
      "pin: [1, 0], joint: {type: floating}}\n  b: {mass: 1, inertia: 0.083333333333333333, com: [0.5, 0], "
      "pin: [1, 0]}\n");
  scene.qd = {0.3, -0.2, first, second - first};
  scene.integrator.tolerance = tolerance;
  return scene;
}

TEST(FreeChain, TurnsItsKneeOnceInAKnownTime) {
  Simulation simulation(twoRods(-2, 3, 1e-12));
  ASSERT_TRUE(simulation.advanceTo(2.1953726551488901));
  EXPECT_NEAR(simulation.q()[3], 2 * pi, 1e-9);
  EXPECT_NEAR(2 * simulation.q()[2] + simulation.q()[3], 5.0987518794783351, 1e-9);
}

/// Σ m v, and Σ c×(m v) + I ω about the centre of mass.
Eigen::Vector3d momentaOf(const Scene& scene, Simulation& simulation) {
  std::vector<LinkMotion> motions(scene.chain.links().size());
  simulation.linkMotions(motions.data());
  Vec2d momentum, centre;
  double moment = 0, mass = 0;
  for (std::size_t j = 0; j < motions.size(); ++j) {
    const Link& link = scene.chain.links()[j];
    const Vec2d p = link.mass * motions[j].velocity;
    momentum += p;
    centre += link.mass * motions[j].com;
    mass += link.mass;
    moment += cross(motions[j].com, p) + link.inertia * motions[j].omega;
  }
  return {momentum.x, momentum.y, moment - cross((1 / mass) * centre, momentum)};
}

class FreeChains : public testing::TestWithParam<const char*> {};

TEST_P(FreeChains, KeepTheirMomenta) {
  // A step has an error of 1e-6. Rounding alone remains: some 1e-16 a step, of some thousand steps.
  Scene scene = readSceneText(
      "chain: [a, b, c, d]\ngravity: [0, -9.81]\nlinks:\n  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: "
      "[1, 0], joint: {type: floating}, initial: {linear_velocity: [0.3, 98.1], velocity: 5}}\n  b: {mass: "
      "2, "
      "inertia: 0.2, com: [0.3, 0], pin: [0.8, 0.1], joint: {stiffness: 20, damping: 0.02, rest_angle: "
      "0.5}}\n"
      "  c: {mass: 0.5, inertia: 0.02, com: [0.4, 0], pin: [0.8, 0], joint: {rotor_inertia: 0.05}}\n"
      "  d: {mass: 1, inertia: 0.05, com: [0.4, 0], pin: [0.8, 0], joint: {friction: 0.05}, initial: "
      "{velocity: -3}}\nintegrator: {tolerance: 1e-6}\n");
  scene.integrator.method = GetParam();
  Simulation simulation(scene, 1);
  const Eigen::Vector3d before = momentaOf(scene, simulation);
  const double duration = 20, mass = 4.5;  // back at the height of the start
  ASSERT_TRUE(simulation.advanceTo(duration));
  const Eigen::Vector3d now = momentaOf(scene, simulation) + Eigen::Vector3d(0, mass * 9.81 * duration, 0);
  EXPECT_LT((now - before).head(2).norm(), 1e-12 * mass * 9.81 * duration);
  EXPECT_LT(std::abs(now[2] - before[2]), 1e-12 * std::abs(before[2]));

  // A force from outside changes both.
  ASSERT_TRUE(simulation.addForce(2, {0.5, 0.1}, {1, 0}, 0, 0.5));
  ASSERT_TRUE(simulation.advanceTo(duration + 1));
  EXPECT_NEAR(momentaOf(scene, simulation)[0] - before[0], 0.5, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(By, FreeChains,
                         testing::Values("auto", "dopri5", "dop853", "taylor", "rodas5p", "radau13"));

/// A base changes what the coordinates of a free chain are measured from, and nothing else. After a second
/// this one is back at 0.
TEST(FreeChain, MovesTheSameBesideABaseThatMoves) {
  const auto scene = [](const std::string& initial, const std::string& base) {
    return readSceneText(
        "chain: [a, b]\nlinks:\n  a: {mass: 0.5, inertia: 0.01, com: [0.4, 0.05], pin: [0.8, 0], joint: "
        "{type: floating}, initial: {angle: -1" +
        initial + "}}\n  b: {mass: 0.5, inertia: 0.01, com: [0.4, 0.05], pin: [0.8, 0]}\n" + base);
  };
  // The rates of the base at t = 0: 2π 0.1 m/s, 2π 0.5 0.3 rad/s.
  Simulation free(scene(", linear_velocity: [0.62831853071795865, 0], velocity: 0.94247779607693797", ""));
  Simulation beside(
      scene("", "base: {x: {amplitude: 0.1, frequency: 1}, angle: {amplitude: 0.3, frequency: 0.5}}\n"));
  ASSERT_TRUE(free.advanceTo(1) && beside.advanceTo(1));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(beside.q()[i], free.q()[i], 1e-8) << i;
  EXPECT_NEAR(beside.energy().kinetic, free.energy().kinetic, 1e-6);
}

TEST(FreeChain, SpinsWithTheFrequenciesOfAlgorithms) {
  // Stretched and spinning at Ω = 1. What the bends q_2 … q_n and all rates do is autonomous: their part of A
  // has the eigenvalues ±iω. In the limit of many rods ω = √2, √5, 3, …
  const int n = 60, last = n + 2;
  const Scene scene = readSceneText(
      "chain: [first, rod]\ngravity: [0, 0]\nlinks:\n  first: {mass: 1, inertia: 0.0833333333333333333, com: "
      "[0.5, "
      "0], pin: [1, 0], joint: {type: floating}, initial: {velocity: 1}}\n  rod: {mass: 1, inertia: "
      "0.0833333333333333333, com: [0.5, 0], pin: [1, 0], repeat: 59}\n");
  const LinearModel model = linearModel(scene, 0, vectorOf(scene.q), vectorOf(scene.qd));
  std::vector<Eigen::Index> bends, rates;
  for (int i = 3; i < last; ++i) bends.push_back(i);
  for (int i = 2; i < last; ++i) rates.push_back(last + i);
  std::vector<Eigen::Index> kept = bends;
  kept.insert(kept.end(), rates.begin(), rates.end());
  const auto size = static_cast<Eigen::Index>(kept.size());
  Eigen::MatrixXd part(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j)
      part(i, j) = model.A(kept[index(static_cast<int>(i))], kept[index(static_cast<int>(j))]);
  }
  const Eigen::VectorXcd values = part.eigenvalues();
  std::vector<double> omega;
  for (Eigen::Index i = 0; i < size; ++i) {
    if (values[i].imag() > 0.1) omega.push_back(values[i].imag());
  }
  std::sort(omega.begin(), omega.end());
  ASSERT_GE(omega.size(), 3u);
  EXPECT_NEAR(omega[0], 1.414704, 1e-6);
  EXPECT_NEAR(omega[1], 2.238231, 1e-6);
  EXPECT_NEAR(omega[2], 3.006167, 1e-6);
}

// ---- Everything with prismatic joints
// ------------------------------------------------------------------------

constexpr const char* shaken =
    "base: {x: {amplitude: 0.03, frequency: 1.7}, y: {times: [0, 0.7, 1.1], values: [0, 0.1, -0.05]}}\n";

constexpr const char* turning =
    "base: {x: {amplitude: 0.03, frequency: 1.7}, angle: {amplitude: 0.4, frequency: 0.6, offset: 0.2}}\n";

/// A plane with all that acts along its axes and behind them.
Scene onAPlane(const std::string& drive = "", const std::string& base = "") {
  return readSceneText(
      "chain: [x, y, pole, lower]\nlinks:\n  x: {mass: 2.0, com: [0.1, 0], pin: [0.0, 0.1], joint: {type: "
      "prismatic, axis: [1, 0.2], friction: 1.5, upper: 0.3, stop_stiffness: 400, stop_damping: 3}, initial: "
      "{position: 0.1, velocity: 0.8}}\n  y: {mass: 0.4, pin: [0.05, 0], joint: {type: prismatic, axis: "
      "[0, 1], " +
      (drive.empty() ? "stiffness: 40, damping: 0.5}, initial: {position: -0.2}}" : drive + "}}") +
      "\n  pole: {mass: 0.5, inertia: 0.01, com: [0.4, 0.05], pin: [0.8, 0], joint: {rotor_inertia: 0.03, "
      "friction: 0.05, drag: 0.2}, initial: {angle: -1.2, velocity: 0.4}}\n  lower: {mass: 0.3, inertia: "
      "0.004, com: "
      "[0.2, -0.03], pin: [0.5, 0.1], joint: {stiffness: 2, damping: 0.1}, initial: {angle: 0.7}}\nloads:\n  "
      "wind: {link: lower, force: [1, 0.5], point: [0.1, 0.2], frequency: 0.8}\n  push: {link: x, force: [3, "
      "-1], frequency: 0.3}\n  lift: {link: y, force: [0.5, 5]}\n  motor: {joint: x_joint, torque: 2}\n  "
      "bend: {joint: pole_joint, torque: 0.3, frequency: 1.1}\n" +
      base);
}

/// An arm from which a sleeve slides out, and a piston from the pole on it, with all that acts in them.
Scene inside(const std::string& drive = "", const std::string& base = "") {
  return readSceneText(
      "chain: [arm, sleeve, pole, piston]\nlinks:\n  arm: {mass: 1.2, inertia: 0.05, com: [0.3, 0.02], pin: "
      "[0.5, 0.1], joint: {rotor_inertia: 0.02, friction: 0.1}, initial: {angle: -0.9, velocity: 0.6}}\n  "
      "sleeve: {mass: 0.8, inertia: 0.02, com: [0.1, -0.03], pin: [0.3, 0], joint: {type: prismatic, axis: "
      "[1, 0.3], rotor_inertia: 0.4, " +
      (drive.empty() ? "stiffness: 60, damping: 0.5, friction: 0.4, upper: 0.4, stop_stiffness: 900, "
                       "stop_damping: 3}, initial: {position: 0.1, velocity: 0.5}}"
                     : drive + "}}") +
      "\n  pole: {mass: 0.5, inertia: 0.01, com: [0.2, 0.05], pin: [0.3, 0], joint: {rotor_inertia: 0.03, "
      "friction: 0.05, drag: 0.2}, initial: {angle: -0.5, velocity: 0.4}}\n  piston: {mass: 0.3, inertia: "
      "0.004, com: [0.1, -0.03], joint: {type: prismatic, axis: [0.2, -1], stiffness: 30, damping: 0.1}, "
      "initial: {position: 0.1}}\nloads:\n  wind: {link: piston, force: [1, 0.5], point: [0.1, 0.2], "
      "frequency: 0.8}\n  push: {link: sleeve, force: [3, -1], point: [0.2, 0], moment: 0.3, frequency: "
      "0.3}\n  motor: {joint: piston_joint, torque: 2}\n  bend: {joint: pole_joint, torque: 0.3, frequency: "
      "1.1}\n" +
      base);
}

struct Variant {
  Scene (*scene)(const std::string& drive, const std::string& base);
  const char *drive, *base;
};

class Everything : public testing::TestWithParam<Variant> {
 protected:
  static Scene scene() { return GetParam().scene(GetParam().drive, GetParam().base); }
};

TEST_P(Everything, HasTheAccelerationsOfKane) {
  const Scene scene = Everything::scene();
  Simulation simulation(scene);
  for (const double t : {0.05, 0.4, 1.0}) {
    ASSERT_TRUE(simulation.advanceTo(t)) << simulation.fault();
    const Eigen::VectorXd q = vectorOf(simulation.q()), qd = vectorOf(simulation.qd());
    std::vector<double> qdd(4);
    simulation.accelerations(qdd.data());
    const ActiveForces active = activeForces(scene, t, q, qd);
    const Kane dense = kane(scene.chain, q, qd, active);
    EXPECT_LT((dense.qdd - vectorOf(qdd)).norm(), 1e-9 * (1 + dense.qdd.norm())) << "t = " << t;
    EXPECT_LT((dense.M_q - dense.M_q.transpose()).norm(), 1e-12);
    // T = ½ q̇ᵀ M q̇
    const double kinetic = simulation.energy().kinetic;
    if (!scene.base) {
      EXPECT_NEAR(0.5 * qd.dot(dense.M_q * qd), kinetic, 1e-12 * (1 + qd.squaredNorm()));
    }
    const Eigen::VectorXd torques = inverseDynamics(scene, t, q, qd, dense.qdd);
    std::vector<double> found(4);
    simulation.jointTorques(found.data());
    EXPECT_TRUE(torques.allFinite() && vectorOf(found).allFinite());
  }
}

TEST_P(Everything, LinearizesAsKaneDiffers) {
  const Scene scene = Everything::scene();
  const double t = 0.3, h = 1e-6;
  Eigen::VectorXd q = vectorOf(scene.q), qd = vectorOf(scene.qd);
  for (const Drive& drive : scene.drives) {
    q[drive.joint] = drive.law.at(t).value;
    qd[drive.joint] = drive.law.at(t).rate;
  }
  const LinearModel model = linearModel(scene, t, q, qd);
  const auto accelerations = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return kane(scene.chain, x.head(4), x.tail(4), activeForces(scene, t, x.head(4), x.tail(4))).qdd;
  };
  Eigen::VectorXd x(8);
  x << q, qd;
  for (int i = 0; i < 8; ++i) {
    Eigen::VectorXd more = x, less = x;
    more[i] += h;
    less[i] -= h;
    const Eigen::VectorXd column = (accelerations(more) - accelerations(less)) / (2 * h);
    EXPECT_LT((column - model.A.col(i).tail(4)).norm(), 1e-5 * (1 + column.norm())) << "column " << i;
  }
}

TEST_P(Everything, ClosesTheEnergyBalanceByEachMethod) {
  std::vector<double> first;
  for (const char* method : {"auto", "dop853", "dopri5", "rodas5p", "radau13"}) {
    Scene scene = Everything::scene();
    scene.integrator.method = method;
    scene.integrator.tolerance = 1e-10;
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(3)) << method << ": " << simulation.fault();
    EXPECT_EQ(simulation.statistics().rescues, 0) << method;
    EXPECT_LT(std::abs(simulation.energyBalance().residual), 1e-7) << method;
    if (first.empty()) first = simulation.q();
    for (std::size_t i = 0; i < first.size(); ++i) EXPECT_NEAR(simulation.q()[i], first[i], 1e-7) << method;
  }
}

constexpr const char *moved = "drive: {amplitude: 0.2, frequency: 0.7}", *held = "drive: hold";

INSTANTIATE_TEST_SUITE_P(OnAPlane, Everything,
                         testing::Values(Variant{onAPlane, "", ""}, Variant{onAPlane, moved, ""},
                                         Variant{onAPlane, held, ""}, Variant{onAPlane, "", shaken},
                                         Variant{onAPlane, "", turning}, Variant{onAPlane, moved, turning},
                                         Variant{onAPlane, moved, shaken}));
INSTANTIATE_TEST_SUITE_P(Inside, Everything,
                         testing::Values(Variant{inside, "", ""}, Variant{inside, moved, ""},
                                         Variant{inside, held, turning}, Variant{inside, "", turning},
                                         Variant{inside, moved, shaken}));

/// On a base of acceleration a each body has the force −m a, against the base.
TEST(PrismaticJoints, OnAShakenBaseFeelInertialForces) {
  const double f = 1.3, w = 2 * pi * f;
  const Vec2d amplitude{0.02, -0.05};
  const std::string sine = ", frequency: 1.3}";
  Scene still = readSceneText(plane);
  for (std::size_t j = 0; j < still.chain.links().size(); ++j) {
    const Link& link = still.chain.links()[j];
    Load load;
    load.name = link.name;
    load.link = static_cast<int>(j);
    load.force = (link.mass * w * w) * amplitude;
    load.law = Sine{f, 0};
    load.point = link.com;
    still.loads.push_back(load);
  }
  const Scene moving =
      readSceneText(plane + "base: {x: {amplitude: 0.02" + sine + ", y: {amplitude: -0.05" + sine + "}\n");
  for (const char* method : {"auto", "rodas5p"}) {
    struct End {
      std::vector<double> q, qd;
      BaseWrench wrench;
    };
    std::vector<End> ends;
    for (Scene scene : {still, moving}) {
      scene.integrator.method = method;
      scene.integrator.tolerance = 1e-11;
      Simulation simulation(scene);
      ASSERT_TRUE(simulation.advanceTo(2.1)) << simulation.fault();
      ends.push_back({simulation.q(), simulation.qd(), simulation.baseWrench()});
    }
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR(ends[0].q[i], ends[1].q[i], 1e-9);
      EXPECT_NEAR(ends[0].qd[i], ends[1].qd[i], 1e-8);
    }
    const BaseWrench &one = ends[0].wrench, &other = ends[1].wrench;
    EXPECT_LT(length(one.force - other.force), 1e-6);
    EXPECT_NEAR(one.torque, other.torque, 1e-6);
  }
}

/// Places, velocities and accelerations of all links are derivatives of each other, and what moves the links
/// is the base's wrench.
TEST(PrismaticJoints, OnATurningBaseMoveAsTheirPlaces) {
  for (const std::string& text : {turned, turnedPlane}) {
    Scene scene = readSceneText(text);
    scene.integrator.tolerance = 1e-13;
    Simulation simulation(scene);
    const std::size_t n = scene.q.size();
    const double h = 2e-5, t = 0.8;
    std::vector<LinkMotion> before(n), now(n), after(n);
    for (auto* motions : {&before, &now, &after}) {
      ASSERT_TRUE(simulation.advanceTo(t + (motions == &before ? -h : motions == &after ? h : 0)));
      simulation.linkMotions(motions->data());
      if (motions != &now) continue;
      Vec2d force, ground{scene.base->x.at(t).value, scene.base->y.at(t).value};
      double moment = 0;
      for (std::size_t j = 0; j < n; ++j) {
        const Link& link = scene.chain.links()[j];
        const Vec2d F = link.mass * (now[j].acceleration - scene.chain.gravity());
        force += F;
        moment += cross(now[j].com - ground, F) + link.inertia * now[j].alpha;
      }
      EXPECT_LT(length(simulation.baseWrench().force + force), 1e-11);
      EXPECT_NEAR(simulation.baseWrench().torque, -moment, 1e-11);
    }
    for (std::size_t j = 0; j < n; ++j) {
      const auto slope = [&](auto of) { return 1 / (2 * h) * (of(after[j]) - of(before[j])); };
      EXPECT_LT(length(slope([](const LinkMotion& at) { return at.com; }) - now[j].velocity), 1e-6) << j;
      EXPECT_LT(length(slope([](const LinkMotion& at) { return at.velocity; }) - now[j].acceleration), 1e-5)
          << j;
      EXPECT_NEAR(slope([](const LinkMotion& at) { return at.angle; }), now[j].omega, 1e-6) << j;
      EXPECT_NEAR(slope([](const LinkMotion& at) { return at.omega; }), now[j].alpha, 1e-5) << j;
    }
  }
}

/// A force on a carriage moves the chain as one at its centre of mass. Its rail takes the moment.
TEST(PrismaticJoints, PassTheMomentsOfForcesToTheBase) {
  const Vec2d com{0.1, 0.1}, push{3, -2}, command{1, 4};
  for (const std::string& text : {plane, turnedPlane}) {
    double angle = 0;
    const auto wrenchWith = [&](const std::string& point, Vec2d commandPoint) {
      Simulation simulation(readSceneText(text + "loads: {push: {link: y, force: [3, -2]" + point + "}}\n"),
                            1);
      simulation.holdForce(1, commandPoint, command, 0, 1);
      EXPECT_TRUE(simulation.advanceTo(0.3));
      std::vector<LinkMotion> motions(4);
      simulation.linkMotions(motions.data());
      angle = motions[1].angle;
      return simulation.baseWrench();
    };
    const BaseWrench atCom = wrenchWith("", com), beside = wrenchWith(", point: [0.6, 0.2]", {-0.1, 0.3});
    const auto turn = Rotation<double>::of(angle);
    const double moment =
        cross(turn * (Vec2d{0.6, 0.2} - com), push) + cross(turn * (Vec2d{-0.1, 0.3} - com), command);
    EXPECT_LT(length(beside.force - atCom.force), 1e-9);
    EXPECT_NEAR(beside.torque - atCom.torque, moment, 1e-9);
  }
}

TEST(PrismaticJoints, FollowABaseThatBeginsToTurn) {
  const std::string given = cart() + "integrator: {tolerance: 1e-11}\nbase: {angle: ";
  Simulation known(readSceneText(given + "{times: [0, 1], values: [0, 0.5]}}\n"));
  Simulation follows(readSceneText(given + "{offset: 0}}\n"));
  const BaseLaws& laws = *follows.scene().base;
  follows.followBase({laws.x, laws.y, laws.angle.to(0, 1, 0.5, 0)});
  for (Simulation* simulation : {&known, &follows}) ASSERT_TRUE(simulation->advanceTo(1.5));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(known.q()[i], follows.q()[i], 1e-8);
}

TEST(PrismaticJoints, NeedInertiaInEveryPose) {
  const Link rod{"", 1, 0.1, {0.5, 0}, {1, 0}}, bob{"", 1, 0, {1, 0}, {1, 0}},
      beyond{"", 1, 0, {1, 0}, {2, 0}};
  const auto isSound = [](const std::vector<double>& masses, const std::vector<Link>& bodies) {
    std::vector<Link> links;
    for (const double mass : masses) links.push_back({"", mass, 0, {}, {}});
    links.insert(links.end(), bodies.begin(), bodies.end());
    std::vector<Joint> joints(links.size());
    for (std::size_t i = 0; i < links.size(); ++i) {
      links[i].name = joints[i].name = std::to_string(i);
      joints[i].isPrismatic = i < masses.size();
      if (i == 1) joints[i].axis = {0, 1};
    }
    try {
      Chain(links, joints, {});
      return true;
    } catch (const Refused&) {
      return false;
    }
  };
  EXPECT_TRUE(isSound({0, 0}, {rod}));
  EXPECT_FALSE(isSound({0, 0}, {bob}));
  EXPECT_FALSE(isSound({0, 0}, {bob, rod}));
  EXPECT_TRUE(isSound({0, 0}, {beyond, rod}));
  EXPECT_FALSE(isSound({0, 0}, {beyond, bob}));
  EXPECT_TRUE(isSound({}, {bob}));
  EXPECT_FALSE(isSound({0}, {bob}));
  EXPECT_TRUE(isSound({1}, {bob}));
  EXPECT_FALSE(isSound({1, 0}, {bob}));
  EXPECT_TRUE(isSound({0, 1}, {bob}));
}

TEST(PrismaticJoints, AStiffRailTakesFewSteps) {
  // A Jacobian without the rail's spring and damper would make rodas5p follow them.
  Scene scene = readSceneText(cart("axis: [1, 0], stiffness: 4e8, damping: 2e5"));
  scene.qd[0] = 0;
  scene.q[0] = 0;
  for (const char* method : {"rodas5p", "radau13"}) {
    scene.integrator.method = method;
    scene.integrator.tolerance = 1e-6;
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(3));
    EXPECT_LT(simulation.statistics().steps, 1000) << method;
    EXPECT_LT(std::abs(simulation.q()[0]), 1e-6) << method;
  }
}

TEST(PrismaticJoints, PositionsOfPinsFollow) {
  const Scene scene = readSceneText(plane);
  Simulation simulation(scene);
  std::vector<LinkMotion> motions(4);
  simulation.linkMotions(motions.data());
  const Vec2d x = {0.1, 0}, y = -0.2 / std::hypot(0.3, 1) * Vec2d{0.3, 1};
  const Vec2d at = x + Vec2d{0, 0.1} + y;
  EXPECT_NEAR(motions[1].innerPin.x, at.x, 1e-15);
  EXPECT_NEAR(motions[1].innerPin.y, at.y, 1e-15);
  EXPECT_NEAR(motions[2].innerPin.x, at.x + 0.05, 1e-15);
  // Newton for the whole chain: the base's force is Σ m (a − g)
  Vec2d force;
  for (std::size_t j = 0; j < 4; ++j) {
    force += scene.chain.links()[j].mass * (motions[j].acceleration - scene.chain.gravity());
  }
  const BaseWrench wrench = simulation.baseWrench();
  EXPECT_NEAR(wrench.force.x, -force.x, 1e-12);
  EXPECT_NEAR(wrench.force.y, -force.y, 1e-12);
  // and d/dt of the angular momentum about the base, less the weights' moments
  double moment = 0;
  for (std::size_t j = 0; j < 4; ++j) {
    const Link& link = scene.chain.links()[j];
    moment += link.mass * cross(motions[j].com, motions[j].acceleration - scene.chain.gravity()) +
              link.inertia * motions[j].alpha;
  }
  EXPECT_NEAR(wrench.torque, -moment, 1e-12);
}

TEST(PrismaticJoints, SettleWhereSpringsAndStopsHoldThem) {
  Scene scene = readSceneText(tilted + "start: rest\n");
  const double weight = (2.0 + 0.5 + 0.3) * g, along = weight / std::sqrt(10);  // axis (3, −1)/√10
  EXPECT_NEAR(scene.q[0], 0.2 + along / 30, 1e-9);
  std::vector<double> qdd(3);
  Simulation(scene).accelerations(qdd.data());
  for (const double each : qdd) EXPECT_NEAR(each, 0, 1e-9);
  scene = readSceneText(cart("axis: [0, 1], lower: -0.4, stop_stiffness: 1000") + "start: rest\n");
  EXPECT_NEAR(scene.q[0], -0.4 - weight / 1000, 1e-9);
  scene = readSceneText(cart() + "start: rest\n");
  EXPECT_EQ(scene.q[0], 0.1) << "nothing pushes along a level rail";
  EXPECT_THROW(readSceneText(cart("axis: [1, 1]") + "start: rest\n"), Refused);
}

/// Rounding of a heavy link's inertia in the acceleration of a light one: q̈ of the same machine, written from
/// either end, and the note.
TEST(PrismaticJoints, NoteMassesBesideWhichDigitsAreLost) {
  const auto two = [](const std::string& rest, double first, double second, double torque, double qa,
                      double qb) {
    std::ostringstream text;
    text << "chain: [a, b]\ngravity: [0, 0]\nlinks:\n"
         << "  a: {mass: " << first << ", inertia: " << first / 12
         << ", com: [0.5, 0], pin: [1, 0], joint: {type: floating}, initial: {angle: " << qa << "}}\n"
         << "  b: {mass: " << second << ", inertia: " << second / 12
         << ", com: [0.5, 0], pin: [1, 0], initial: {angle: " << qb << "}}\n"
         << "loads: {t: {joint: b_joint, torque: " << torque << "}}\n"
         << rest;
    return readSceneText(text.str());
  };
  const auto accelerationOf = [](const Scene& scene) {
    std::vector<double> qdd(4);
    Simulation(scene).accelerations(qdd.data());
    return qdd[3];
  };
  const auto notes = [](const Scene& scene) { return scene.notes.empty() ? "" : toString(scene.notes[0]); };
  for (const double ratio : {1e6, 1e8, 1e11}) {
    const Scene heavyLast = two("", 1, ratio, 0.1, -1, 0.5);
    const Scene heavyFirst = two("", ratio, 1, 0.1, 2.1, 0.5);
    const double lost = std::abs(accelerationOf(heavyLast) / accelerationOf(heavyFirst) - 1);
    EXPECT_LT(lost, 2e-15 * ratio);
    EXPECT_EQ(notes(heavyFirst), "");
    EXPECT_EQ(notes(heavyLast), ratio < 1e10 ? ""
                                             : "links/b/mass: is 1e+11 times that of a link before it: "
                                               "accelerations are exact to 1e-05 of their size (exact if "
                                               "the chain begins at its heavy end)");
  }
  EXPECT_EQ(notes(two("integrator: {tolerance: 1e-4}\n", 1, 1e11, 0.1, -1, 0.5)), "");
  EXPECT_NE(notes(two("integrator: {method: rk4, step: 1e-3}\n", 1, 1e11, 0.1, -1, 0.5)), "");
}

}  // namespace
}  // namespace planar_chain
