/// Dry friction in its parts: what sticks, against a dense solver; the band; and long chains, which do not
/// stall.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "dynamics/dynamics.h"
#include "effects/complementarity.h"
#include "effects/stick_slip.h"
#include "ode/events.h"
#include "ode/methods.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "support/known_chains.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

// ---- What sticks -------------------------------------------------------------------------------------

/// A chain at rest as matrices: q̈ = A λ + b, |λ_i| ≤ c_i.
class DenseChain : public RestingChain {
 public:
  Eigen::MatrixXd A;
  Eigen::VectorXd b, c, lambda, rates;
  double noise = 0;  ///< added to |λ| of stuck joints, and taken from the rate of those that start

  /// decay: of A from joint to joint; own: the least answer of a joint to its own torque.
  explicit DenseChain(int n, unsigned seed, double decay = 4, double own = 0.1)
      : A(n, n), b(n), c(n), lambda(n), rates(n) {
    test::Random random(seed);
    Eigen::MatrixXd root(n, n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) root(i, j) = random.between(-1, 1) * std::pow(decay, -std::abs(i - j) / 2);
      b[i] = random.between(-1, 1);
      c[i] = random.between(0.01, 1);
    }
    A = root * root.transpose() + own * Eigen::MatrixXd::Identity(n, n);
  }

  void solve(std::vector<RestingJoint>& joints) override {
    std::vector<int> stuck;
    for (const RestingJoint& one : joints) {
      lambda[one.joint] = -one.direction * c[one.joint];
      if (one.direction == 0) stuck.push_back(one.joint);
    }
    const auto m = static_cast<Eigen::Index>(stuck.size());
    const Eigen::VectorXd loaded = A * lambda + b;
    Eigen::MatrixXd part(m, m);
    Eigen::VectorXd right(m);
    for (Eigen::Index i = 0; i < m; ++i) {
      right[i] = -loaded[stuck[static_cast<std::size_t>(i)]];
      for (Eigen::Index j = 0; j < m; ++j) {
        part(i, j) = A(stuck[static_cast<std::size_t>(i)], stuck[static_cast<std::size_t>(j)]);
      }
    }
    const Eigen::VectorXd held = part.llt().solve(right);
    for (Eigen::Index i = 0; i < m; ++i) lambda[stuck[static_cast<std::size_t>(i)]] = held[i];
    rates = A * lambda + b;
    for (RestingJoint& one : joints) {
      if (one.direction == 0) {
        one.excess = std::abs(lambda[one.joint]) + noise - c[one.joint];
        one.load = std::abs(lambda[one.joint]) / c[one.joint];
        one.release = lambda[one.joint] > 0 ? -1 : 1;
      } else {
        one.wrong = -one.direction * rates[one.joint] + noise;
      }
    }
  }

  /// The solution by projected Gauss-Seidel, which converges for every positive definite A.
  Eigen::VectorXd byIteration() const {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size());
    for (int sweep = 0; sweep < 20000; ++sweep) {
      for (Eigen::Index i = 0; i < b.size(); ++i) {
        x[i] = std::min(std::max(x[i] - (A.row(i).dot(x) + b[i]) / A(i, i), -c[i]), c[i]);
      }
    }
    return x;
  }
};

std::vector<RestingJoint> allStuck(int n) {
  std::vector<RestingJoint> joints(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) joints[static_cast<std::size_t>(i)].joint = i;
  return joints;
}

TEST(Complementarity, AgreesWithProjectedGaussSeidel) {
  int mostRounds = 0;
  for (const int n : {1, 2, 3, 8, 30}) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      DenseChain chain(n, seed);
      std::vector<RestingJoint> joints = allStuck(n);
      mostRounds = std::max(mostRounds, findWhatSticks(chain, joints, false));
      EXPECT_LT((chain.lambda - chain.byIteration()).cwiseAbs().maxCoeff(), 1e-9) << n << " joints, " << seed;
      for (const RestingJoint& one : joints) EXPECT_FALSE(one.mustStick);
    }
  }
  EXPECT_LT(mostRounds, 30);
}

TEST(Complementarity, OneByOneAgreesToo) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    DenseChain chain(8, seed);
    std::vector<RestingJoint> joints = allStuck(8);
    findWhatSticks(chain, joints, true);
    EXPECT_LT((chain.lambda - chain.byIteration()).cwiseAbs().maxCoeff(), 1e-9) << seed;
  }
}

