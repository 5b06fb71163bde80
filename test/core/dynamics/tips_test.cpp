/// Chains whose tip is held.
///
///     trajectories      against dense equations of Lagrange (reference/ends/make.py), by four methods
///     slider-crank      the piston in closed form
///     hanging chain     the catenary of links: the pull is the same everywhere, the rest follows
///     four-bar          there and back
///     closed chain      keeps its energy, and its closure at each state

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <string>

#include "known_motion.h"
#include "planar_chain/kane.h"
#include "planar_chain/linear_model.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "reference/ends/values.h"

namespace planar_chain {
namespace {

std::string pair(const std::vector<double>& at) {
  return "[" + toText(at[0]) + ", " + toText(at[1]) + "]";
}

const std::string crank = "{mass: 0.5, inertia: 0.01, com: [0.2, 0.05], pin: [0.4, 0], ";
const std::string coupler = "{mass: 0.8, inertia: 0.05, com: [0.5, 0.1], pin: [1.0, 0], ";
const std::string rocker = "{mass: 0.3, inertia: 0.02, com: [0.4, -0.03], pin: [0.8, 0], ";
const std::string bent = "{mass: 0.3, inertia: 0.004, com: [0.2, -0.03], pin: [0.7, 0.1], ";

std::string fourBar(const std::string& damping = "0.02",
                    const std::string& rocking = "stiffness: 2, damping: 0.1") {
  return "chain: [crank, coupler, rocker]\ntip: {pin: " + pair(reference::fourBarTip) +
         "}\nlinks:\n  crank: " + crank + "joint: {damping: " + damping +
         "}, initial: {angle: 1.2, velocity: 3.0}}\n  coupler: " + coupler +
         "initial: {angle: -1.0}}\n  rocker: " + rocker + "joint: {" + rocking +
         "}, initial: {angle: -1.5}}\n";
}
const std::string slung = "chain: [a, b, c, d]\ntip: {pin: {x: {amplitude: 0.2, frequency: 0.7, offset: " +
                          toText(reference::slungTip[0]) +
                          "}, y: {offset: " + toText(reference::slungTip[1]) + "}}}\nlinks:\n  a: " + crank +
                          "initial: {angle: -1.2, velocity: 1.0}}\n  b: " + coupler +
                          "joint: {rotor_inertia: 0.1}, initial: {angle: 0.5}}\n  c: " + rocker +
                          "initial: {angle: 0.5}}\n  d: " + rocker + "initial: {angle: 0.5}}\n";
const std::string stiffLoop =
    "chain: [a, b, c, d]\ntip: {pin: " + pair(reference::stiffLoopTip) + "}\nlinks:\n  a: " + crank +
    "joint: {damping: 0.1}, initial: {angle: 1.2, velocity: 3.0}}\n  b: " + coupler +
    "joint: {stiffness: 300, rest_angle: -1, damping: 4}, initial: {angle: -1.0}}\n  c: " + rocker +
    "joint: {stiffness: 100, rest_angle: -1.2}, initial: {angle: -1.5}}\n  d: " + bent +
    "joint: {damping: 0.05}, initial: {angle: -0.8}}\n";
const std::string sliderCrank =
    "chain: [crank, rod]\ntip: {line: {point: " + pair(reference::sliderCrankTip) +
    ", direction: [8, 6]}}\nlinks:\n  crank: " + crank +
    "initial: {angle: 1.2, velocity: 3.0}}\n  rod: " + coupler + "initial: {angle: -1.0}}\n";
const std::string heldCart =
    "chain: [cart, pole, lower]\ntip: {pin: " + pair(reference::heldCartTip) +
    "}\nlinks:\n  cart: {mass: 2.0, pin: [0.0, 0.1], joint: {type: prismatic, axis: [1, 0], stiffness: 5, "
    "damping: 0.3}, initial: {position: 0.1, velocity: 0.2}}\n  pole: {mass: 0.5, inertia: 0.01, com: [0.4, "
    "0.05], pin: [0.8, 0], initial: {angle: -1.2, velocity: 0.4}}\n  lower: " +
    bent + "initial: {angle: 1.7}}\n";
const std::string turnedHeldCart =
    "chain: [cart, pole, lower]\nbase: {x: {amplitude: 0.03, frequency: 1.1}, angle: {amplitude: 0.2, "
    "frequency: 0.6, "
    "offset: 0.1}}\ntip: {pin: " +
    pair(reference::turnedHeldCartTip) +
    "}\nlinks:\n  cart: {mass: 2.0, pin: [0.0, 0.1], joint: {type: prismatic, stiffness: 20, damping: 0.3}, "
    "initial: "
    "{position: 0.1, velocity: 0.2}}\n  pole: {mass: 0.5, inertia: 0.01, com: [0.4, 0.05], pin: [0.8, 0], "
    "initial: "
    "{angle: -1.2, velocity: 0.4}}\n  lower: " +
    bent + "initial: {angle: 1.7}}\n";

// ---- Trajectories ----------------------------------------------------------------------------------

class HeldTips : public testing::TestWithParam<const char*> {};

TEST_P(HeldTips, MoveAsDenseEquationsSay) {
  for (const test::KnownMotion& known : std::initializer_list<test::KnownMotion>{
           {"fourBar", fourBar(), reference::fourBar},
           {"slung", slung, reference::slung},
           {"stiffLoop", stiffLoop, reference::stiffLoop},
           {"sliderCrank", sliderCrank, reference::sliderCrank},
           {"heldCart", heldCart, reference::heldCart},
           {"turnedHeldCart", turnedHeldCart, reference::turnedHeldCart}}) {
    test::expectMotion(known, GetParam(), 1e-8);
  }
}

INSTANTIATE_TEST_SUITE_P(By, HeldTips, testing::Values("auto", "dop853", "rodas5p", "radau13"));

// ---- Matrices --------------------------------------------------------------------------------------

TEST(HeldTip, MovesAsKanesEquationsSay) {
  for (const std::string& text : {fourBar(), slung, stiffLoop, sliderCrank, heldCart, turnedHeldCart}) {
    const Scene scene = readSceneText(text);
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(0.7));
    const Eigen::Index n = scene.chain.size();
    const Eigen::VectorXd q = Eigen::VectorXd::Map(simulation.q().data(), n),
                          qd = Eigen::VectorXd::Map(simulation.qd().data(), n);
    const auto dense = [&](const Eigen::VectorXd& x) {
      return kane(scene.chain, x.head(n), x.tail(n), activeForces(scene, 0.7, x.head(n), x.tail(n)));
    };
    const Eigen::VectorXd state = (Eigen::VectorXd(2 * n) << q, qd).finished();
    const Kane at = dense(state);
    Eigen::VectorXd qdd(n);
    simulation.accelerations(qdd.data());
    EXPECT_LT((qdd - at.qdd).norm(), 1e-9 * (1 + qdd.norm())) << text;
    const Vec2d force = simulation.tipForce();
    EXPECT_NEAR(at.phi.norm(), length(force), 1e-8 * (1 + length(force))) << text;
    // What moves by itself takes no torque.
    EXPECT_LT(inverseDynamics(scene, 0.7, q, qd, qdd).norm(), 1e-8 * (1 + at.f.norm())) << text;
    EXPECT_THROW(inverseDynamics(scene, 0.7, q, qd, qdd + Eigen::VectorXd::Ones(n)), Refused) << text;

    const LinearModel model = linearModel(scene, 0.7, q, qd);
    constexpr double h = 1e-5;
    for (Eigen::Index i = 0; i < 2 * n; ++i) {
      const Eigen::VectorXd to = h * Eigen::VectorXd::Unit(2 * n, i);
      const Eigen::VectorXd slope = (dense(state + to).qdd - dense(state - to).qdd) / (2 * h);
      EXPECT_LT((model.A.col(i).tail(n) - slope).norm(), 1e-6 * (1 + model.A.norm())) << text << i;
    }
  }
}

// ---- Projection ------------------------------------------------------------------------------------

/// A state that is set moves by −M⁻¹ Jᵀ (J M⁻¹ Jᵀ)⁻¹ times what it misses: the least in the metric of M.
TEST(HeldTip, IsReachedByTheLeastMotion) {
  const auto least = [](const Kane& at, const Eigen::VectorXd& missing) -> Eigen::VectorXd {
    const Eigen::MatrixXd W = at.M_q.inverse() * at.J_c.transpose();
    return W * (at.J_c * W).inverse() * missing;
  };
  for (const std::string& text : {fourBar(), slung, stiffLoop, sliderCrank, heldCart}) {
    const Scene scene = readSceneText(text);
    Simulation simulation(scene);
    const Eigen::Index n = scene.chain.size();
    const auto kaneAt = [&](const std::vector<double>& q) {
      const Eigen::VectorXd at = Eigen::VectorXd::Map(q.data(), n), still = Eigen::VectorXd::Zero(n);
      return kane(scene.chain, at, still, activeForces(scene, 0, at, still));
    };
    const std::vector<double> closed = simulation.q();
    Eigen::VectorXd away = Eigen::VectorXd::Map(closed.data(), n), rates(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      away[i] += 1e-6 * std::sin(1.0 + 3.0 * static_cast<double>(i));
      rates[i] = std::cos(2.0 * static_cast<double>(i));
    }
    const auto list = [n](const Eigen::VectorXd& x) { return std::vector<double>(x.data(), x.data() + n); };
    simulation.setState(list(away), list(rates));
    const Eigen::VectorXd q = Eigen::VectorXd::Map(simulation.q().data(), n),
                          qd = Eigen::VectorXd::Map(simulation.qd().data(), n);

    const Kane before = kaneAt(closed), after = kaneAt(simulation.q());
    const Eigen::VectorXd gap = before.J_c * (Eigen::VectorXd::Map(closed.data(), n) - away);
    EXPECT_GT(gap.norm(), 1e-8) << text;
    EXPECT_LT((q - away - least(before, gap)).norm(), 2e-11) << text;  // of second order
    const Eigen::Vector2d given(scene.tip->x.at(0).rate, scene.tip->y.at(0).rate);
    const Eigen::VectorXd tip = activeForces(scene, 0, q, qd).tipRows * given;
    EXPECT_LT((qd - rates - least(after, tip - after.J_c * rates)).norm(), 1e-12) << text;
  }
}

/// The answer of the tip to forces is J M⁻¹ Jᵀ, with J of both directions.
TEST(HeldTip, HasTheMarginOfTheDenseEquations) {
  for (const std::string& text : {fourBar(), slung, stiffLoop, sliderCrank}) {
    const Scene scene = readSceneText(text);
    Simulation simulation(scene);
    const Eigen::Index n = scene.chain.size();
    const Eigen::VectorXd q = Eigen::VectorXd::Map(simulation.q().data(), n),
                          still = Eigen::VectorXd::Zero(n);
    ActiveForces active = activeForces(scene, 0, q, still);
    const Eigen::MatrixXd rows = active.tipRows;
    active.tipRows = Eigen::Matrix2d::Identity();
    const Kane at = kane(scene.chain, q, still, active);
    const Eigen::Matrix2d answer = at.J_c * at.M_q.inverse() * at.J_c.transpose();
    const Eigen::Vector2d sizes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(answer).eigenvalues();
    const double least = rows.rows() == 2 ? sizes[0] : (rows * answer * rows.transpose())(0, 0);
    EXPECT_NEAR(simulation.closureMargin(), least / sizes[1], 1e-12) << text;
  }
}

TEST(HeldTip, TellsHowNearItsChainIsToBeingStretched) {
  // Two rods of length 1 to a tip at this distance: the larger the angle between them, the larger the margin.
  const auto marginAt = [](double distance) {
    Simulation simulation(
        readSceneText("chain: [a, b]\ntip: {pin: [" + toText(distance) +
                      ", 0]}\nlinks:\n  a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], "
                      "initial: {angle: 0.5}}\n  b: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: "
                      "[1, 0], initial: {angle: -1}}\n"));
    return simulation.closureMargin();
  };
  EXPECT_GT(marginAt(1.5), 0.01);
  EXPECT_LT(marginAt(1.999), marginAt(1.9));
  EXPECT_LT(marginAt(2), 1e-9);
  // On a line, a rod that is driven away from it comes to stand across it, where it moves the tip no further.
  Simulation turned(
      readSceneText("chain: [crank, rod]\ntip: {line: {point: [0, 0.3], direction: [1, 0]}}\nlinks:\n  "
                    "crank: {mass: 1, inertia: "
                    "0.05, com: [0.5, 0], pin: [1, 0], joint: {drive: {amplitude: 3, frequency: 1, offset: "
                    "0.5}}}\n  rod: {mass: 1, "
                    "inertia: 0.05, com: [0.5, 0], pin: [1, 0]}\n"));
  const double atStart = turned.closureMargin();
  EXPECT_FALSE(turned.advanceTo(2));
  EXPECT_LT(turned.closureMargin(), 1e-9 * atStart);
  EXPECT_NE(turned.fault().find("straight or folded"), std::string::npos) << turned.fault();
  EXPECT_NE(turned.fault().find("(other lengths, drives, or another place of the tip avoid this pose); "),
            std::string::npos)
      << turned.fault();
  EXPECT_EQ(
      Simulation(readSceneText("chain: [a]\nlinks: {a: {mass: 1, inertia: 0, com: [1, 0], pin: [1, 0]}}\n"))
          .closureMargin(),
      1);
}

/// While the crank turns one way, its friction is a constant torque. At rest it may hold the four-bar.
TEST(FourBar, RubsInItsCrank) {
  std::string rubbing = fourBar("0.02, friction: 1.5"),
              loaded = fourBar() + "loads: {rub: {joint: crank_joint, torque: -1.5}}\n";
  for (const char* method : {"auto", "dop853", "rodas5p", "radau13"}) {
    Scene scene = readSceneText(rubbing), other = readSceneText(loaded);
    for (Scene* one : {&scene, &other}) {
      one->integrator.method = method;
      one->integrator.tolerance = 1e-10;
    }
    Simulation simulation(scene), reference(other);
    double t = 0;
    while (simulation.qd()[0] > 0) {
      t += 0.01;
      ASSERT_LT(t, 2) << method;
      ASSERT_TRUE(simulation.advanceTo(t) && reference.advanceTo(t)) << simulation.fault();
      for (std::size_t i = 0; i < 3 && simulation.qd()[0] > 0; ++i)
        EXPECT_NEAR(simulation.q()[i], reference.q()[i], 1e-8) << method << " at " << t;
    }
    EXPECT_GT(t, 0.05);
    ASSERT_TRUE(simulation.advanceTo(20)) << simulation.fault();
    for (const double rate : simulation.qd()) EXPECT_NEAR(rate, 0, 1e-12) << method;
    EXPECT_LT(std::abs(simulation.energyBalance().residual), 1e-7) << method;
    EXPECT_LT(simulation.closureError(), 1e-13);
    // What holds it is no more than the breakaway torque.
    std::vector<double> tau(3);
    simulation.jointTorques(tau.data());
    EXPECT_LE(std::abs(tau[0]), 1.5 + 1e-6);
    EXPECT_GT(std::abs(tau[0]), 0);
  }
}

TEST(FourBar, IsHeldByABreakawayTorqueWhereItFirstStops) {
  for (const char* method : {"auto", "dop853", "rodas5p", "radau13"}) {
    Scene scene = readSceneText(fourBar("0.02, friction: 0.3, breakaway: 20"));
    scene.integrator.method = method;
    Simulation simulation(scene);
    double t = 0, last = 0;
    for (; simulation.qd()[0] > 1e-12 && t < 2; t += 0.01) {
      last = simulation.q()[0];
      ASSERT_TRUE(simulation.advanceTo(t)) << simulation.fault();
    }
    ASSERT_LT(t, 2) << method << ": the crank turns back";
    const double stopped = simulation.q()[0];
    EXPECT_GE(stopped, last);
    ASSERT_TRUE(simulation.advanceTo(5)) << simulation.fault();
    EXPECT_NEAR(simulation.q()[0], stopped, 1e-9) << method;
  }
}

/// Coupler and rocker are straight: they sag by their weight, and the crank turns against its brake of 392 N
/// m until all is at rest. So the brake takes what the weights give.
TEST(FourBar, SagsFromItsDeadCentreAgainstABrake) {
  Scene scene = readSceneText(
      "{chain: [a, b, c], links: {a: {mass: 0.01, inertia: 0, com: [0.25, 0], pin: [0.5, 0], initial: "
      "{angle: "
      "0.7853981633974483}, joint: {friction: 392}}, b: {mass: 0.1, inertia: 0.1, com: [0.5, 0], pin: [1, "
      "0], "
      "initial: {angle: 2.0943951023931953}}, c: {mass: 1, inertia: 0, com: [0.3, 0], pin: [0.3, 0]}}, tip: "
      "{pin: "
      "[-0.902150192374, 0.690018337754]}}");
  for (const char* method : {"auto", "dop853", "rodas5p", "radau13"}) {
    scene.integrator.method = method;
    Simulation simulation(scene);
    const double start = simulation.q()[0], before = simulation.energy().potential;
    std::vector<double> tau(3);
    for (int k = 1; k <= 200; ++k) {
      ASSERT_TRUE(simulation.advanceTo(1e-3 * k)) << simulation.fault();
      simulation.jointTorques(tau.data());
      if (std::abs(simulation.qd()[0]) > 1e-8) {
        EXPECT_NEAR(std::abs(tau[0]), 392, 1e-9) << method;
      }
    }
    const double turned = simulation.q()[0] - start;
    EXPECT_GT(turned, 1e-7);
    EXPECT_NEAR(392 * turned, before - simulation.energy().potential, 1e-3 * 392 * turned) << method;
    for (const double rate : simulation.qd()) EXPECT_NEAR(rate, 0, 1e-12) << method;
  }
}

/// Three sides of a square, the tip on the line of the fourth. Two joints rub. Neither alone holds a torque
/// of 1.5 times its friction; both together do.
TEST(ClosedChain, IsHeldByTwoJointsTogether) {
  Scene scene = readSceneText(
      "{chain: [a, b, c], links: {a: {mass: 1, inertia: 8e-4, com: [0.05, 0], pin: [0.1, 0], joint: "
      "{friction: 4.905}}, "
      "b: {mass: 1, inertia: 8e-4, com: [0.05, 0], pin: [0.1, 0], initial: {angle: 1.5707963267948966}, "
      "joint: "
      "{friction: 4.905}}, c: {mass: 1, inertia: 8e-4, com: [0.05, 0], pin: [0.1, 0], initial: {angle: "
      "1.5707963267948966}}}, gravity: [0, 0], loads: {torque: {joint: a_joint, torque: 7.3575}}, tip: "
      "{line: {point: [0, 0.1], direction: [0, 1]}}}");
  for (const char* method : {"auto", "dopri5", "rodas5p", "radau13"}) {
    for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
      scene.integrator.method = method;
      scene.integrator.tolerance = tolerance;
      Simulation simulation(scene);
      const std::vector<double> start = simulation.q();
      ASSERT_TRUE(simulation.advanceTo(0.5)) << simulation.fault();
      EXPECT_LT(simulation.statistics().steps, 1000) << method;
      for (const int i : {0, 1}) EXPECT_NEAR(simulation.q()[index(i)], start[index(i)], 1e-9) << method;
    }
  }
}

