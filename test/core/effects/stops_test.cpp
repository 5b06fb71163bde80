/// Joint limits: exact bounces, laws, and the derivative that implicit methods take through a stop.

#include "effects/stops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "dynamics/dynamics.h"
#include "ode/methods.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "support/known_chains.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

using test::Random;
using test::randomScene;

constexpr double J = 1. / 3;  // of a rod of 1 m, 1 kg about its end

/// One rod with a stop at q = 1, or, mirrored, at q = −1.
Scene rodWithStop(double k, double d, double sign = 1) {
  Joint joint;
  joint.name = "rod_joint";
  (sign > 0 ? joint.upper : joint.lower) = sign;
  joint.stopStiffness = k;
  joint.stopDamping = d;
  return {Chain({{"rod", 1, 1. / 12, {0.5, 0}, {1, 0}}}, {joint}, {}), {0}, {sign * 2}, {}, {}, {}, 0};
}

struct Bounce {
  double end, depth, speed;  ///< when, where and how fast the joint leaves the stop's push, after the hit
};

/// J ẍ + d ẋ + k x = 0 from x = 0, ẋ = v, until the push k x + d ẋ = −J ẍ ends.
Bounce bounce(double k, double d, double v) {
  const double sigma = d / (2 * J);
  const double square = k / J - sigma * sigma;
  if (square > 0) {
    const double w = std::sqrt(square);
    const double t = std::atan2(2 * sigma * w, sigma * sigma - w * w) / w;
    const double decay = v * std::exp(-sigma * t);
    return {t, decay * std::sin(w * t) / w, decay * (std::cos(w * t) - sigma / w * std::sin(w * t))};
  }
  const double w = std::sqrt(-square);
  const double t = std::atanh(2 * sigma * w / (sigma * sigma + w * w)) / w;
  const double decay = v * std::exp(-sigma * t);
  return {t, decay * std::sinh(w * t) / w, decay * (std::cosh(w * t) - sigma / w * std::sinh(w * t))};
}

// The rod turns freely at 2 rad/s, hits the stop at t = 0.5 and turns back, freely again.
TEST(Stop, BouncesExactly) {
  struct Case {
    double k, d, tolerance;
  };
  for (const std::string& method : ode::methodNames()) {
    for (const Case& c : {Case{30, 0, 1e-10},
                          {30, 2, 1e-10},
                          {1e4, 0, 1e-10},
                          {1e4, 20, 1e-10},
                          {3, 50, 1e-10},
                          {1e8, 0, 1e-9},
                          {1e8, 1e3, 1e-9}}) {
      const bool isFixed = ode::hasFixedStep(method);
      if (isFixed && c.k > 1e4) continue;
      for (const double sign : {1.0, -1.0}) {
        Scene scene = rodWithStop(c.k, c.d, sign);
        scene.integrator = {method, c.tolerance, 1e-4};
        Simulation simulation(scene);
        ASSERT_TRUE(simulation.advanceTo(2)) << simulation.fault();
        const Bounce exact = bounce(c.k, c.d, 2);
        const double q = 1 + exact.depth + exact.speed * (1.5 - exact.end);
        // Adaptive: the tolerance times 1.5 s on the way out. Fixed: order three in the contact's own time.
        const double contactRate = std::max(std::sqrt(c.k / J), c.d / J);
        const double allowed = isFixed ? std::pow(contactRate * 1e-4, 3) : 10 * c.tolerance;
        EXPECT_NEAR(sign * simulation.q()[0], q, allowed) << method << " " << c.k << " " << c.d;
        EXPECT_NEAR(sign * simulation.qd()[0], exact.speed, allowed) << method << " " << c.k << " " << c.d;
        EXPECT_NEAR(simulation.energyBalance().residual, 0, allowed) << method << " " << c.k << " " << c.d;
        EXPECT_EQ(simulation.statistics().rescues, 0) << method << " " << c.k << " " << c.d;
      }
    }
  }
}

TEST(Stop, HoldsAtTheStaticDepth) {
  // Under gravity from above the rod comes to rest where k x = m g r cos q.
  Joint joint;
  joint.name = "rod_joint";
  joint.lower = -0.5;
  joint.stopStiffness = 1000;
  joint.stopDamping = 30;
  Scene scene{Chain({{"rod", 1, 1. / 12, {0.5, 0}, {1, 0}}}, {joint}, {0, -9.81}), {0}, {0}, {}, {}, {}, 0};
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(20)) << simulation.fault();
  const double q = simulation.q()[0];
  EXPECT_NEAR(simulation.qd()[0], 0, 1e-9);
  EXPECT_NEAR(1000 * (-0.5 - q), 9.81 * 0.5 * std::cos(q), 1e-6);
  double tau = 0;
  simulation.jointTorques(&tau);
  EXPECT_NEAR(tau, 9.81 * 0.5 * std::cos(q), 1e-6);
}

