/// Derivatives of motions, against the pendulum's elliptic functions, exponentials of matrices, laws of
/// mechanics, and differences of motions that are far more exact.

#include "planar_chain/derivatives.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>
#include <utility>
#include <vector>

#include "planar_chain/kane.h"
#include "planar_chain/linear_model.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"

namespace planar_chain {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double tolerance = 1e-8;          // of the scenes, the default
constexpr double allowed = 10 * tolerance;  // relative to the largest entry of a column, or to 1

VectorXd stateOf(const Simulation& simulation) {
  const auto n = static_cast<Eigen::Index>(simulation.q().size());
  VectorXd state(2 * n);
  state << Eigen::Map<const VectorXd>(simulation.q().data(), n),
      Eigen::Map<const VectorXd>(simulation.qd().data(), n);
  return state;
}

void expectNear(const MatrixXd& found, const MatrixXd& expected, const std::string& what) {
  ASSERT_EQ(found.cols(), expected.cols());
  for (Eigen::Index k = 0; k < found.cols(); ++k) {
    const double size = std::max(1.0, expected.col(k).cwiseAbs().maxCoeff());
    EXPECT_LT((found.col(k) - expected.col(k)).cwiseAbs().maxCoeff() / size, allowed)
        << what << ", column " << k << ":\n"
        << found.col(k).transpose() << "\n"
        << expected.col(k).transpose();
  }
}

std::vector<VariedNumber> variedIn(const Value& tree, const std::vector<std::string>& paths) {
  std::vector<VariedNumber> numbers;
  for (const std::string& path : paths) numbers.push_back(variedNumber(tree, path));
  return numbers;
}

// ---- Exact answers -----------------------------------------------------------------------------------

/// A point mass on an arm of 1 m, released at rest 2 rad from hanging. With k = sin(θ_0/2), θ(t) = 2 asin(k
/// cd(√g t | k²)). Its derivatives at 3 s by mpmath, 40 digits:
///
///     theta = lambda t, a, g: 2*asin(sin(a/2)*ellipfun('cd', sqrt(g)*t, m=sin(a/2)**2))
///     diff(lambda a: theta(3, a, mpf('9.81')), 2), …
TEST(Derivatives, OfThePendulumAreThoseOfEllipticFunctions) {
  const Value tree = parseYaml(R"(
chain: [arm]
gravity: [0, -9.81]
links: {arm: {mass: 1.5, inertia: 0, com: [1, 0], pin: [1, 0], initial: {angle: 0.4292036732051034}}}
)");
  Simulation simulation(readScene(tree));
  simulation.followDerivatives(variedIn(tree, {"links/arm/initial/angle", "gravity/1", "links/arm/mass"}));
  ASSERT_TRUE(simulation.advanceTo(3));
  MatrixXd expected(2, 3);
  expected << 3.9478390975396572583, 0.4786930948763560947, 0,  // g = −gravity/1
      9.47827557725386736, 1.65433937089109252, 0;
  const Derivatives derivatives = simulation.derivatives();
  expectNear(derivatives.numbers, expected, "numbers");
  expectNear(derivatives.state.col(0), expected.col(0), "angle");
}

/// By a complex step of 1e-30 through dop853 of scipy 1.10 at a relative tolerance of 3e-14, of numpy's
/// complex numbers. With θ = q_1, φ = q_1 + q_2, J_1 = I + m_1/4 + m_2 L², J_2 = I + m_2/4, k = m_2 L/2:
///
///     J_1 θ̈ + k cos(φ−θ) φ̈ = τ_1 − τ_2 + k sin(φ−θ) φ̇² − (m_1/2 + m_2 L) g cos θ
///     k cos(φ−θ) θ̈ + J_2 φ̈ = τ_2 − k sin(φ−θ) θ̇² − m_2/2 g cos φ
TEST(Derivatives, OfTheDoublePendulumAreThoseOfAComplexStep) {
  const Value tree = parseYaml(R"(
chain: [upper, lower]
links:
  upper: {mass: 1, inertia: 0.08333333333333333, com: [0.5, 0], pin: [1, 0], initial: {angle: 1.2}}
  lower: {mass: 1, inertia: 0.08333333333333333, com: [0.5, 0], pin: [1, 0], initial: {angle: 0.9}}
)");
  MatrixXd expected(9, 4);
  expected << 7.33910607978, -3.21928017197, 0.111908836232, 2.18274974268,  // angles
      1.46946635411, -0.772727734213, -0.75782886702, -7.21650276797,        //
      3.02980664853, -1.28063153411, -0.0906023016015, -0.589048093101,      // rates
      0.67980320066, -0.282208541235, -0.632372834241, -3.67237992737,       //
      0.553304230378, -0.22596949823, 0.759039796734, 1.80840820664,         // torques
      -0.372577059637, 0.45202775771, -2.33550029794, -5.87535811689,        //
      -0.679096668205, 0.285185001274, -0.430317427283, -1.1120113964,       // m_1
      0.533844208622, -0.267447456471, -1.60129444409, -8.46997949982,       // m_2
      3.46833456484, -1.62910321806, 4.39859427571, 2.5728894691;            // L
  Simulation simulation(readScene(tree));
  simulation.followDerivatives(variedIn(tree, {"links/upper/mass", "links/lower/mass", "links/upper/pin/0"}));
  ASSERT_TRUE(simulation.advanceTo(1));
  const Derivatives derivatives = simulation.derivatives();
  expectNear(derivatives.state, expected.topRows(4).transpose(), "state");
  expectNear(derivatives.torques, expected.middleRows(4, 2).transpose(), "torques");
  expectNear(derivatives.numbers, expected.bottomRows(3).transpose(), "numbers");
}

/// Masses on a rail with springs and dampers are a linear system, and so is a motor that lags.
TEST(Derivatives, OfALinearChainAreExponentials) {
  const Value tree = parseYaml(R"(
chain: [a, b]
gravity: [0, 0]
links:
  a: {mass: 1, joint: {type: prismatic, axis: [1, 0], stiffness: 30, damping: 0.8, motor: {time_constant: 0.2}}}
  b: {mass: 0.5, joint: {type: prismatic, axis: [1, 0], stiffness: 10, damping: 0.3, command_delay: 0.3}, initial: {position: 0.4}}
)");
  const Scene scene = readScene(tree);
  const double end = 1.3, lag = 0.2, delay = 0.3;
  const LinearModel model = linearModel(scene, 0, VectorXd::Zero(2), VectorXd::Zero(2));
  MatrixXd all = MatrixXd::Zero(8, 8);  // x; what reaches joint a; what is held in a, in b
  all.topLeftCorner(4, 4) = model.A;
  all.block(0, 4, 4, 1) = model.B.col(0);
  all(4, 4) = -1 / lag;
  all(4, 5) = 1 / lag;
  MatrixXd late = MatrixXd::Zero(5, 5);
  late.topLeftCorner(4, 4) = model.A;
  late.topRightCorner(4, 1) = model.B.col(1);
  MatrixXd torques(4, 2);
  torques << MatrixXd((all * end).exp()).block(0, 5, 4, 1),
      MatrixXd((late * (end - delay)).exp()).topRightCorner(4, 1);

  Simulation simulation(scene, 1);
  Simulation alone(scene, 1);
  ASSERT_TRUE(alone.advanceTo(0.1) && simulation.advanceTo(0.1) && alone.advanceTo(0.1 + end));
  const Derivatives derivatives = simulation.transition(0.1 + end);
  expectNear(derivatives.state, (model.A * end).exp(), "state");
  expectNear(derivatives.torques, torques, "torques");
  EXPECT_EQ(stateOf(simulation), stateOf(alone)) << "derivatives change no bit of the motion";
}

/// With p = M q̇ the flow of a chain without losses is symplectic.
TEST(Derivatives, OfAConservativeChainAreSymplectic) {
  const Value tree = parseYaml(R"(
chain: [a, b, c]
links:
  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], joint: {stiffness: 3}, initial: {angle: 0.3}}
  b: {mass: 2, inertia: 0.2, com: [0.4, 0], pin: [0.8, 0.1], initial: {angle: -1, velocity: 2}}
  c: {mass: 0.5, inertia: 0.1, com: [0.3, -0.1], pin: [0.6, 0], initial: {angle: 2}}
)");
  const Scene scene = readScene(tree);
  Simulation simulation(scene);
  // ∂(q, M q̇)/∂(q, q̇), M_q by differences of sixth order
  const auto momenta = [&](const VectorXd& x) {
    const auto massMatrix = [&](const VectorXd& q) {
      return MatrixXd(
          kane(scene.chain, q, VectorXd::Zero(3), activeForces(scene, 0, q, VectorXd::Zero(3))).M_q);
    };
    MatrixXd T = MatrixXd::Identity(6, 6);
    T.bottomRightCorner(3, 3) = massMatrix(x.head(3));
    for (int i = 0; i < 3; ++i) {
      const double h = 0.01;
      VectorXd sum = VectorXd::Zero(3);
      for (const auto& [k, weight] : {std::pair(1, 45.), {2, -9.}, {3, 1.}}) {
        const VectorXd step = k * h * VectorXd::Unit(3, i);
        sum += weight / (60 * h) * (massMatrix(x.head(3) + step) - massMatrix(x.head(3) - step)) * x.tail(3);
      }
      T.block(3, i, 3, 1) = sum;
    }
    return T;
  };
  const MatrixXd before = momenta(stateOf(simulation));
  const MatrixXd state = simulation.transition(2).state;
  const MatrixXd canonical = momenta(stateOf(simulation)) * state * before.inverse();
  MatrixXd J = MatrixXd::Zero(6, 6);
  J.topRightCorner(3, 3).setIdentity();
  J.bottomLeftCorner(3, 3) = -MatrixXd::Identity(3, 3);
  const double size = canonical.cwiseAbs().maxCoeff();
  EXPECT_LT((canonical.transpose() * J * canonical - J).cwiseAbs().maxCoeff(), allowed * size * size);
}