/// A brake whose breakaway torque is ten times its friction holds the chain. The projection of a state leaves
/// rates of rounding, with which it slid.
TEST(ClosedChain, StaysAtRestWhenItsStateIsGivenOn) {
  const Scene scene = readSceneText(
      "{chain: [a, b, c], links: {a: {mass: 1000, inertia: 83.333, com: [0.5, 0], pin: [1, 0], initial: "
      "{angle: "
      "1.0471975511965976}}, b: {mass: 1000, inertia: 83.333, com: [0.5, 0], pin: [1, 0], initial: {angle: "
      "1.0471975511965976}, joint: {friction: 19620, breakaway: 196200, stiffness: 9810}}, c: {mass: 1000, "
      "inertia: "
      "83.333, com: [0.5, 0], pin: [1, 0], initial: {angle: 1.0471975511965976}, joint: {stiffness: 9810, "
      "rest_angle: 1.5707963267948966}}}, gravity: [0, 9.81], tip: {pin: [-1, 1.732050807569]}}");
  Simulation simulation(scene);
  const std::vector<double> start = simulation.q();
  for (const double rate : {0.0, 1e-50, 1e-18, 1e-12}) {
    simulation.setState(start, {rate, 0, -rate});
    ASSERT_TRUE(simulation.advanceTo(simulation.time() + 0.1)) << simulation.fault();
    for (std::size_t i = 0; i < start.size(); ++i) EXPECT_NEAR(simulation.q()[i], start[i], 1e-12) << rate;
  }
}