TEST(Stop, TakesWhatLiesOnItFromTheBeginning) {
  // Level, at rest, on a stop that holds it: at t = 0, θ = 0, x = 0, where no number says how small is small.
  for (const std::string& method : ode::methodNames()) {
    for (const double damping : {0., 5.}) {
      Joint joint{"rod_joint"};
      joint.lower = 0;
      joint.stopStiffness = 1e4;
      joint.stopDamping = damping;
      Scene scene{
          Chain({{"rod", 1, 1. / 12, {0.5, 0}, {1, 0}}}, {joint}, {0, -9.81}), {0}, {0}, {}, {}, {}, 0};
      scene.integrator = {method, 1e-9, 1e-5};
      Simulation simulation(scene);
      ASSERT_TRUE(simulation.advanceTo(0.01)) << method << ": " << simulation.fault();
      // J ẍ + d ẋ + k x = m g r, where cos q ≈ 1
      const double sigma = damping / (2 * J), w = std::sqrt(1e4 / J - sigma * sigma), t = 0.01;
      const double x =
          9.81 * 0.5 / 1e4 * (1 - std::exp(-sigma * t) * (std::cos(w * t) + sigma / w * std::sin(w * t)));
      EXPECT_NEAR(simulation.q()[0], -x, 1e-6 * x + 1e-9) << method;
    }
  }
}

TEST(Stop, IsNotJumpedOverByALongStep) {
  // Swinging up to 0.5 rad from the vertical by itself; the stop stands a hair below that.
  Joint joint;
  joint.name = "rod_joint";
  joint.upper = 0.4999;
  joint.stopStiffness = 1e4;
  joint.stopDamping = 50;
  const Chain chain({{"rod", 1, 1. / 12, {0.5, 0}, {1, 0}}}, {joint}, {9.81, 0});
  const auto at = [&](const char* method, double tolerance) {
    Scene scene{chain, {-0.5}, {0}, {}, {method, tolerance, 1e-3}, {}, 0};
    Simulation simulation(scene);
    EXPECT_TRUE(simulation.advanceTo(3)) << simulation.fault();
    return simulation.q()[0];
  };
  const double exact = at("dop853", 1e-13);
  for (const char* method : {"auto", "dopri5", "dop853", "rodas5p"}) {
    EXPECT_NEAR(at(method, 1e-6), exact, 1e-5) << method;
  }
}

TEST(Stop, OfManyIsSeenByEveryMethod) {
  // A whip of 13 rods falls, and its joints touch their stops over and over, some for a moment only.
  Scene scene = test::uniformChain(13, {"", 3. / 13, 0.25 * 9. / 13 / 169, {1.5 / 13, 0}, {3. / 13, 0}}, {},
                                   {}, {0, -9.81});
  std::vector<Joint> joints = scene.chain.joints();
  for (std::size_t i = 1; i < joints.size(); ++i) {
    joints[i].lower = -0.15;
    joints[i].upper = 0.12;
    joints[i].stopStiffness = 50 * (1 + static_cast<double>(i % 3));
  }
  scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
  scene.q[0] = -0.3708;
  const auto at = [&](const std::string& method, double tolerance) {
    scene.integrator = {method, tolerance, 1e-3};
    Simulation simulation(scene);
    EXPECT_TRUE(simulation.advanceTo(0.7)) << simulation.fault();
    return simulation.q();
  };
  const std::vector<double> exact = at("dop853", 1e-13);
  for (const std::string& method : ode::methodNames()) {
    if (ode::hasFixedStep(method) || method == "ros34pw2") continue;
    const std::vector<double> q = at(method, 1e-8);
    for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(q[i], exact[i], 1e-5) << method << " " << i;
  }
}

/// Every joint of a random chain between stops.
Scene caged(int n, unsigned seed, double k, double d) {
  Random random(seed + 100);
  Scene scene = randomScene(n, seed, {true, false, false});
  std::vector<Joint> joints = scene.chain.joints();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    joints[i].lower = scene.q[i] - random.between(0.05, 0.6);
    joints[i].upper = scene.q[i] + random.between(0.05, 0.6);
    joints[i].stopStiffness = k;
    joints[i].stopDamping = d;
  }
  scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
  scene.integrator.tolerance = 1e-11;
  return scene;
}

