/// The exact O(n) solve against J itself: J x by automatic differentiation of the equations of motion, for
/// random chains with everything on them, springs from none to 1e12, real and complex shifts.

#include "support/linearized.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <complex>
#include <type_traits>

#include "dynamics/dynamics.h"
#include "lanes/linearized_segments.h"
#include "recursion/dual.h"
#include "support/articulated.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

/// A scene at rest in time: constant loads only, so that they can be written down in one line each.
Scene constantScene(int n, unsigned seed, double stiffness) {
  Scene scene = test::randomScene(n, seed);
  for (Load& load : scene.loads) load.law = Constant{};
  std::vector<Joint> joints = scene.chain.joints();
  for (Joint& joint : joints) joint.stiffness *= stiffness;
  scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
  return scene;
}

Eigen::VectorXd stateOf(const Scene& scene) {
  const int n = scene.chain.size();
  Eigen::VectorXd y(2 * n);
  double theta = 0, omega = 0;
  for (int i = 0; i < n; ++i) {
    y[i] = theta += scene.q[static_cast<std::size_t>(i)];
    y[n + i] = omega += scene.qd[static_cast<std::size_t>(i)];
  }
  return y;
}

/// (ω, α)(y) of a scene of constant loads, in dual numbers: its slope is J times the slope of y.
std::vector<Dual> rightHandSide(const Scene& scene, const std::vector<Dual>& y) {
  const int n = scene.chain.size();
  std::vector<Rotation<Dual>> e;
  std::vector<Dual> N(static_cast<std::size_t>(n)), alpha(static_cast<std::size_t>(n));
  std::vector<Vec2<Dual>> F(static_cast<std::size_t>(n));
  const auto theta = [&](int i) { return i < 0 ? Dual() : y[static_cast<std::size_t>(i)]; };
  const auto omega = [&](int i) { return i < 0 ? Dual() : y[static_cast<std::size_t>(n + i)]; };
  const auto addTorque = [&](int i, Dual tau) {
    N[static_cast<std::size_t>(i)] += tau;
    if (i > 0) N[static_cast<std::size_t>(i - 1)] += -tau;
  };
  for (int i = 0; i < n; ++i) {
    e.push_back(turning(Rotation<double>::of(theta(i).value), theta(i).slope));
    const Joint& joint = scene.chain.joints()[static_cast<std::size_t>(i)];
    addTorque(i, -Dual(joint.stiffness) * (theta(i) - theta(i - 1) - Dual(joint.restAngle)) -
                     Dual(joint.damping) * (omega(i) - omega(i - 1)));
  }
  for (const Load& load : scene.loads) {
    const auto j = static_cast<std::size_t>(load.link);
    const Vec2<Dual> force{load.force.x, load.force.y};
    N[j] += Dual(load.moment) + cross(e[j] * Vec2<Dual>{load.point.x, load.point.y}, force);
    F[j] += force;
    addTorque(load.joint, load.torque);
  }
  Articulated<Dual>(scene.chain)
      .accelerations(e.data(), y.data() + n, N.data(), F.data(),
                     {-scene.chain.gravity().x, -scene.chain.gravity().y}, alpha.data());
  std::vector<Dual> out(y.begin() + n, y.end());
  out.insert(out.end(), alpha.begin(), alpha.end());
  return out;
}

/// J column by column.
Eigen::MatrixXd jacobian(const Scene& scene) {
  const Eigen::VectorXd y = stateOf(scene);
  Eigen::MatrixXd J(y.size(), y.size());
  for (Eigen::Index k = 0; k < y.size(); ++k) {
    std::vector<Dual> at(y.data(), y.data() + y.size());
    at[static_cast<std::size_t>(k)].slope = 1;
    const std::vector<Dual> f = rightHandSide(scene, at);
    for (Eigen::Index i = 0; i < y.size(); ++i) J(i, k) = f[static_cast<std::size_t>(i)].slope;
  }
  return J;
}