/// The crank turns back where the rest is nearly straight, while a law moves the tip: what rounding leaves of
/// its rate is 1e-4 rad/s of the other joints.
TEST(FourBar, KeepsItsEnergyWhereItsCrankTurnsBackBesideAMovingTip) {
  Scene scene = readSceneText(
      "{chain: [l0, l1, l2], links: {l0: {mass: 0.5, inertia: 0.16666666666666666, com: [1, 0], pin: [2, 0], "
      "initial: "
      "{angle: 3.141592653589793}, joint: {friction: 7.3575, breakaway: 10}}, l1: {mass: 0.1, inertia: 0, "
      "com: [0.5, "
      "0], pin: [0.5, 0]}, l2: {mass: 100, inertia: 0, com: [2, 0], pin: [2, 0], initial: {angle: "
      "-2.0943951023931953}, joint: {stiffness: 19620}}}, gravity: [9.81, 0], integrator: {method: dop853, "
      "tolerance: "
      "1e-10}, tip: {pin: {x: {times: [0.3, 0.6], values: [-1.5, -1.55]}, y: {offset: 1.732050807569}}}}");
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(0.31)) << simulation.fault();
  EXPECT_LT(std::abs(simulation.energyBalance().residual), 1e-5);
}

/// Two joints rub, and the tip is on a line. One breaks loose at the instant at which the other comes to
/// rest.
TEST(ClosedChain, LetsOneJointGoWhereAnotherTurnsBack) {
  Scene scene = readSceneText(
      "{chain: [l0, l1, l2, l3], links: {l0: {mass: 0.5719886086106248, inertia: 0.022807217907195483,"
      " com: [0.43476316352291006, -0.06395670244349043], pin: [0.6843773248621583, 0.0], initial: {an"
      "gle: 1.5131146759491507}, joint: {friction: 2.4690993361542692, drag: 0.029053931596717174}}, l"
      "1: {mass: 0.37470693941494265, inertia: 0.0, com: [0.18871165157323597, -0.01956093104333136], "
      "pin: [0.28448403080690615, 0.00027382612429374003], initial: {angle: 0.28463088505977696, veloc"
      "ity: 2.8538739638335464}, joint: {friction: 0.5550641081069131, rotor_inertia: 0.00191948351337"
      "42262}}, l2: {mass: 1.9270526245350568, inertia: 0.01841221335202196, com: [0.2362360684053922,"
      " 0.01711660685756675], pin: [0.3120844002015171, -0.01751710215290548], initial: {angle: 0.4174"
      "0189820138784}, joint: {damping: 0.013904126027377353}}, l3: {mass: 1.1126098281744978, inertia"
      ": 0.06975822306751674, com: [0.15493606016506528, 0.008917071040173755], pin: [0.72444930188716"
      "74, 0.0], initial: {angle: -0.9505592404015325, velocity: 0.2296481066922334}, joint: {rotor_in"
      "ertia: 0.0054512981672953835}}}, tip: {line: {point: [0.02010048586601751, 1.9111474850633912],"
      " direction: [-0.9591404589268087, 0.28293034487249874]}}, gravity: [-2.9270275311478464, -4.377"
      "341349191591]}");
  const auto after = [&](const char* method, double tolerance) {
    scene.integrator.method = method;
    scene.integrator.tolerance = tolerance;
    Simulation simulation(scene);
    EXPECT_TRUE(simulation.advanceTo(0.4) && simulation.advanceTo(0.71)) << simulation.fault();
    return simulation.qd();
  };
  const std::vector<double> exact = after("auto", 1e-12);
  EXPECT_GT(exact[1], 0.04) << "the second joint slides";
  for (const auto& [method, tolerance] : {std::pair{"auto", 1e-6}, std::pair{"radau13", 1e-8}}) {
    const std::vector<double> rates = after(method, tolerance);
    for (std::size_t i = 0; i < rates.size(); ++i) EXPECT_NEAR(rates[i], exact[i], 1e-4) << method;
  }
}