TEST(Stop, KeepsTheEnergyBalanceOfWholeChains) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    Simulation simulation(caged(4, seed, 500, 5));
    double dissipated = 0;
    for (int k = 1; k <= 100; ++k) {
      ASSERT_TRUE(simulation.advanceTo(0.02 * k)) << simulation.fault();
      const EnergyBalance balance = simulation.energyBalance();
      EXPECT_GE(balance.dissipated, dissipated);
      EXPECT_NEAR(balance.residual, 0, 1e-8);
      dissipated = balance.dissipated;
    }
    EXPECT_GT(dissipated, 0.1) << "some stop must have been hit";
  }
}

/// Pressed on a damped stop, a body bounces ever lower, and stays. Its rate is linear in a step, which
/// Newton's method finds at once, but the works are squares of it.
TEST(Stop, ThatIsDampedKeepsTheEnergyBalanceByEveryMethod) {
  for (const char* method : {"auto", "radau13", "rodas5p", "dop853", "taylor"}) {
    for (const double tolerance : {1e-6, 1e-8, 1e-10}) {
      Scene scene = readSceneText(
          "chain: [a]\ngravity: [0, 0]\nlinks: {a: {mass: 1, inertia: 0.02, com: [0, 0], pin: [1, 0], joint: "
          "{upper: 0.01, stop_stiffness: 1e+6, stop_damping: 30}, initial: {velocity: 0.02}}}\n"
          "loads: {pressed: {joint: a_joint, torque: 1}}\n");
      scene.integrator.method = method;
      scene.integrator.tolerance = tolerance;
      Simulation simulation(scene);
      EXPECT_TRUE(simulation.advanceTo(0.5)) << simulation.fault();
      EXPECT_EQ(simulation.statistics().rescues, 0) << method << ", " << tolerance;
      EXPECT_NEAR(simulation.energyBalance().residual, 0, 0.1 * tolerance) << method << ", " << tolerance;
      EXPECT_NEAR(simulation.q()[0], 0.010001, 1e-12);
    }
  }
}

// A rotor makes the joint couple accelerations; f at the contact was known before the stop acted.
TEST(Stop, ActsAtOnceBesideARotor) {
  Scene scene = rodWithStop(30, 2);
  Joint joint = scene.chain.joints()[0];
  joint.others.emplace_back("rotor_inertia", 0.1);
  scene.chain = Chain(scene.chain.links(), {joint}, scene.chain.gravity());
  const auto dynamics = std::make_unique<Dynamics>(scene);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(dynamics->size()), f = y;
  dynamics->enterState(0, y.data());
  const double depth = 1e-3;
  y.head(2) << 1 + depth, 2;
  dynamics->derivative(0.5, y.data(), f.data());
  EXPECT_EQ(f[1], 0);
  dynamics->fire(0.5, y.data());
  dynamics->derivative(0.5, y.data(), f.data());
  EXPECT_NEAR(f[1], -(30 * depth + 2 * 2) / (J + 0.1), 1e-12);
}

TEST(Stop, WithoutDampingGivesTheWayBack) {
  for (const unsigned seed : {4u, 5u}) {
    const Scene scene = caged(3, seed, 300, 0);
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(1));
    std::vector<double> back = simulation.qd();
    for (double& rate : back) rate = -rate;
    simulation.setState(simulation.q(), back);
    ASSERT_TRUE(simulation.advanceTo(2));
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(simulation.q()[i], scene.q[i], 1e-6) << seed;
  }
}