// In folded chains a start may load other joints more. There rounds that change several joints at once may go
// in circles, of four joints and more. 1000 chains each, about 1 of 100 of which does.
TEST(Complementarity, EndsWhereRoundsGoInCircles) {
  for (const int n : {3, 4, 5, 6, 10}) {
    for (const bool oneByOne : {false, true}) {
      for (unsigned seed = 1; seed <= 1000; ++seed) {
        DenseChain chain(n, seed, 1, 1e-3);
        std::vector<RestingJoint> joints = allStuck(n);
        findWhatSticks(chain, joints, oneByOne);
        for (const RestingJoint& one : joints) {
          EXPECT_FALSE(one.mustStick) << n << " joints, " << seed;
          EXPECT_LE(one.direction == 0 ? one.excess : one.wrong, 1e-9) << n << " joints, " << seed;
        }
      }
    }
  }
}

// With noise each state of a joint that is near its limit is wrong: the decision must end all the same.
TEST(Complementarity, EndsWhereRoundingDecides) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    DenseChain chain(20, seed);
    std::vector<RestingJoint> joints = allStuck(20);
    findWhatSticks(chain, joints, false);
    chain.c = chain.c.cwiseMin(chain.lambda.cwiseAbs());  // stuck joints are at their limits now
    chain.noise = 1e-9;
    joints = allStuck(20);
    EXPECT_LE(findWhatSticks(chain, joints, false), 3 * 20 + 110) << seed;
    for (const RestingJoint& one : joints)
      EXPECT_LE(one.direction == 0 ? one.excess : one.wrong, 2e-9) << seed;
  }
}

// ---- The band ----------------------------------------------------------------------------------------

Scene levelChain(int links, double friction, const char* key = "friction", double length = 0.1,
                 double mass = 0.1) {
  Joint joint;
  if (std::string(key) == "damping") {
    joint.damping = friction;
  } else {
    joint.others.emplace_back(key, friction);
  }
  Scene scene = test::uniformChain(
      links, {"", mass, mass * length * length / 10, {length / 2, 0}, {length, 0}}, joint, joint, {0, -9.81});
  scene.integrator.tolerance = 1e-6;
  return scene;
}

TEST(StickSlip, AReleaseInVainWidensTheBandUntilTheJointMoves) {
  const Scene scene = levelChain(2, 0.5);
  StickSlip joints(scene.chain, 1e-6);
  double y[] = {0.25, 0.5, 0, 0};
  for (const int i : {0, 1}) joints.enter(i, y);
  joints.take();
  const double own = joints.limit(1) - 0.5;
  EXPECT_GT(own, 0);
  joints.start(1, 1);
  joints.rest(1, y, false);
  joints.take();
  EXPECT_NEAR(joints.limit(1) - 0.5, 4 * own, 1e-3 * own);
  joints.start(1, 1);
  y[1] += 1e-9;
  joints.rest(1, y, false);
  joints.take();
  EXPECT_NEAR(joints.limit(1) - 0.5, own, 1e-3 * own);
}

TEST(StickSlip, AClearStartInVainLeavesTheBand) {
  const Scene scene = levelChain(2, 0.5);
  StickSlip joints(scene.chain, 1e-6);
  const double y[] = {0.25, 0.5, 0, 0};
  for (const int i : {0, 1}) joints.enter(i, y);
  joints.take();
  const double limit = joints.limit(1);
  joints.start(1, 1);
  joints.startWith(1, 2000 * joints.leastStart(1), 0);
  joints.rest(1, y, false);
  EXPECT_EQ(joints.limit(1), limit);
  joints.start(1, 1);
  joints.startWith(1, 2000 * joints.leastStart(1), joints.leastStart(1));
  joints.rest(1, y, false);
  EXPECT_GT(joints.limit(1), limit);
}