/// A piston that rubs in its cylinder, on a flywheel; no gravity. With the angle φ of the crank,
///
///     s(φ) = −r cos φ + √(l² − r² sin² φ)      ½ I(φ) φ̇² = E_0 − F × (path of s)
///
/// and s runs through 2r in half a turn. At both dead centres ṡ = 0 and friction changes sign, but no
/// friction can hold the piston there.
class Engine {
 public:
  static constexpr double r = 0.06, l = 0.2;
  /// Before its dead centre, and turning fast.
  static std::string running(const std::string& rubbing, const std::string& method) {
    return scene(rubbing, method, "position: 0.25", "angle: 2.9", "angle: 1, velocity: -30");
  }
  /// At rest in its dead centre, with a moment on the crank.
  static std::string waiting(const std::string& rubbing, const std::string& method) {
    return scene(rubbing, method, "position: 0.14", "angle: 3.141592653589793", "angle: -3.141592653589793") +
           "loads: {push: {link: crank, moment: 0.5, start: 0.1}}\n";
  }
  static std::string scene(const std::string& rubbing, const std::string& method, const std::string& piston,
                           const std::string& arm, const std::string& wheel) {
    return "chain: [piston, rod, crank]\ntip: {pin: [0, 0]}\ngravity: [0, 0]\nintegrator: {method: " +
           method +
           ", tolerance: 1e-9}\nlinks:\n  piston: {mass: 0.5, pin: [0, 0], joint: {type: prismatic, axis: "
           "[1, 0], " +
           rubbing + "}, initial: {" + piston +
           "}}\n  rod: {mass: 0.3, inertia: 0.001, com: [0.1, 0], pin: [0.2, 0], initial: {" + arm +
           "}}\n  crank: {mass: 2, inertia: 0.01, com: [0.06, 0], pin: [0.06, 0], initial: {" + wheel +
           "}}\n";
  }
  static double phi(const Simulation& simulation) { return simulation.q()[1] + simulation.q()[2]; }
  static double energy(const Simulation& simulation) {
    const double at = phi(simulation), rate = simulation.qd()[1] + simulation.qd()[2];
    const double sine = r / l * std::sin(at), cosine = std::sqrt(1 - sine * sine);
    const double rod = r / l * std::cos(at) / cosine;  // −dθ/dφ of the rod, which points to −x
    const double s = r * std::sin(at) - l * sine * rod;
    const double x = s + 0.1 * sine * rod, y = 0.1 * cosine * rod;
    return (0.5 * s * s + 0.3 * (x * x + y * y) + 0.001 * rod * rod + 0.01) * rate * rate / 2;
  }
  /// Of the piston while the crank turns backwards from one angle to another.
  static double path(double from, double to) {
    const auto s = [](double at) {
      return -r * std::cos(at) + std::sqrt(l * l - std::pow(r * std::sin(at), 2));
    };
    const double last = std::floor(from / pi) * pi,
                 first = std::ceil(to / pi) * pi;  // dead centres on the way
    if (last < first) return std::abs(s(from) - s(to));
    return std::abs(s(from) - s(last)) + 2 * r * std::round((last - first) / pi) + std::abs(s(first) - s(to));
  }
};