/// J is differentiated automatically by this test; here it is checked by differences of the program's own f.
TEST(Jacobian, AgreesWithDifferencesOfTheProgram) {
  for (const int n : {1, 2, 3, 7}) {
    const Scene scene = constantScene(n, static_cast<unsigned>(n), 1);
    Dynamics dynamics(scene);
    Eigen::VectorXd y = Eigen::VectorXd::Zero(dynamics.size()), plus(y), minus(y);
    y.head(2 * n) = stateOf(scene);
    const Eigen::MatrixXd J = jacobian(scene);
    for (int k = 0; k < 2 * n; ++k) {
      const double h = 1e-6;
      Eigen::VectorXd shifted = y;
      shifted[k] = y[k] + h;
      dynamics.derivative(0, shifted.data(), plus.data());
      shifted[k] = y[k] - h;
      dynamics.derivative(0, shifted.data(), minus.data());
      const Eigen::VectorXd column = ((plus - minus) / (2 * h)).head(2 * n);
      EXPECT_LT((column - J.col(k)).norm(), 1e-7 * J.norm()) << "n = " << n << ", column " << k;
    }
  }
}

template <class Scalar>
using VectorOf = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

/// x = (s − J)⁻¹ rhs by the recursion.
template <class Scalar>
VectorOf<Scalar> solution(const Scene& scene, Scalar s, const VectorOf<Scalar>& rhs) {
  const int n = scene.chain.size();
  Dynamics dynamics(scene);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(dynamics.size()), f(y);
  y.head(2 * n) = stateOf(scene);
  dynamics.derivative(0, y.data(), f.data());

  std::vector<Rotation<double>> e;
  std::vector<Vec2d> F(static_cast<std::size_t>(n));
  std::vector<double> XF(static_cast<std::size_t>(n)), k, d;
  for (int i = 0; i < n; ++i) {
    e.push_back(Rotation<double>::of(y[i]));
    k.push_back(scene.chain.joints()[static_cast<std::size_t>(i)].stiffness);
    d.push_back(scene.chain.joints()[static_cast<std::size_t>(i)].damping);
  }
  for (const Load& load : scene.loads) {
    const auto j = static_cast<std::size_t>(load.link);
    F[j] += load.force;
    XF[j] += dot(e[j] * load.point, load.force);
  }
  VectorOf<Scalar> x(2 * n);
  const auto solve = [&](auto& state, auto& solver) {
    state.setJoints(k.data(), d.data());
    state.linearize(e.data(), y.data() + n, f.data() + n, F.data(), XF.data());
    solver.factor(s);
    solver.solve(rhs.data(), rhs.data() + n, x.data(), x.data() + n);
  };
  if constexpr (std::is_same_v<Scalar, long double>) {
    Linearized<Scalar> precise(scene.chain);
    solve(precise, precise);
  } else {
    LinearizedSegments<double> real(scene.chain, false, simd::kernelFor(scene.chain.size(), {}));
    LinearizedSegments<Scalar> solver(real, Kept::whatFits);
    solve(real, solver);
  }
  return x;
}

template <class Scalar>
VectorOf<Scalar> randomVector(int size, unsigned seed) {
  test::Random random(seed);
  VectorOf<Scalar> result(size);
  for (Eigen::Index i = 0; i < size; ++i) result[i] = random.between(-1, 1);
  return result;
}

/// |(s − J) x − rhs| row by row against the size of what is summed there.
template <class Scalar>
double residual(const Scene& scene, Scalar s, unsigned seed) {
  const int n = scene.chain.size();
  const VectorOf<Scalar> rhs = randomVector<Scalar>(2 * n, seed);
  const VectorOf<Scalar> x = solution<Scalar>(scene, s, rhs);
  const Eigen::MatrixXd J = jacobian(scene);
  const VectorOf<Scalar> off = s * x - J * x - rhs;
  Eigen::VectorXd size = std::abs(s) * x.cwiseAbs() + J.cwiseAbs() * x.cwiseAbs() + rhs.cwiseAbs();
  // u = ρ_q/s + u' is summed, and J makes torques of it.
  size += J.leftCols(n).cwiseAbs() * rhs.head(n).cwiseAbs() / std::abs(s);
  return (off.cwiseAbs().array() / size.array()).maxCoeff();
}