TEST(Stop, IsInTheJacobian) {
  // (s − J) x = b with J by differences; joints 1 and 3 push, 2 is parted.
  Scene scene = caged(3, 7, 40, 3);
  Dynamics dynamics(scene);
  dynamics.reserve(0);
  Eigen::VectorXd y(dynamics.size());
  double theta = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Joint& joint = scene.chain.joints()[i];
    theta += i == 0 ? joint.lower - 0.2 : joint.upper + 0.2;
    y[static_cast<Eigen::Index>(i)] = theta;
  }
  y.segment(3, 3) << -1, -10, -9.5;
  y.tail(2).setZero();
  dynamics.enterState(0, y.data());

  const Eigen::Index size = y.size();
  Eigen::MatrixXd jacobian(size, size);
  Eigen::VectorXd plus(size), minus(size), shifted(size);
  constexpr double h = 1e-6;
  for (Eigen::Index k = 0; k < size; ++k) {
    shifted = y;
    shifted[k] = y[k] + h;
    dynamics.derivative(0, shifted.data(), plus.data());
    shifted[k] = y[k] - h;
    dynamics.derivative(0, shifted.data(), minus.data());
    jacobian.col(k) = (plus - minus) / (2 * h);
  }
  dynamics.linearize(0, y.data(), plus.data());
  dynamics.factor(7);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(size, -1, 2);
  Eigen::VectorXd x(size);
  dynamics.solve(b.data(), x.data());
  EXPECT_LT((7 * x - jacobian * x - b).norm(), 1e-7 * jacobian.norm() * x.norm());
  EXPECT_GT(jacobian.row(size - 1).norm(), 1) << "the stops dissipate";
}

TEST(Stop, ThatIsNeverReachedChangesNoBit) {
  Scene bare = randomScene(4, 9);
  Scene limited = bare;
  std::vector<Joint> joints = bare.chain.joints();
  for (Joint& joint : joints) {
    joint.lower = -1000;
    joint.upper = 1000;
    joint.stopStiffness = 1;
  }
  limited.chain = Chain(bare.chain.links(), joints, bare.chain.gravity());
  Simulation a(bare), b(limited);
  ASSERT_TRUE(a.advanceTo(2) && b.advanceTo(2));
  EXPECT_EQ(a.q(), b.q());
  EXPECT_EQ(a.qd(), b.qd());
}

// d/k is 1000 s and 1e12 s, the fast mode 0.1 and 0.02 ns: k x and d ẋ cancel to rounding, and explicit
// methods would need 1e9 steps a second.
TEST(Stop, ThatIsOverdampedTakesFewEvaluationsByEveryMethod) {
  struct Hit {
    Vec2d gravity;
    double mass, inertia, k, d;
  };
  for (const Hit& hit : {Hit{{0, 9.81}, 1e-9, 1e-11, 1.8e-4, 0.18}, Hit{{0, 0}, 1, 0.01, 1e-3, 1e9}}) {
    for (const std::string& method : ode::methodNames()) {
      for (const double rotor : {0.0, 1e-3 * hit.inertia}) {
        SCOPED_TRACE(method + ", stop_damping " + std::to_string(hit.d) + (rotor > 0 ? ", a rotor" : ""));
        Joint joint{"joint"};
        if (rotor > 0) joint.others.set("rotor_inertia", rotor);
        joint.upper = 0.1;
        joint.stopStiffness = hit.k;
        joint.stopDamping = hit.d;
        const Link link{"link", hit.mass, hit.inertia, {0.1, 0}, {0.2, 0}};
        Simulation simulation(
            Scene{Chain({link}, {joint}, hit.gravity), {0}, {50}, {}, {method, 1e-8, 1e-3}, {}, 0});
        for (double t = 0.01; t < 1.005; t += 0.01) {
          ASSERT_TRUE(simulation.advanceTo(std::min(t, 1.0))) << simulation.fault();
        }
        EXPECT_LT(simulation.statistics().evaluations, rotor > 0 ? 25000 : 20000);
        EXPECT_NEAR(simulation.q()[0], joint.upper, 1e-6);
      }
    }
  }
}

// auto keeps its method from contact to contact. It used to choose anew at each, and took six times as many.
TEST(Stop, ThatIsHardAndHitOftenCostsAutoLittleMoreThanTheBestMethod) {
  for (const double damping : {10., 3e4}) {
    Joint joint;
    joint.lower = -0.3;
    joint.upper = 0.3;
    joint.stopStiffness = 1e5;
    joint.stopDamping = damping;
    Scene scene = test::uniformChain(5, {"", 1, 1. / 12, {0.5, 0}, {1, 0}}, {}, joint, {0, -9.81});
    const auto evaluationsBy = [&](const char* method) {
      scene.integrator = {method, 1e-8, 1e-3};
      Simulation simulation(scene);
      for (int k = 1; k <= 30; ++k) EXPECT_TRUE(simulation.advanceTo(0.1 * k)) << simulation.fault();
      return simulation.statistics().evaluations;
    };
    const auto best = std::min({evaluationsBy("taylor"), evaluationsBy("dop853"), evaluationsBy("rodas5p"),
                                evaluationsBy("radau13")});
    EXPECT_LT(static_cast<double>(evaluationsBy("auto")), 1.25 * static_cast<double>(best)) << damping;
  }
}