/// A joint that sticks stops at once, by an impulse that changes the momentum of its own coordinate alone.
TEST(Derivatives, OfAJointThatSticksAreThoseOfItsImpulse) {
  const Scene scene = readSceneText(R"(
chain: [a, b]
gravity: [0, 0]
links:
  a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {friction: 9}}
  b: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {stiffness: 2}, initial: {angle: 0.3, velocity: 1}}
)");
  Simulation simulation(scene);
  const VectorXd q = stateOf(simulation).head(2), still = VectorXd::Zero(2);
  const MatrixXd M = kane(scene.chain, q, still, activeForces(scene, 0, q, still)).M_q;
  const MatrixXd state = simulation.transition(0.4).state;
  expectNear(state.col(2), M(0, 1) / M(1, 1) * state.col(3), "rate");
}

// ---- Differences -------------------------------------------------------------------------------------

struct Case {
  const char* name;
  const char* scene;
  double end;
  std::vector<std::pair<std::string, double>> numbers;  ///< and their values
  double h = 1e-3;                                      ///< shorter where events come and go nearby
  int given = -1;                                       ///< the joint that is driven
  int stuck = -1;  ///< a joint at rest whose rate decides whether it starts: nothing to differentiate
};

/// By differences of sixth order between motions at a tolerance of 1e-13. h: of the bends of the motion,
/// which are sharp where stops are hit, h⁶ is left; of rounding 1e-13/h.
class AgainstDifferences : public testing::TestWithParam<Case> {
 protected:
  const double h = GetParam().h;