TEST(ExactSolve, SolvesWithTheJacobianForEveryStiffness) {
  // Rounding allows some n ulps of what is summed; 1e-11 leaves room for the chains' own condition.
  for (const int n : {1, 2, 3, 7, 20, 50}) {
    for (const double stiffness : {0.0, 1.0, 1e3, 1e6, 1e9, 1e12}) {
      const Scene scene = constantScene(n, 100 + static_cast<unsigned>(n), stiffness);
      for (const double s : {0.1, 10.0, 1e3, 1e5}) {
        EXPECT_LT(residual<double>(scene, s, 7), 1e-11) << "n " << n << " k " << stiffness << " s " << s;
        EXPECT_LT(residual<std::complex<double>>(scene, {s, 2 * s}, 7), 1e-11)
            << "complex, n " << n << " k " << stiffness << " s " << s;
      }
    }
  }
}

TEST(ExactSolve, LosesNothingToStiffSprings) {
  // Compares with the recursion in long double. Springs of 1e12 at rest, and a joint without one that carries
  // them, so that everything else is of size 1: what cancels by the spring shows there, and nowhere in the
  // residual. ρ_q = 0: torques of k ρ_q/s would be rounded themselves.
  Scene scene = constantScene(5, 105, 1e12);
  std::vector<Joint> joints = scene.chain.joints();
  for (std::size_t i = 0; i < joints.size(); ++i) joints[i].restAngle = scene.q[i];
  joints[0].stiffness = 0;
  scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
  Eigen::VectorXd rhs = randomVector<double>(10, 7);
  rhs.head(5).setZero();
  const VectorOf<long double> fine = solution<long double>(scene, 10, rhs.cast<long double>());
  const VectorOf<long double> off = solution<double>(scene, 10, rhs).cast<long double>() - fine;
  EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-12L * fine.cwiseAbs().maxCoeff());
}

TEST(ExactSolve, KnowsWorksAndTime) {
  // Sines and ramps: ∂f/∂t, and the rows of the supplied and dissipated work, against differences. Link by
  // link and in lane order, in segments.
  for (const int n : {5, 20, 70}) {
    const Scene scene = test::randomScene(n, 77);
    Dynamics dynamics(scene);
    dynamics.enter(0.1);
    dynamics.reserve(0);
    const int size = dynamics.size();
    ASSERT_EQ(size, 2 * n + 2);
    Eigen::VectorXd y = Eigen::VectorXd::Zero(size), ft(size), plus(size), minus(size);
    y.head(2 * n) = stateOf(scene);
    const auto laneOrdered = [&](const Eigen::VectorXd& values) {
      Eigen::VectorXd all = Eigen::VectorXd::Constant(dynamics.sizeInLaneOrder(), std::nan(""));
      dynamics.toLaneOrder(values.data(), all.data());
      return all;
    };
    const double t = 0.2, h = 1e-6;
    Eigen::VectorXd f = laneOrdered(y), laneOrderedTime = f;
    dynamics.linearize(t, laneOrdered(y).data(), f.data());
    ASSERT_TRUE(dynamics.timeDerivative(laneOrderedTime.data()));
    dynamics.toChainOrder(laneOrderedTime.data(), ft.data());
    EXPECT_EQ(laneOrdered(ft), laneOrderedTime) << "0 beyond the end";
    dynamics.derivative(t + h, y.data(), plus.data());
    dynamics.derivative(t - h, y.data(), minus.data());
    EXPECT_LT(((plus - minus) / (2 * h) - ft).norm(), 1e-7 * ft.norm()) << n;
    dynamics.derivative(t, y.data(), plus.data());
    EXPECT_EQ(laneOrdered(plus), f) << n;

    const Eigen::VectorXd rhs = Eigen::VectorXd::LinSpaced(size, -1, 1);
    Eigen::VectorXd inPlace = laneOrdered(rhs), x(size);
    const double s = 20;
    dynamics.factor(s);
    dynamics.solve(inPlace.data(), inPlace.data());
    dynamics.toChainOrder(inPlace.data(), x.data());
    EXPECT_EQ(laneOrdered(x), inPlace) << "0 beyond the end";
    Eigen::VectorXd shifted = y + h * x;
    dynamics.derivative(t, shifted.data(), plus.data());
    shifted = y - h * x;
    dynamics.derivative(t, shifted.data(), minus.data());
    const Eigen::VectorXd Jx = (plus - minus) / (2 * h);
    EXPECT_LT((s * x - Jx - rhs).norm(), 1e-7 * (Jx.norm() + rhs.norm())) << n;
  }
}

}  // namespace
}  // namespace planar_chain