/// The gap to a stop is smooth: about five steps find each of the 13 changes of contact to the last digit.
/// The Illinois rule needs ten. taylor has the polynomial of its step, and repeats none.
TEST(Stop, IsLandedOnWithFewSteps) {
  std::ifstream file(SCENES_DIR "/leg.yaml");
  Scene scene = readSceneText({std::istreambuf_iterator<char>(file), {}});
  for (const auto& [method, most] : {std::pair("dopri5", 90), {"rodas5p", 90}, {"taylor", 5}}) {
    scene.integrator.method = method;
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(1.5)) << simulation.fault();
    EXPECT_LT(simulation.statistics().rejected, most) << method;
  }
}

/// A random machine that starts beyond stops. nudge: of each angle, in 1 + |angle|.
Scene machineBeyondStops(unsigned seed, double tolerance, double nudge = 0) {
  Random random(seed);
  const int n = 2 + random.index(4);
  Scene scene = randomScene(n, seed, {false, true, false});
  std::vector<Joint> joints = scene.chain.joints();
  for (int i = 0; i < n; ++i) {
    Joint& joint = joints[static_cast<std::size_t>(i)];
    joint.lower = random.between(-1.5, 0);
    joint.upper = joint.lower + random.between(0.2, 1.5);
    joint.stopStiffness = 4e4;
    double& q = scene.q[static_cast<std::size_t>(i)];
    q += nudge * (1 + std::abs(q));
  }
  scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
  scene.integrator.tolerance = tolerance;
  return scene;
}

std::vector<double> anglesAfter(const Scene& scene, double t, int parts = 1) {
  Simulation simulation(scene);
  for (int k = 1; k <= parts; ++k) EXPECT_TRUE(simulation.advanceTo(t * k / parts)) << simulation.fault();
  return simulation.q();
}

double apart(const std::vector<double>& one, const std::vector<double>& other) {
  double most = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    most = std::max(most, std::abs(one[i] - other[i]) / (1 + std::abs(one[i])));
  }
  return most;
}

/// Limits so near that a joint leaves one stop within rounding of the other.
TEST(Stop, ThatIsAHairBesideTheOtherOneIsLeft) {
  const auto after = [](const char* method) {
    Joint joint{"joint"};
    joint.lower = -0.1332315485599016;
    joint.upper = std::nextafter(joint.lower, 0);
    joint.stopStiffness = 3.7e5;
    joint.others.emplace_back("rotor_inertia", 0.003);
    Scene scene = test::uniformChain(1, {"link", 1.138, 0.0948, {0.5, 0}, {1, 0}}, joint, joint, {0, -9.81});
    scene.q = {joint.lower};
    scene.qd = {-2.94};
    scene.integrator = {method, 1e-9, 1e-3};
    Simulation simulation(scene);
    EXPECT_TRUE(simulation.advanceTo(0.5)) << simulation.fault();
    return simulation.q();
  };
  const std::vector<double> exact = after("dop853");
  for (const char* method : {"taylor", "auto", "radau13"})
    EXPECT_LT(apart(after(method), exact), 1e-8) << method;
}

// The stiffness of a stop goes when it is left, but the error of a rate stays: dopri5 ended at the other
// stop.
TEST(Stop, ThatIsOverdampedLeavesNoErrorOfTheRate) {
  Scene scene = readSceneText(
      "{chain: [cart, rod], links: {cart: {mass: 4.6, joint: {type: prismatic, axis: [1, 0], lower: -0.862, "
      "upper: "
      "-0.861999999, stop_stiffness: 194}, initial: {position: -0.862, velocity: 0.278}}, rod: {mass: 0.38, "
      "inertia: "
      "0.0065, com: [0.226, 0], pin: [0.453, 0], initial: {angle: -0.2166, velocity: 3.9}, joint: {lower: "
      "-0.2086, "
      "upper: -0.078, stop_damping: 8992, stiffness: 1}}}}");
  const auto after = [&](const char* method, double tolerance) {
    scene.integrator = {method, tolerance, 1e-3};
    Simulation simulation(scene);
    EXPECT_TRUE(simulation.advanceTo(0.2)) << simulation.fault();
    return simulation.q();
  };
  const std::vector<double> exact = after("radau13", 1e-10);
  for (const double tolerance : {1e-3, 1e-4, 1e-5})
    EXPECT_LT(apart(after("dopri5", tolerance), exact), 1e-2 * tolerance) << tolerance;
}