  template <class F>
  VectorXd difference(const F& stateAt) const {
    VectorXd sum;
    for (const auto& [k, weight] : {std::pair(1, 45.), {2, -9.}, {3, 1.}}) {
      const VectorXd part = weight / (60 * h) * (stateAt(k * h) - stateAt(-k * h));
      sum = sum.size() == 0 ? part : VectorXd(sum + part);
    }
    return sum;
  }
  static Scene exact(const Value& tree) {
    Scene scene = readScene(tree);
    scene.integrator.tolerance = 1e-13;
    return scene;
  }
};

TEST_P(AgainstDifferences, Agree) {
  const Case& of = GetParam();
  const Value tree = parseYaml(of.scene);
  const Scene scene = readScene(tree);
  const int n = scene.chain.size();
  MatrixXd state = MatrixXd::Zero(2 * n, 2 * n), torques(2 * n, n), numbers(2 * n, 0);
  for (int k = 0; k < 2 * n; ++k) {
    if (k % n == of.given || (of.stuck >= 0 && k == n + of.stuck)) continue;
    state.col(k) = difference([&](double by) {
      Simulation simulation(exact(tree));
      std::vector<double> q = simulation.q(), qd = simulation.qd();
      (k < n ? q[index(k)] : qd[index(k - n)]) += by;
      simulation.setState(q, qd);
      EXPECT_TRUE(simulation.advanceTo(of.end)) << simulation.fault();
      return stateOf(simulation);
    });
  }
  torques.setZero();
  for (int i = 0; i < n; ++i) {
    if (i == of.given) continue;
    torques.col(i) = difference([&](double by) {
      Simulation simulation(exact(tree), 1);
      simulation.holdTorque(i, by, std::numeric_limits<double>::infinity());
      EXPECT_TRUE(simulation.advanceTo(of.end));
      return stateOf(simulation);
    });
  }
  std::vector<std::string> paths;
  for (const auto& [path, value] : of.numbers) {
    paths.push_back(path);
    numbers.conservativeResize(2 * n, numbers.cols() + 1);
    numbers.rightCols(1) = difference([&, path = path, value = value](double by) {
      Value near = tree;
      setNumber(near, path, value + by);
      Simulation simulation(exact(near));
      EXPECT_TRUE(simulation.advanceTo(of.end)) << simulation.fault();
      return stateOf(simulation);
    });
  }

  Simulation simulation(scene);
  simulation.followDerivatives(variedIn(tree, paths));
  ASSERT_TRUE(simulation.advanceTo(of.end));
  Derivatives derivatives = simulation.derivatives();
  if (of.stuck >= 0) derivatives.state.col(n + of.stuck).setZero();
  expectNear(derivatives.state, state, "state");
  expectNear(derivatives.torques, torques, "torques");
  expectNear(derivatives.numbers, numbers, "numbers");
}