// 20 N on a carriage with 9.81 N of friction and 14.7 N of breakaway: 9.81 N more at the same time hold it,
// whether they are given before its state or after.
TEST(StickSlip, AForceAtTheStartHoldsWhateverWasDecidedBefore) {
  const Scene scene = readSceneText(
      "{chain: [c, l], links: {c: {mass: 1, joint: {type: prismatic, axis: [0, 1], friction: 9.81, "
      "breakaway: "
      "14.7}}, l: {mass: 1, inertia: 0.1, com: [0, 0], pin: [0.1, 0]}}, gravity: [0, -10]}");
  constexpr double forever = std::numeric_limits<double>::infinity();
  for (const bool isFirst : {true, false}) {
    Simulation simulation(scene, 4);
    if (isFirst) simulation.holdTorque(0, 9.81, forever);
    simulation.setState({0, 0}, {0, 0});
    if (!isFirst) simulation.holdTorque(0, 9.81, forever);
    ASSERT_TRUE(simulation.advanceTo(1)) << simulation.fault();
    EXPECT_EQ(simulation.q()[0], 0) << isFirst;
  }
}

// ---- Bodies without inertia of their own, and joints at rest with other switches -----------------------

/// Comes loose at rest against its friction: ½ m q̇² r² + m g r sin q + c |q| = 0.
TEST(PointMasses, FallAgainstFriction) {
  for (const double inertia : {0., 1e-16, 1e-9}) {
    Simulation simulation(
        readSceneText("chain: [a]\nlinks: {a: {mass: 2, inertia: " + std::to_string(inertia * 1e10) +
                      "e-10, com: [0.5, 0], pin: [1, 0], joint: {friction: 0.3}}}\n"));
    ASSERT_TRUE(simulation.advanceTo(0.3)) << simulation.fault();
    const double q = simulation.q()[0], rate = simulation.qd()[0];
    EXPECT_LT(q, -0.5);
    EXPECT_NEAR(0.25 * rate * rate + 9.81 * std::sin(q) - 0.3 * q, 0, 1e-6) << "I = " << inertia;
  }
}

/// (m + M) s̈ = F − c at once, as nothing turns: a cart without mass carries a body that hangs at rest.
TEST(PointMasses, CartWithoutMassSlidesAgainstFriction) {
  Scene scene = readSceneText(
      "chain: [cart, bob]\nlinks:\n"
      "  cart: {mass: 0, joint: {type: prismatic, friction: 0.5}}\n"
      "  bob: {mass: 2, inertia: 0.1, com: [0, 0], pin: [1, 0]}\n"
      "loads: {f: {joint: cart_joint, torque: 3}}\n");
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(1)) << simulation.fault();
  EXPECT_NEAR(simulation.q()[0], (3 - 0.5) / 2 / 2, 1e-6);
}

/// The rate of a stuck joint is that of rounding: it is no switch of the joint's drag.
TEST(StuckJoints, DoNotSwitchTheirDrag) {
  const auto evaluations = [](const std::string& drag) {
    const std::string rod = "mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]";
    Simulation simulation(readSceneText("chain: [a, b, c]\nlinks:\n  a: {" + rod +
                                        "}\n"
                                        "  b: {" +
                                        rod + ", joint: {friction: 300" + drag +
                                        "}, initial: {angle: 0.3}}\n"
                                        "  c: {" +
                                        rod + ", joint: {friction: 300" + drag +
                                        "}, initial: {angle: -0.1}}\n"
                                        "loads: {l: {joint: a_joint, torque: 3, frequency: 2}}\n"));
    EXPECT_TRUE(simulation.advanceTo(5)) << simulation.fault();
    return simulation.statistics().evaluations;
  };
  EXPECT_LT(evaluations(", drag: 0.1"), 2 * evaluations(""));
}

// ---- Long chains -------------------------------------------------------------------------------------

long long evaluationsOf(const Scene& scene, double duration) {
  Simulation simulation(scene);
  const bool arrives =
      simulation.advanceTo(duration, [&] { return simulation.statistics().evaluations < 500000; });
  EXPECT_TRUE(arrives) << simulation.fault() << " at " << simulation.time();
  return simulation.statistics().evaluations;
}

// At each friction, whether it is above the rounding of the joint torques or far below: it does not hang.
TEST(LongChains, DoNotStall) {
  for (const auto& [links, length, mass] : {std::tuple{30, 0.05, 0.02}, {40, 1., 1.}, {300, 0.1, 0.1}}) {
    constexpr int most = 40;
    for (const double friction : {1e-300, 1e-14, 1e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-4, 1e-2}) {
      const double duration = links < 100 ? 0.3 : 0.1;
      const long long dampers = evaluationsOf(levelChain(links, friction, "damping", length, mass), duration);
      EXPECT_LT(evaluationsOf(levelChain(links, friction, "friction", length, mass), duration),
                most * dampers)
          << links << " links, " << friction << " N m";
    }
  }
}