/// A radian takes half a millisecond: an error of a rate may not be relative to the rate and last long, too.
TEST(Stop, OfAFastClosedChainThatIsOverdampedIsAsExactAsTheTolerance) {
  Scene scene = readSceneText(R"(
chain: [a, b, c]
links:
  a: {mass: 1, inertia: 0.1, com: [0.4, 0], pin: [0.8, 0.1], initial: {angle: -0.6757, velocity: -1170}}
  b: {mass: 1, inertia: 0.1, com: [0.4, 0], pin: [0.8, 0.1], initial: {angle: 0.2949, velocity: -295.6}}
  c: {mass: 1, inertia: 0.1, com: [0.4, 0], pin: [0.8, 0.1], initial: {angle: 0.265, velocity: -173.1},
      joint: {lower: 0.1715, upper: 0.4945, stop_stiffness: 1.06e9, stop_damping: 3.99e8}}
gravity: [99320, -893900]
tip: {line: {point: [2.273, -0.6201], direction: [1, 0.3]}}
)");
  const auto after = [&](const char* method, double tolerance) {
    scene.integrator = {method, tolerance, 1e-3};
    Simulation simulation(scene);
    EXPECT_TRUE(simulation.advanceTo(1.9e-3)) << simulation.fault();
    return simulation.q();
  };
  const std::vector<double> exact = after("radau13", 1e-12);
  EXPECT_LT(apart(after("dop853", 1e-11), exact), 1e-11);
  for (const char* method : {"auto", "rodas5p"}) EXPECT_LT(apart(after(method, 1e-8), exact), 5e-8) << method;
}

/// The course of a step tells when a stop is touched: steps are not repeated to find out. With
/// friction, and in lanes.
TEST(Stop, OfALongChainIsLandedOnWithinTheStep) {
  for (const auto& [n, k, friction] : {std::tuple(12, 2e3, 0.5), {43, 6e4, 0.0}}) {
    Joint joint;
    joint.lower = -0.3;
    joint.upper = 0.3;
    joint.stopStiffness = k;
    joint.stopDamping = 3;
    if (friction > 0) joint.others.emplace_back("friction", friction);
    Scene scene = test::uniformChain(n, {"", 1, 0.1, {0.5, 0}, {1, 0}}, joint, joint, {0, -9.81});
    const auto after = [&, n = n](const char* method, double tolerance) {
      scene.integrator = {method, tolerance, 1e-3};
      Simulation simulation(scene);
      EXPECT_TRUE(simulation.advanceTo(0.5)) << simulation.fault();
      const auto counts = simulation.statistics();
      EXPECT_LT(counts.rejected, counts.steps) << n << " links by " << method;
      return simulation.q();
    };
    const std::vector<double> exact = after("dop853", 1e-12);
    for (const char* method : {"dop853", "dopri5", "rodas5p"}) {
      EXPECT_LT(apart(after(method, 1e-4), exact), 1e-5) << method;
    }
  }
}

// Such machines are chaotic: they part by order one from others of the last bit. Before that, another kernel
// parts from the default as that bit does, and another output rate by no more than the tolerance, grown.
TEST(Stop, FromBeyondItOnKernelAndOutputRateMatterAsRoundingAndToleranceDo) {
  constexpr double t = 0.05, bit = 2.3e-16;
  int compared = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    for (const double tolerance : {1e-8, 1e-12}) {
      const Scene scene = machineBeyondStops(seed, tolerance);
      Scene plain = scene;
      plain.integrator.plainKernel = true;
      const std::vector<double> end = anglesAfter(scene, t);
      double growth = 1;  // of a small change
      for (const double nudge : {bit, -bit, 4 * bit}) {
        const std::vector<double> beside = anglesAfter(machineBeyondStops(seed, tolerance, nudge), t);
        growth = std::max(growth, apart(end, beside) / std::abs(nudge));
      }
      if (growth > 1e6) continue;  // rounding has grown to 1e-10 already
      ++compared;
      EXPECT_LT(apart(end, anglesAfter(plain, t)), 100 * bit * growth) << seed << ", " << tolerance;
      EXPECT_LT(apart(end, anglesAfter(scene, t, 20)), 10 * tolerance * growth) << seed << ", " << tolerance;
    }
  }
  EXPECT_GT(compared, 60);
}

}  // namespace
}  // namespace planar_chain