TEST(Engine, RubsThroughItsDeadCentres) {
  for (const std::string method : {"auto", "dopri5", "dop853", "rodas5p", "radau13"}) {
    for (const auto& [force, rubbing] : {std::pair{0.02, "friction: 0.02"}, std::pair{5., "friction: 5"},
                                         std::pair{5., "friction: 5, breakaway: 9"}}) {
      Simulation simulation(readSceneText(Engine::running(rubbing, method)));
      const double start = Engine::phi(simulation), energy = Engine::energy(simulation);
      ASSERT_NEAR(simulation.energy().kinetic, energy, 1e-12);
      for (int k = 1; k <= 10; ++k) {
        ASSERT_TRUE(simulation.advanceTo(0.2 * k)) << method << " " << rubbing << ": " << simulation.fault();
        const double left = energy - force * Engine::path(start, Engine::phi(simulation));
        ASSERT_NEAR(Engine::energy(simulation), left, 2e-7 * energy) << method << " " << rubbing << " " << k;
      }
      EXPECT_GT(start - Engine::phi(simulation), 20) << "turns past six dead centres";
      if (force < 1) continue;
      ASSERT_TRUE(simulation.advanceTo(20)) << method << " " << rubbing << ": " << simulation.fault();
      EXPECT_LT(Engine::energy(simulation), 1e-20) << "it has come to rest";
    }
  }
}

TEST(Engine, StartsFromItsDeadCentre) {
  for (const std::string method : {"auto", "dopri5", "dop853", "rodas5p", "radau13"}) {
    for (const auto& [force, rubbing] :
         {std::pair{5., "friction: 5"}, std::pair{5., "friction: 5, breakaway: 6"},
          std::pair{0., "breakaway: 3"}}) {
      Simulation simulation(readSceneText(Engine::waiting(rubbing, method)));
      const double start = Engine::phi(simulation);
      ASSERT_TRUE(simulation.advanceTo(0.1)) << method << " " << rubbing << ": " << simulation.fault();
      ASSERT_NEAR(Engine::phi(simulation), start, 1e-12) << "nothing acts yet";
      for (int k = 1; k <= 10; ++k) {
        ASSERT_TRUE(simulation.advanceTo(0.1 + 0.1 * k))
            << method << " " << rubbing << ": " << simulation.fault();
        const double turned = Engine::phi(simulation) - start;
        const double left = 0.5 * turned - force * Engine::path(turned, 0);
        ASSERT_NEAR(Engine::energy(simulation), left, 2e-7) << method << " " << rubbing << " " << k;
      }
      EXPECT_GT(Engine::phi(simulation) - start, 2 * pi) << method << " " << rubbing;
    }
  }
}