// Joints between long stretches that stick break loose with next to no acceleration.
TEST(LongChains, HoldWhatHardlyStarts) {
  const long long dampers = evaluationsOf(levelChain(1000, 1e-7, "damping", 0.1, 0.1), 0.1);
  EXPECT_LT(evaluationsOf(levelChain(1000, 1e-7, "friction", 0.1, 0.1), 0.1), 40 * dampers);
}

TEST(LongChains, DoNotStallWhereTheyOnceDid) {
  struct Case {
    int links;
    double length, mass, friction, duration;
    const char* method;
  };
  for (const auto& [links, length, mass, friction, duration, method] :
       {Case{30, 0.05, 0.02, 1e-14, 0.3, "auto"}, Case{30, 1, 1, 1e-14, 0.3, "auto"},
        Case{30, 1, 1, 1e-10, 0.3, "auto"}, Case{40, 1, 1, 1e-300, 0.3, "auto"},
        Case{40, 1, 1, 1e-12, 0.3, "auto"}, Case{30, 1, 1, 1e-14, 0.3, "dopri5"},
        Case{1000, 0.1, 0.1, 1e-4, 0.02, "auto"}, Case{1000, 0.1, 0.1, 1e-7, 0.005, "auto"},
        Case{100, 0.1, 0.1, 1e-10, 0.1, "auto"}}) {
    SCOPED_TRACE(std::to_string(links) + " links, " + std::to_string(friction) + " N m, " + method);
    Scene scene = levelChain(links, friction, "friction", length, mass);
    scene.integrator.method = method;
    EXPECT_GT(evaluationsOf(scene, duration), 0);
  }
}

// As good as none: the motion without.
TEST(LongChains, WithFrictionBelowRoundingMoveAsWithout) {
  Simulation rubs(levelChain(40, 1e-14, "friction", 1, 1)), free(levelChain(40, 0, "damping", 1, 1));
  ASSERT_TRUE(rubs.advanceTo(0.3) && free.advanceTo(0.3)) << rubs.fault();
  for (std::size_t i = 0; i < 40; ++i) EXPECT_NEAR(rubs.q()[i], free.q()[i], 1e-6) << "joint " << i;
}

TEST(Friction, TooWeakForTheToleranceIsNoted) {
  const auto notesOf = [](const char* friction, const char* tolerance) {
    const Scene scene =
        readSceneText(std::string("chain: [a]\nlinks: {a: {mass: 1, inertia: 1, com: [0, 0], ") +
                      "pin: [1, 0], repeat: 3, joint: {friction: " + friction +
                      "}}}\nintegrator: {tolerance: " + tolerance + "}\n");
    return scene.notes.empty() ? "" : toString(scene.notes[0]);
  };
  EXPECT_EQ(
      notesOf("5e-11", "1e-8"),
      "links/a_1/joint/friction: is left out: it changes rates by less than a tenth of the tolerance in a "
      "second (and 2 more)");
  EXPECT_EQ(notesOf("5e-11", "1e-11"), "");
  EXPECT_EQ(notesOf("0", "1e-8"), "");
  EXPECT_EQ(notesOf("5e-11", "1e-8, method: rk4"), "");
  EXPECT_EQ(notesOf("5e-11", "1e-8, rate_tolerance: 1e-11"), "");
}

