/// Transitions over intervals in a row, through motors that lag: their product is the derivative of the whole
/// motion, against an exponential of a matrix and differences of motions that are far more exact. What a note
/// says.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>
#include <utility>
#include <vector>

#include "planar_chain/derivatives.h"
#include "planar_chain/linear_model.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"

namespace planar_chain {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double forever = std::numeric_limits<double>::infinity();

/// Masses on a rail with springs and lags are a linear system: (A, B) of linearize() with motors.
TEST(Transition, OfALinearChainWithMotorsIsAnExponential) {
  const Scene scene = readSceneText(R"(
chain: [a, b, c]
gravity: [0, 0]
links:
  a: {mass: 1, joint: {type: prismatic, axis: [1, 0], stiffness: 30, damping: 0.8, motor: {time_constant: 0.2}}}
  b: {mass: 0.5, joint: {type: prismatic, axis: [1, 0], stiffness: 10, damping: 0.3}, initial: {position: 0.4}}
  c: {mass: 0.5, joint: {type: prismatic, axis: [1, 0], stiffness: 20, motor: {time_constant: 0.002}}}
)");
  const double end = 0.7;
  LinearModel model;
  {
    Simulation simulation(scene, 1);
    model = simulation.linearize(true);
  }
  ASSERT_EQ(model.A.rows(), 8);
  MatrixXd all = MatrixXd::Zero(11, 11);
  all.topLeftCorner(8, 8) = model.A;
  all.topRightCorner(8, 3) = model.B;
  const MatrixXd expected = (all * end).exp();

  Simulation simulation(scene, 1), alone(scene, 1);
  for (Simulation* one : {&simulation, &alone}) one->holdTorque(0, 2, forever);
  ASSERT_TRUE(simulation.advanceTo(0.1) && alone.advanceTo(0.1) && alone.advanceTo(0.1 + end));
  const Derivatives found = simulation.transition(0.1 + end, true);
  EXPECT_EQ(simulation.q(), alone.q()) << "derivatives change no bit of the motion";
  EXPECT_TRUE(found.notes.empty());
  EXPECT_LT((found.state - expected.topLeftCorner(8, 8)).cwiseAbs().maxCoeff(), 1e-7) << found.state;
  EXPECT_LT((found.torques - expected.topRightCorner(8, 3)).cwiseAbs().maxCoeff(), 1e-7) << found.torques;
}

// ---- Products ------------------------------------------------------------------------------------------

/// A motion of three intervals of 0.2 s, with torques of its own in each.
struct Case {
  const char* name;
  const char* scene;
  std::vector<std::vector<double>> torques;
  double h;  ///< of the differences
  int stuck =
      -1;  ///< the column of a rate that moves the joint by a multiple of h |h|: no difference is exact
};

/// A change of the start: of q, q̇ and the torques that lag, then of the torques of each interval.
VectorXd endOf(Scene scene, const Case& of, const VectorXd& change) {
  scene.integrator.tolerance = 1e-13;
  Simulation simulation(scene, 1);
  const auto n = scene.q.size();
  Eigen::Index next = 0;
  std::vector<double> q = scene.q, qd = scene.qd, motors(n, 0.0);
  for (double& angle : q) angle += change[next++];
  for (double& rate : qd) rate += change[next++];
  simulation.setState(q, qd);
  for (std::size_t i = 0; i < n; ++i) {
    if (scene.chain.joints()[i].other("motor/time_constant") > 0) motors[i] = change[next++];
  }
  simulation.setMotorTorques(motors);
  for (int k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < n; ++i)
      simulation.holdTorque(static_cast<int>(i), of.torques[static_cast<std::size_t>(k)][i] + change[next++],
                            forever);
    EXPECT_TRUE(simulation.advanceTo(0.2 * (k + 1))) << simulation.fault();
  }
  VectorXd end(2 * n);
  end << Eigen::Map<const VectorXd>(simulation.q().data(), static_cast<Eigen::Index>(n)),
      Eigen::Map<const VectorXd>(simulation.qd().data(), static_cast<Eigen::Index>(n));
  return end;
}

class Products : public testing::TestWithParam<Case> {};