/// A drive turns the crank of a four-bar as far as it goes. Steps become too small before the pose is exact.
TEST(ClosedChain, NamesAPoseThatEndsItsWayAtAnyTolerance) {
  const auto bar = [](const char* name, double length, const char* rest) {
    const std::string p = toText(length), half = toText(length / 2);
    return std::string("  ") + name + ": {mass: 1, inertia: 0.08, com: [" + half + ", 0], pin: [" + p +
           ", 0], " + rest + "}\n";
  };
  for (const char* method : {"dopri5", "dop853", "rodas5p"}) {
    for (const double tolerance : {1e-9, 3e-10, 1e-10, 3e-11, 1e-11}) {
      Scene scene = readSceneText("chain: [a, b, c]\ntip: {pin: [1.3, 0]}\nlinks:\n" +
                                  bar("a", 1, "joint: {drive: {amplitude: 2, frequency: 0.7, offset: 1.2}}") +
                                  bar("b", 1, "initial: {angle: 1}") + bar("c", 0.7, "initial: {angle: -2}"));
      scene.integrator.method = method;
      scene.integrator.tolerance = tolerance;
      Simulation simulation(scene);
      EXPECT_FALSE(simulation.advanceTo(3));
      EXPECT_NE(simulation.fault().find("straight or folded"), std::string::npos)
          << method << " at " << tolerance << ": " << simulation.fault();
    }
  }
}

/// At its change point a parallelogram could go on as an antiparallelogram. See change_points_test.
TEST(ClosedChain, KeepsItsBranchAtAChangePoint) {
  for (const char* method : {"auto", "dopri5", "rodas5p", "radau13"}) {
    for (const double tolerance : {1e-3, 1e-5, 1e-7, 1e-9, 1e-11}) {
      Scene scene = readSceneText(
          "chain: [a, b, c]\ntip: {pin: [1, 0]}\nlinks:\n  a: {mass: 1, inertia: 0.05, com: [0.25, 0], pin: "
          "[0.5, 0], "
          "initial: {angle: 1, velocity: 6}}\n  b: {mass: 1, inertia: 0.05, com: [0.5, 0], pin: [1, 0], "
          "initial: {angle: "
          "-1, velocity: -6}}\n  c: {mass: 1, inertia: 0.05, com: [0.25, 0], pin: [0.5, 0], initial: {angle: "
          "-2.1415926}}\n");
      scene.integrator.method = method;
      scene.integrator.tolerance = tolerance;
      Simulation simulation(scene);
      EXPECT_TRUE(simulation.advanceTo(2)) << method << " at " << tolerance << ": " << simulation.fault();
      EXPECT_NEAR(simulation.q()[0] + simulation.q()[1], 0, 1e-4) << method << " at " << tolerance;
      const EnergyBalance balance = simulation.energyBalance();
      EXPECT_NEAR(balance.residual / balance.now.kinetic, 0, 10 * tolerance) << method << " at " << tolerance;
    }
  }
}

// ---- Known answers ---------------------------------------------------------------------------------

TEST(SliderCrank, HasItsPistonWhereTheClosedFormHasIt) {
  const double r = 0.4, l = 1.0, height = 0.05;
  Scene scene = readSceneText(
      "chain: [crank, rod]\ntip: {line: {point: [0, 0.05], direction: [1, 0]}}\nlinks:\n  crank: {mass: 0.5, "
      "inertia: 0.01, com: [0.2, 0], pin: [0.4, 0], joint: {drive: {amplitude: 2, frequency: 0.5}}}\n  rod: "
      "{mass: 0.8, inertia: 0.05, com: [0.5, 0], pin: [1, 0]}\n");
  Simulation simulation(scene);
  for (int k = 1; k <= 20; ++k) {
    ASSERT_TRUE(simulation.advanceTo(0.17 * k)) << simulation.fault();
    const double crankAngle = simulation.q()[0], rodAngle = crankAngle + simulation.q()[1];
    const double sine = height - r * std::sin(crankAngle);
    EXPECT_NEAR(r * std::cos(crankAngle) + l * std::cos(rodAngle),
                r * std::cos(crankAngle) + std::sqrt(l * l - sine * sine), 1e-12);
    EXPECT_EQ(simulation.tipForce().x, 0);
  }
}

TEST(HangingChain, IsTheCatenaryOfItsLinks) {
  const Scene scene = readSceneText(
      "chain: [rope]\nstart: rest\ntip: {pin: [8.0, 0.0]}\nlinks:\n  rope: {mass: 0.1, inertia: 0.0001, com: "
      "[0.05, 0], pin: [0.1, 0], repeat: 100}\n");
  Simulation simulation(scene);
  const Vec2d pull = simulation.tipForce();
  // Half of the weight, and a pull H: link j has tan θ_j = V_j/H, V_j the vertical pull in its middle.
  EXPECT_NEAR(pull.y, 100 * 0.1 * 9.81 / 2, 1e-9);
  const double H = pull.x;
  double theta = 0, span = 0;
  for (int j = 0; j < 100; ++j) {
    theta += simulation.q()[index(j)];
    EXPECT_NEAR(std::tan(theta), (j - 49.5) * 0.1 * 9.81 / H, 1e-9) << j;
    span += 0.1 * std::cos(std::atan((j - 49.5) * 0.981 / H));
  }
  EXPECT_NEAR(span, 8, 1e-10);
  ASSERT_TRUE(simulation.advanceTo(1));
  for (const double rate : simulation.qd()) EXPECT_NEAR(rate, 0, 1e-6);
}

// ---- Slides and a held tip at rest ------------------------------------------------------------------

/// At rest at these places (rad, m), under this force on the tip.
void expectRest(const std::string& text, const std::vector<double>& q, Vec2d tipForce) {
  const Scene scene = readSceneText(text + "start: rest\n");
  for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(scene.q[i], q[i], 1e-9) << text << i;
  Simulation simulation(scene);
  EXPECT_LT(length(simulation.tipForce() - tipForce), 1e-6) << text;
  std::vector<double> qdd(q.size());
  simulation.accelerations(qdd.data());
  for (const double each : qdd) EXPECT_NEAR(each, 0, 1e-9);
  simulation.setState(scene.q, std::vector<double>(q.size()));
  simulation.settle();
  for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(simulation.q()[i], q[i], 1e-9) << text << i;
}