/// The damper of c is so stiff that the error of its rate decides whether a sticks: then it slides on.
TEST(Friction, BesideAStiffDamperSticksWhereItShould) {
  // a comes to rest pressed with 0.95 of its breakaway torque. Held by dop853 and radau13 at 1e-11.
  struct Case {
    const char *c, *friction;
    double held;
  };
  const auto sceneOf = [](const Case& of, const std::string& integrator) {
    return readSceneText(
        "chain: [a, b, c]\ngravity: [0, 0]\nlinks:\n"
        "  a: {mass: 1, inertia: 0.1, com: [0, 0], pin: [0.5, 0], joint: {" +
        std::string(of.friction) +
        "}, initial: {velocity: 0.24}}\n"
        "  b: {mass: 0.5, inertia: 0.1, com: [0, 0], pin: [0.5, 0], joint: {rotor_inertia: 1}}\n"
        "  c: {mass: 1, inertia: 0.05, com: [0.3, 0], pin: [0.5, 0], joint: {" +
        of.c + "}}\nloads: {u: {joint: a_joint, torque: -1.9}}\nintegrator: {" + integrator + "}\n");
  };
  const char* brake = "friction: 0.6, breakaway: 2";
  for (const Case& of : {Case{"damping: 15000", brake, 0.014674477806},
                         Case{"stiffness: 3e+5, damping: 5000", brake, 0.014674931718}}) {
    for (const char* method : {"auto", "rodas5p", "radau13"}) {
      for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
        std::ostringstream integrator;
        integrator << "method: " << method << ", tolerance: " << tolerance;
        Simulation simulation(sceneOf(of, integrator.str()));
        EXPECT_TRUE(simulation.advanceTo(0.5)) << simulation.fault();
        EXPECT_NEAR(simulation.q()[0], of.held, 2 * tolerance) << of.c << ", " << integrator.str();
      }
    }
  }
  // Only the scenes that need it pay for it.
  const Case needs{"damping: 15000", brake, 0}, sticksSoonAfter{"damping: 15000", "friction: 2", 0};
  EXPECT_EQ(sceneOf(needs, "tolerance: 1e-6").integrator.rateTolerance, 3e-4 * 2 / 15000);
  EXPECT_EQ(sceneOf(needs, "tolerance: 1e-6, rate_tolerance: 1e-3").integrator.rateTolerance, 1e-3);
  EXPECT_FALSE(sceneOf(needs, "tolerance: 1e-9").integrator.rateTolerance);
  EXPECT_FALSE(sceneOf(needs, "tolerance: 1e-6, method: rk4").integrator.rateTolerance);
  EXPECT_FALSE(sceneOf(sticksSoonAfter, "tolerance: 1e-6").integrator.rateTolerance);
}

/// b leans on a damped stop and holds c, which its breakaway torque holds.
TEST(Friction, BesideAStiffDamperOfAStopSticksWhereItShould) {
  for (const char* tolerance : {"1e-3", "1e-5", "1e-7"}) {
    const Scene scene = readSceneText(
        "chain: [a, b, c]\nlinks:\n"
        "  a: {mass: 1, inertia: 0.05, com: [0.4, 0], pin: [0.8, 0], initial: {angle: -0.63}, joint: "
        "{friction: 0.1, breakaway: 1, stop_stiffness: 6e+4, stop_damping: 70, lower: -0.63}}\n"
        "  b: {mass: 1, inertia: 0.05, com: [0.4, 0], pin: [0.8, 0], initial: {angle: 0.41}, joint: "
        "{friction: 1, breakaway: 1.5, stop_stiffness: 130, stop_damping: 9e+5, lower: 0.42}}\n"
        "  c: {mass: 1, inertia: 0.05, com: [0.4, 0], pin: [0.8, 0], initial: {angle: 0.72}, joint: "
        "{friction: 1, breakaway: 10}}\nintegrator: {tolerance: " +
        std::string(tolerance) + "}\n");
    Simulation simulation(scene);
    EXPECT_TRUE(simulation.advanceTo(1)) << simulation.fault();
    EXPECT_NEAR(simulation.q()[0], -0.6304975, 1e-6) << tolerance;  // by scipy's Radau
    EXPECT_EQ(simulation.q()[2], 0.72) << tolerance;
  }
}

/// A joint that comes to rest with a rate of exactly 0 sticks there, not where it was at rest before.
TEST(Friction, HoldsAJointWhereItsRateIsExactlyZero) {
  const Scene scene = readSceneText(
      "chain: [a]\ngravity: [0, 0]\nlinks: {a: {mass: 1, inertia: 1, com: [0, 0], pin: [1, 0], "
      "joint: {friction: 2}}}\n");
  Dynamics dynamics(scene);
  std::vector<double> y(index(dynamics.size()));
  y[1] = 1;
  dynamics.enterState(0, y.data());
  y[0] = 0.25;
  y[1] = 0;
  dynamics.fire(0.5, y.data());
  EXPECT_EQ(y[0], 0.25);
  dynamics.hold(0.5, y.data());
  EXPECT_EQ(y[0], 0.25);
}

}  // namespace
}  // namespace planar_chain