const Case cases[] = {
    {"Pendulum",
     R"(
chain: [upper, lower]
gravity: [0.1, -9.81]
links:
  upper: {mass: 1, inertia: 0.08, com: [0.5, 0], pin: [1, 0], joint: {damping: 0.1}, initial: {angle: 1.2}}
  lower: {mass: 1, inertia: 0.08, com: [0.5, 0.1], pin: [1, 0], joint: {stiffness: 2}, initial: {angle: 0.9}}
loads: {push: {link: lower, force: [1, 2], point: [0.3, 0.2], frequency: 0.7}}
)",
     1.0,
     {{"links/lower/mass", 1},
      {"links/upper/pin/0", 1},
      {"links/upper/joint/damping", 0.1},
      {"gravity/0", 0.1},
      {"loads/push/frequency", 0.7}}},
    {"Stiff",
     R"(
chain: [a, b]
integrator: {method: rodas5p}
links:
  a: {mass: 1, inertia: 0.08, com: [0.5, 0], pin: [1, 0], joint: {damping: 40, stiffness: 1.0e+6}, initial: {angle: 0.2}}
  b: {mass: 1, inertia: 0.08, com: [0.5, 0], pin: [1, 0], joint: {damping: 300, stiffness: 2.0e+3}, initial: {angle: 0.9}}
)",
     0.1,
     {{"links/b/joint/damping", 300}}},
    {"Stop",
     R"(
chain: [thigh, shin]
links:
  thigh: {mass: 7, inertia: 0.11, com: [0.2, 0], pin: [0.42, 0], joint: {damping: 0.5}}
  shin: {mass: 4, inertia: 0.06, com: [0.2, 0], pin: [0.43, 0], initial: {angle: -0.3, velocity: 1},
         joint: {damping: 0.2, upper: 0, lower: -2.4, stop_stiffness: 2000, stop_damping: 5}}
)",
     0.5,
     {{"links/shin/joint/upper", 0}, {"links/shin/joint/stop_damping", 5}, {"links/shin/mass", 4}},
     1e-5},
    {"Friction",
     R"(
chain: [a, b]
gravity: [0, 0]
links:
  a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {friction: 0.8, stiffness: 5}, initial: {velocity: 2}}
  b: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {stiffness: 8}, initial: {angle: 0.9}}
)",
     1.2,
     {{"links/a/joint/friction", 0.8}, {"links/b/mass", 1}}},
    {"Breakaway",
     R"(
chain: [a, b]
gravity: [0, 0]
links:
  a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {friction: 0.5, breakaway: 0.7}}
  b: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {stiffness: 2}, initial: {angle: 0.1, velocity: 1}}
)",
     0.9,
     {{"links/a/joint/breakaway", 0.7}, {"links/b/joint/stiffness", 2}},
     3e-5,
     -1,
     0},
    {"Closed",
     R"(
chain: [crank, coupler, rocker]
tip: {pin: [1.2, 0.0]}
links:
  crank: {mass: 2, inertia: 0.05, com: [0, 0], pin: [0.3, 0], initial: {angle: 1, velocity: 9}}
  coupler: {mass: 0.5, inertia: 0.0417, com: [0.5, 0], pin: [1, 0], initial: {angle: -0.5}}
  rocker: {mass: 0.4, inertia: 0.0213, com: [0.4, 0], pin: [0.8, 0], joint: {damping: 0.01}, initial: {angle: -1.6}}
)",
     0.4,
     {{"links/coupler/mass", 0.5}, {"links/coupler/pin/0", 1}}},
    {"Driven",
     R"(
chain: [cart, pole]
base: {y: {amplitude: 0.1, frequency: 1}}
links:
  cart: {mass: 1, joint: {type: prismatic, axis: [1, 0], drive: {amplitude: 0.2, frequency: 0.5, phase: 0}}}
  pole: {mass: 0.4, inertia: 0.01, com: [0.25, 0], pin: [0.5, 0], joint: {rotor_inertia: 0.01}, initial: {angle: 1.4}}
)",
     0.8,
     {{"links/pole/mass", 0.4}, {"links/pole/joint/rotor_inertia", 0.01}},
     1e-3,
     0},
};

INSTANTIATE_TEST_SUITE_P(Scenes, AgainstDifferences, testing::ValuesIn(cases),
                         [](const auto& its) { return std::string(its.param.name); });

TEST(Derivatives, AreRefusedWhereThereAreNone) {
  const Value tree = parseYaml(R"(
chain: [a]
links: {a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]}}
loads: {push: {joint: a_joint, torque: 1, start: 0.2, stop: 0.4}}
)");
  Simulation simulation(readScene(tree));
  EXPECT_THROW(simulation.derivatives(), std::logic_error);
  simulation.followDerivatives(variedIn(tree, {"loads/push/start"}));
  ASSERT_TRUE(simulation.advanceTo(1));
  EXPECT_THROW(simulation.derivatives(), std::domain_error);
  EXPECT_THROW(variedNumber(tree, "links/a/joint/damping"), Refused);
}

}  // namespace
}  // namespace planar_chain