TEST(RestOfHeldCarts, OnALevelRailHasOneRodUpright) {
  // Without a force along the rail none acts across the rods: the shorter one hangs, the other one meets it.
  expectRest(
      "chain: [cart, a, b]\ntip: {pin: [0.3, 0]}\nlinks:\n  cart: {mass: 1, joint: {type: prismatic}, "
      "initial: {position: "
      "-0.4}}\n  a: {mass: 0.5, inertia: 0.0416, com: [0.5, 0], pin: [1, 0], initial: {angle: -0.7}}\n  b: "
      "{mass: "
      "0.3, inertia: 0.009, com: [0.3, 0], pin: [0.6, 0], initial: {angle: 1.9}}\n",
      {0.3 - 0.8, -std::asin(0.6), pi / 2 + std::asin(0.6)}, {0, 0.5 * 9.81 / 2 + 0.3 * 9.81});
}

/// By scipy: the least energy under the condition, and Newton's method on its derivatives.
TEST(RestOfHeldCarts, IsTheLeastEnergy) {
  const std::string bodies =
      "  a: {mass: 0.5, inertia: 0.01, com: [0.4, 0.05], pin: [0.8, 0], initial: {angle: -1.0}}\n  b: {mass: "
      "0.3, "
      "inertia: 0.004, com: [0.2, -0.03], ";
  const std::string tilted =
      "links:\n  cart: {mass: 2, pin: [0.1, 0.05], joint: {type: prismatic, axis: [3, -1], stiffness: 30, "
      "rest_angle: "
      "0.2}, initial: {position: 0.1}}\n" +
      bodies + "pin: [0.7, 0.1], joint: {stiffness: 2, rest_angle: 0.3}, initial: {angle: 1.2}}\n";
  const std::vector<double> rest{0.328524801795, -1.29964354181, 1.99376496434};
  const Vec2d force{-3.7267998, 4.09466732};
  expectRest("chain: [cart, a, b]\ntip: {pin: [1.1, -0.3]}\n" + tilted, rest, force);
  // The chain turned as a whole, with gravity.
  const auto turn = Rotation<double>::of(0.4);
  const auto inYaml = [&](Vec2d a) {
    std::ostringstream text;
    text << std::setprecision(17) << "[" << (turn * a).x << ", " << (turn * a).y << "]";
    return text.str();
  };
  expectRest("chain: [cart, a, b]\nbase: {angle: {offset: 0.4}}\ngravity: " + inYaml({0, -9.81}) +
                 "\ntip: {pin: " + inYaml({1.1, -0.3}) + "}\n" + tilted,
             rest, turn * force);
  expectRest(
      "chain: [x, y, a, b]\ntip: {line: {point: [0.9, -0.9], direction: [0.8, 0.6]}}\nlinks:\n  x: {mass: 2, "
      "pin: [0, 0.1], "
      "joint: {type: prismatic, stiffness: 15}, initial: {position: 0.1}}\n  y: {mass: 0.4, pin: [0.05, 0], "
      "joint: "
      "{type: prismatic, axis: [0.3, 1], stiffness: 40, rest_angle: 0.1}, initial: {position: -0.2}}\n" +
          bodies + "pin: [0.5, 0.1], initial: {angle: 0.7}}\n",
      {0.0419256614516, -0.197449307209, -1.51913848623, 0.23779074755}, -1.04814154 * Vec2d{-0.6, 0.8});
  expectRest(
      "chain: [cart, a, b]\ntip: {pin: [1.0, -0.5]}\nlinks:\n  cart: {mass: 2, pin: [0, 0.1], joint: {type: "
      "prismatic, axis: [0, "
      "1], lower: -0.4, stop_stiffness: 1000}, initial: {position: -0.3}}\n" +
          bodies + "pin: [0.7, 0.1], initial: {angle: 1.2}}\n",
      {-0.424555926264, -0.939618461781, 1.52558705248}, {2.12174919, 2.91207374});
}

TEST(FourBar, SwingsThereAndBack) {
  Scene scene = readSceneText(fourBar("0", "stiffness: 2"));
  scene.integrator.tolerance = 1e-12;
  Simulation simulation(scene);
  const std::vector<double> start = simulation.q();
  ASSERT_TRUE(simulation.advanceTo(1.5));
  std::vector<double> back = simulation.qd();
  for (double& rate : back) rate = -rate;
  simulation.setState(simulation.q(), back);
  ASSERT_TRUE(simulation.advanceTo(3));
  for (std::size_t i = 0; i < start.size(); ++i) EXPECT_NEAR(simulation.q()[i], start[i], 1e-9);
}

TEST(ClosedChain, KeepsItsEnergy) {
  for (const char* method : {"dop853", "radau13"}) {
    Scene scene = readSceneText(fourBar("0", "stiffness: 2"));
    scene.integrator.method = method;
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(30)) << simulation.fault();
    const EnergyBalance balance = simulation.energyBalance();
    EXPECT_LT(std::abs(balance.residual), 1e-6) << method;
  }
}

TEST_P(HeldTips, StayClosedAtACoarseTolerance) {
  for (const std::string& text : {fourBar(), slung, sliderCrank, heldCart, turnedHeldCart}) {
    Scene scene = readSceneText(text);
    scene.integrator.method = GetParam();
    scene.integrator.tolerance = 1e-5;
    Simulation simulation(scene);
    for (int k = 1; k <= 20; ++k) {
      ASSERT_TRUE(simulation.advanceTo(0.1 * k)) << simulation.fault();
      EXPECT_LT(simulation.closureError(), 1e-14 * (1 + scene.chain.reach())) << text;
    }
  }
}