TEST_P(Products, AreTheDerivativesOfTheWholeMotion) {
  const Case& of = GetParam();
  const Scene scene = readSceneText(of.scene);
  const int n = scene.chain.size();
  Simulation simulation(scene, 1);
  MatrixXd product;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < n; ++i)
      simulation.holdTorque(i, of.torques[static_cast<std::size_t>(k)][static_cast<std::size_t>(i)], forever);
    const Derivatives step = simulation.transition(0.2 * (k + 1), true);
    if (k == 0) product = MatrixXd::Identity(step.state.rows(), step.state.rows());
    MatrixXd next(step.state.rows(), product.cols() + n);
    next << step.state * product, step.torques;
    product = next;
  }
  MatrixXd expected(2 * n, product.cols());
  for (Eigen::Index c = 0; c < product.cols(); ++c) {
    VectorXd sum = VectorXd::Zero(2 * n);
    for (const auto& [k, weight] : {std::pair(1, 45.), {2, -9.}, {3, 1.}}) {
      const VectorXd step = k * of.h * VectorXd::Unit(product.cols(), c);
      sum += weight / (60 * of.h) * (endOf(scene, of, step) - endOf(scene, of, -step));
    }
    expected.col(c) = sum;
  }
  EXPECT_GT(expected.middleCols(2 * n, 1).cwiseAbs().maxCoeff(), 1e-3) << "the lag counts";
  for (Eigen::Index c = 0; c < product.cols(); ++c) {
    if (c == of.stuck) continue;
    const double size = std::max(1.0, expected.col(c).cwiseAbs().maxCoeff());
    EXPECT_LT((product.col(c).head(2 * n) - expected.col(c)).cwiseAbs().maxCoeff() / size, 1e-7)
        << "column " << c << ":\n"
        << product.col(c).head(2 * n).transpose() << "\n"
        << expected.col(c).transpose();
  }
}

const Case cases[] = {
    {"Arm",
     R"(
chain: [a, b]
links:
  a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {motor: {time_constant: 0.3}}, initial: {angle: 0.3}}
  b: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {damping: 0.2}, initial: {angle: -1}}
)",
     {{9, 1}, {-3, 2}, {5, -2}},
     1e-3},
    {"TorqueSpeedLine",  // the line bounds the torque from 0.1 s on; in the last interval the limit cuts it
                         // off
     R"(
chain: [a]
gravity: [0, 0]
links:
  a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0],
      joint: {effort_limit: 4, motor: {time_constant: 0.1, no_load_speed: 1.5}}}
)",
     {{3.5}, {-2}, {6}},
     1e-4},
    {"Friction",  // it breaks loose at the torque that lags
     R"(
chain: [a, b]
gravity: [0, 0]
links:
  a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {friction: 0.5, breakaway: 0.8, motor: {time_constant: 0.1}}}
  b: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {stiffness: 2}, initial: {angle: 0.02}}
)",
     {{1.5, 0}, {2, 0}, {0, 0}},
     3e-5,
     2},
};

INSTANTIATE_TEST_SUITE_P(Scenes, Products, testing::ValuesIn(cases),
                         [](const auto& its) { return std::string(its.param.name); });

// ---- Notes ---------------------------------------------------------------------------------------------

std::vector<std::string> notesOf(const std::string& joint, bool motors, double torque = 0) {
  Simulation simulation(readSceneText("chain: [rod]\nlinks: {rod: {mass: 1, inertia: 0.1, com: [0.5, 0], "
                                      "pin: [1, 0], joint: {" +
                                      joint + "}}}\n"),
                        1);
  simulation.holdTorque(0, torque, forever);
  return simulation.transition(0.1, motors).notes;
}

TEST(Transition, NotesWhatProductsLeaveOut) {
  const std::string words = "products of (Phi, Gamma) over intervals leave out ";
  const std::string lag = "motor: {time_constant: 0.1}", delay = "command_delay: 0.05";
  const std::string ofDelay = words + "the commands on their way to rod_joint (command_delay 0.05 s)";
  using Notes = std::vector<std::string>;
  EXPECT_EQ(notesOf(lag + ", " + delay, false),
            (Notes{words + "the lagged torques of rod_joint: with motors=True they are states", ofDelay}));
  EXPECT_EQ(notesOf(lag + ", " + delay, true), (Notes{ofDelay}));
  EXPECT_EQ(notesOf("motor: {no_load_speed: 9}, effort_limit: 1", false), Notes());
}

/// The rod's weight asks for 4.905 N m. A small rate against the motion that begins turns friction around:
/// with (w − c)/J before, (w + c)/J while it lasts, the derivative on that side is (w − c)/(w + c), not 1.
TEST(Transition, NotesAJointWhoseRateCountsOnOneSide) {
  using Notes = std::vector<std::string>;
  EXPECT_EQ(notesOf("friction: 0.5", false),
            (Notes{"rod_joint starts to slip at t = 0 s: the derivatives by its rate there hold in the "
                   "direction of the slip alone"}));
  EXPECT_EQ(notesOf("friction: 4, breakaway: 6", false),
            (Notes{"rod_joint sticks at t = 0 s by its breakaway torque alone: any rate may start it, and "
                   "the derivatives by its rate take it as stuck"}));
  EXPECT_EQ(notesOf("friction: 6", false), Notes());
  EXPECT_EQ(notesOf("friction: 4, breakaway: 6", false, 3), Notes());
}

}  // namespace
}  // namespace planar_chain