// Of an angle of a thousand turns, rounding alone leaves a gap of 1e-12 of the reach.
TEST(ClosedChain, TurnsAThousandTimesAsItTurnsOnce) {
  const auto drivenAt = [](double offset) {
    Scene scene = readSceneText(
        "chain: [crank, coupler, rocker]\ntip: {pin: [1.2, 0]}\nlinks:\n"
        "  crank: {mass: 2, inertia: 0.05, com: [0, 0], pin: [0.3, 0], joint: {drive: {amplitude: 0.5, "
        "frequency: 1, offset: " +
        toText(offset) +
        "}}}\n  coupler: {mass: 0.5, inertia: 0.0417, com: [0.5, 0], pin: [1, 0], initial: {angle: -0.5}}\n"
        "  rocker: {mass: 0.4, inertia: 0.0213, com: [0.4, 0], pin: [0.8, 0], initial: {angle: -1.6}}\n");
    Simulation simulation(scene);
    EXPECT_TRUE(simulation.advanceTo(2)) << simulation.fault();
    EXPECT_LT(simulation.closureError(), 1e-11);
    return simulation.q();
  };
  const std::vector<double> once = drivenAt(2 * pi), often = drivenAt(2000 * pi);
  EXPECT_NEAR(std::remainder(often[0] - once[0], 2 * pi), 0, 1e-9);
  EXPECT_NEAR(std::remainder(often[1] - once[1], 2 * pi), 0, 1e-6);
  EXPECT_NEAR(std::remainder(often[2] - once[2], 2 * pi), 0, 1e-6);
}

TEST(HeldTip, IsReachedFromAnyAngles) {
  const Scene scene = readSceneText(
      "chain: [rope]\ntip: {pin: [1.0, 0.5]}\nlinks:\n  rope: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: "
      "[1, "
      "0], repeat: 4}\n");
  for (const char* links : {"5", "30", "300"}) {
    for (const double share : {0.01, 0.3, 0.9}) {
      EXPECT_NO_THROW(
          readSceneText("chain: [rope]\ntip: {pin: [" + toText(share * std::stod(links)) +
                        ", 0]}\nlinks:\n  rope: {mass: 1, inertia: 0.01, com: [0.5, 0.1], pin: [1, "
                        "0], repeat: " +
                        links + "}\n"))
          << links << " links, at " << share;
    }
  }
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_EQ(scene.notes.front().path, "tip/pin");
  Simulation simulation(scene);
  EXPECT_LT(simulation.closureError(), 1e-14);
  EXPECT_THROW(
      readSceneText("chain: [a, b]\ntip: {pin: [2.5, 0]}\nlinks:\n  a: {mass: 1, inertia: 0.1, com: [0.5, "
                    "0], pin: [1, 0]}\n  b: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]}\n"),
      Refused);
}

/// Friction leaves two joints, and all others stick by turns: what a change leaves of the rates must not
/// grow.
TEST(HeldTip, KeepsItsEnergyWhereAllButTwoJointsStick) {
  const std::string link = ", com: [0.083333, 0], pin: [0.16667, 0], ";
  const std::string text =
      "chain: [l0, l1, l2, l3, l4, l5]\ntip: {pin: [0.21205, -0.59459]}\nlinks:\n"
      "  l0: {mass: 0.25704, inertia: 0.00054536, com: [0.083333, -0.00014187], pin: [0.16667, "
      "-0.00072978],\n"
      "       joint: {lower: 0.044379, upper: 0.045488, stop_stiffness: 76309, stop_damping: 23.859,\n"
      "               damping: 0.0044713, stiffness: 0.22911, rest_angle: -0.10016},\n"
      "       initial: {angle: 0.044636, velocity: 0.2243}}\n"
      "  l1: {mass: 0.79758, inertia: 0.0016253" +
      link +
      "joint: {friction: 0.29103}, initial: {angle: -0.70837, velocity: 3.6432}}\n"
      "  l2: {mass: 0.37508, inertia: 0.00015206" +
      link +
      "joint: {lower: -0.028132, upper: -0.001158, stop_stiffness: 30436000, friction: 0.0018259},\n"
      "       initial: {angle: -0.001661, velocity: -2.8342}}\n"
      "  l3: {mass: 0.55094, inertia: 0.00013748" +
      link +
      "joint: {friction: 2.3553, drag: 0.0023084}, initial: {angle: -0.80231, velocity: -2.9859}}\n"
      "  l4: {mass: 0.95123, inertia: 0.0009948" +
      link +
      "joint: {lower: -1.3552, upper: -1.0592, stop_stiffness: 43335, stop_damping: 4.6524, damping: "
      "0.48769,\n"
      "        friction: 0.0002436}, initial: {angle: -1.0749, velocity: 3.883}}\n"
      "  l5: {mass: 2.1147, inertia: 0.0027445" +
      link +
      "joint: {lower: 0.35026, upper: 0.35579, stop_stiffness: 225260, damping: 0.89672,\n"
      "        rotor_inertia: 0.13309}, initial: {angle: 0.35516, velocity: 1.416}}\n";
  Scene scene = readSceneText(text);
  const auto after = [&](const char* method, double tolerance) {
    scene.integrator = {method, tolerance, 0};
    Simulation simulation(scene);
    EXPECT_TRUE(simulation.advanceTo(0.3)) << method << ": " << simulation.fault();
    return simulation.q();
  };
  const std::vector<double> exact = after("dop853", 1e-9);
  for (const char* method : {"rodas5p", "dop853", "auto"}) {
    const std::vector<double> q = after(method, 1e-4);
    for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(q[i], exact[i], 1e-3) << method << " " << i;
  }
}

/// From a pose so far off that the chain is laid along an arc: the driven joint stays.
TEST(HeldTip, IsReachedBesideAHeldJoint) {
  Simulation simulation(readSceneText(
      "chain: [a, b, c, d, e]\ntip: {line: {point: [1.38, -1.4], direction: [-0.25, 0.95]}}\nlinks:\n"
      "  a: {mass: 0.05, inertia: 0.19, com: [0.17, 0], pin: [0.34, 0], initial: {angle: -0.5}}\n"
      "  b: {mass: 0.57, inertia: 0, com: [0.37, 0], pin: [0.85, 0], joint: {drive: hold}}\n"
      "  c: {mass: 0.47, inertia: 0.03, com: [0.21, 0], pin: [0.55, 0], initial: {angle: 0.1}}\n"
      "  d: {mass: 0.09, inertia: 0, com: [0.67, 0], pin: [1.11, 0], initial: {angle: 0.2}}\n"
      "  e: {mass: 1.45, inertia: 0, com: [0.13, 0.04], pin: [0.36, 0], initial: {angle: 0.6}}\n"));
  EXPECT_EQ(simulation.q()[1], 0);
  EXPECT_LT(simulation.closureError(), 1e-14);
  EXPECT_TRUE(simulation.advanceTo(0.1)) << simulation.fault();
}

}  // namespace
}  // namespace planar_chain
