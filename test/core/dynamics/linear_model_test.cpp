/// A and B against another road to the equations of motion: Lagrange's in absolute angles, dense, in complex
/// numbers of long double. Their imaginary part after a step of 1e-100 i is the derivative, exact to
/// rounding; and against vibrations that are known.

#include "planar_chain/linear_model.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <complex>

#include "planar_chain/kane.h"
#include "support/known_chains.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Complex = std::complex<long double>;
using Vector = Eigen::Matrix<Complex, Eigen::Dynamic, 1>;
using Matrix = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic>;
using Plane = Eigen::Matrix<Complex, 2, 1>;

constexpr double t = 0.2;

/// Columns i: ∂(point `at` of link k)/∂θ_i turned back by a quarter, so the point's acceleration is
/// Σ α_i (i C_i) − ω_i² C_i.
Matrix arms(const Scene& scene, const Vector& theta, int k, Vec2d at) {
  Matrix C = Matrix::Zero(2, theta.size());
  for (int i = 0; i <= k; ++i) {
    const Vec2d arm = i < k ? scene.chain.links()[static_cast<std::size_t>(i)].pin : at;
    const Complex c = std::cos(theta[i]), s = std::sin(theta[i]);
    const Complex x = arm.x, y = arm.y;
    C.col(i) << c * x - s * y, s * x + c * y;
  }
  return C;
}

/// Each column turned by a quarter.
Matrix turned(const Matrix& C) {
  Matrix result(2, C.cols());
  result << -C.row(1), C.row(0);
  return result;
}

/// q̈, with `more` torque in the joints. Sums and products alone, no conjugate: differentiable in complex
/// numbers.
Vector accelerations(const Scene& scene, const Vector& q, const Vector& qd, const Vector& more) {
  const int n = scene.chain.size();
  const Matrix sums = Matrix::Ones(n, n).triangularView<Eigen::Lower>();
  const Vector theta = sums * q, omega = sums * qd;
  Matrix M = Matrix::Zero(n, n);
  Vector Q = Vector::Zero(n), tau = more;
  for (int k = 0; k < n; ++k) {
    const Link& link = scene.chain.links()[static_cast<std::size_t>(k)];
    const Matrix C = arms(scene, theta, k, link.com);
    const Complex m = link.mass;
    const Plane g(Complex(scene.chain.gravity().x), Complex(scene.chain.gravity().y));
    M += m * C.transpose() * C;
    M(k, k) += link.inertia;
    Q += m * turned(C).transpose() * (g + C * omega.cwiseProduct(omega));

    const Joint& joint = scene.chain.joints()[static_cast<std::size_t>(k)];
    tau[k] -= Complex(joint.stiffness) * (q[k] - Complex(joint.restAngle)) + Complex(joint.damping) * qd[k];
    for (const long double side : {-1.0L, 1.0L}) {
      const double limit = side > 0 ? joint.upper : joint.lower;
      const Complex x = side * (q[k] - Complex(limit));
      const Complex push = Complex(joint.stopStiffness) * x + Complex(joint.stopDamping) * side * qd[k];
      if (x.real() > 0 && push.real() > 0) tau[k] -= side * push;
    }
  }
  for (const Load& load : scene.loads) {
    if (t < load.start || t >= load.stop) continue;
    const auto* sine = std::get_if<Sine>(&load.law);
    const Complex factor = sine ? std::sin(2 * test::pi * sine->frequency * t + sine->phase) : 1;
    if (load.joint != Load::none) tau[load.joint] += factor * Complex(load.torque);
    if (load.link == Load::none) continue;
    const Plane force(Complex(load.force.x), Complex(load.force.y));
    Q += factor * turned(arms(scene, theta, load.link, load.point)).transpose() * force;
    Q[load.link] += factor * Complex(load.moment);
  }
  Q += tau;
  Q.head(n - 1) -= tau.tail(n - 1);
  const Vector alpha = M.partialPivLu().solve(Q);
  Vector qdd = alpha;
  qdd.tail(n - 1) -= alpha.head(n - 1);
  return qdd;
}

/// The imaginary part of q̈ after a step into it along direction `column` of (q, q̇, τ).
VectorXd derivative(const Scene& scene, const VectorXd& q, const VectorXd& qd, const VectorXd& tau,
                    int column) {
  constexpr long double epsilon = 1e-100L;
  const int n = scene.chain.size();
  Vector at = Vector::Zero(3 * n);
  at.head(n) = q.cast<Complex>();
  at.segment(n, n) = qd.cast<Complex>();
  at.tail(n) = tau.cast<Complex>();
  at[column] += Complex(0, epsilon);
  const Vector qdd = accelerations(scene, at.head(n), at.segment(n, n), at.tail(n));
  return (qdd.imag() / epsilon).cast<double>();
}

VectorXd vector(const std::vector<double>& v) {
  return Eigen::Map<const VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

/// A random scene with stops that push, that have parted and that are free, and with a load whose time is
/// over.
Scene sceneWithEverything(int n, unsigned seed) {
  Scene scene = test::randomScene(n, seed);
  test::Random random(seed);
  std::vector<Joint> joints = scene.chain.joints();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    Joint& joint = joints[i];
    joint.stopStiffness = random.between(10, 100);
    joint.stopDamping = random.between(0, 60);
    joint.upper = scene.q[i] + random.between(-1, 1);
    joint.lower = joint.upper - random.between(0, 2);
  }
  scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
  scene.loads[0].stop = t / 2;
  scene.loads[2].law = Constant{};
  return scene;
}

void expectDerivatives(const Scene& scene, const OperatingPoint& about = {}) {
  const int n = scene.chain.size();
  const VectorXd q = vector(scene.q), qd = vector(scene.qd);
  const LinearModel model = linearModel(scene, t, q, qd, about);
  ASSERT_EQ(model.A.rows(), 2 * n);
  ASSERT_EQ(model.A.cols(), 2 * n);
  ASSERT_EQ(model.B.rows(), 2 * n);
  ASSERT_EQ(model.B.cols(), n);
  MatrixXd above = MatrixXd::Zero(n, 3 * n), all(2 * n, 3 * n);
  above.block(0, n, n, n).setIdentity();
  all << model.A, model.B;
  EXPECT_EQ(all.topRows(n), above);
  for (int column = 0; column < 3 * n; ++column) {
    // Rounding: some n ulps of the column's largest entry, and of the motions that cancel in it. The
    // reference rounds to 1e-19, also where the derivative is 0.
    const VectorXd exact = derivative(scene, q, qd, model.tau, column);
    EXPECT_LT((all.col(column).tail(n) - exact).norm(), 1e-12 * exact.norm() + 1e-18)
        << n << ", column " << column;
  }
}

TEST(LinearModel, IsTheDerivativeOfLagrangesEquations) {
  for (const int n : {1, 2, 3, 5, 8, 20}) {
    for (const unsigned seed : {1U, 2U, 3U, 4U}) {
      const Scene scene = sceneWithEverything(n, 1000 * seed + static_cast<unsigned>(n));
      // The two roads have the same motion to differentiate.
      const Vector qdd = accelerations(scene, vector(scene.q).cast<Complex>(),
                                       vector(scene.qd).cast<Complex>(), Vector::Zero(n));
      const VectorXd q = vector(scene.q), qd = vector(scene.qd);
      const VectorXd kanes = kane(scene.chain, q, qd, activeForces(scene, t, q, qd)).qdd;
      EXPECT_LT((kanes - qdd.real().cast<double>()).norm(), 1e-10 * kanes.norm());
      expectDerivatives(scene);
    }
  }
}

TEST(LinearModel, OfBareChainsToo) {
  for (const int n : {1, 4}) expectDerivatives(test::randomScene(n, 7, {false, false, false}));
}

TEST(LinearModel, IsAboutTheTorques) {
  for (const int n : {1, 3, 6}) {
    const Scene scene = sceneWithEverything(n, 20 + static_cast<unsigned>(n));
    OperatingPoint about;
    about.tau = VectorXd::LinSpaced(n, -20, 30);
    expectDerivatives(scene, about);
    about = {};
    about.isHeld = true;
    expectDerivatives(scene, about);

    const VectorXd tau = linearModel(scene, t, vector(scene.q), vector(scene.qd), about).tau;
    const Vector qdd = accelerations(scene, vector(scene.q).cast<Complex>(), vector(scene.qd).cast<Complex>(),
                                     tau.cast<Complex>());
    EXPECT_LT(static_cast<double>(qdd.norm()), 1e-11 * tau.norm()) << "held";
  }
}

std::string notesOf(const Scene& scene, const VectorXd& q, const OperatingPoint& about = {}) {
  std::string all;
  for (const std::string& note : linearModel(scene, 0, q, VectorXd::Zero(q.size()), about).notes)
    all += note + "\n";
  return all;
}

TEST(LinearModel, NotesWhatIsNoEquilibrium) {
  const Scene rods = test::uniformChain(2, {"", 1, 1. / 12, {0.5, 0}, {1, 0}}, {}, {}, {0, -10});
  const VectorXd level = VectorXd::Zero(2);
  OperatingPoint about;
  EXPECT_NE(notesOf(rods, level).find("The torques tau = 20,5 would hold it"), std::string::npos);
  about.isHeld = true;
  EXPECT_EQ(notesOf(rods, level, about), "");
  about = {};
  about.tau = Eigen::Vector2d(20, 5);
  EXPECT_EQ(notesOf(rods, level, about), "");
  about.tau = Eigen::Vector2d(20, 5 + 1e-5);
  EXPECT_NE(notesOf(rods, level, about), "");
  about.tau = VectorXd::Zero(3);
  EXPECT_THROW(linearModel(rods, 0, level, level, about), Refused);
}

TEST(LinearModel, OfAJointAtRestSticksOrSlips) {
  Scene rubbing = test::uniformChain(2, {"", 1, 1. / 12, {0.5, 0}, {1, 0}}, {}, {}, {1, 0}), smooth = rubbing;
  std::vector<Joint> joints = rubbing.chain.joints();
  joints[1].others = {{"friction", 0.5}, {"command_delay", 0.02}};
  rubbing.chain = Chain(rubbing.chain.links(), joints, rubbing.chain.gravity());
  const VectorXd q = VectorXd::Zero(2);
  const LinearModel stuck = linearModel(rubbing, 0, q, q);
  EXPECT_EQ(stuck.B.col(1), VectorXd::Zero(4));
  const std::string notes = notesOf(rubbing, q);
  EXPECT_NE(notes.find(joints[1].name + " sticks"), std::string::npos) << notes;
  EXPECT_NE(notes.find("(command_delay 0.02 s)"), std::string::npos) << notes;
  OperatingPoint slips;
  slips.slips = true;
  EXPECT_EQ(linearModel(rubbing, 0, q, q, slips).A, linearModel(smooth, 0, q, q).A);
  EXPECT_EQ(linearModel(rubbing, 0, q, q, slips).B, linearModel(smooth, 0, q, q).B);
  EXPECT_EQ(notesOf(rubbing, q, slips).find("sticks"), std::string::npos);
}

TEST(LinearModel, HasTheInverseMassMatrixInB) {
  const Scene scene = sceneWithEverything(6, 11);
  const VectorXd q = vector(scene.q), qd = vector(scene.qd);
  const MatrixXd M = kane(scene.chain, q, qd, activeForces(scene, t, q, qd)).M_q;
  const MatrixXd product = linearModel(scene, t, q, qd).B.bottomRows(6) * M;
  EXPECT_LT((product - MatrixXd::Identity(6, 6)).norm(), 1e-11);
}

/// Imaginary parts ≥ 0 of A's eigenvalues, ascending; the real parts are told to be 0 within `tolerance`.
std::vector<double> frequencies(const Scene& scene, double tolerance) {
  const MatrixXd A = linearModel(scene, 0, vector(scene.q), vector(scene.qd)).A;
  std::vector<double> result;
  const Eigen::VectorXcd values = A.eigenvalues();
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(values[i].real(), 0, tolerance);
    if (values[i].imag() >= 0) result.push_back(values[i].imag());
  }
  std::sort(result.begin(), result.end());
  return result;
}

TEST(LinearModel, VibratesAsTwoHangingRodsDo) {
  const Scene rods = test::uniformChain(2, {"", 1, 1. / 12, {0.5, 0}, {1, 0}}, {}, {}, {1, 0});
  const std::vector<double> w = frequencies(rods, 1e-14);
  ASSERT_EQ(w.size(), 2U);
  EXPECT_NEAR(w[0], 0.855694549, 1e-9);
  EXPECT_NEAR(w[1], 2.295165972, 1e-9);
}

TEST(LinearModel, VibratesAsASpinningThreadOfBeadsDoes) {
  // (ω/Ω)² = d (d + 1)/2 − 1, d = 1, 3, 5 …; see limits_test.cpp. That of d = 1 is a double eigenvalue 0: the
  // whole thread turns on. Such a one splits by the root of rounding.
  for (const int n : {2, 4, 6}) {
    Scene thread = test::beads(n, 1. / n, {});
    thread.qd[0] = 3;
    std::vector<double> w = frequencies(thread, 1e-6);
    ASSERT_GE(w.size(), static_cast<std::size_t>(n));
    std::reverse(w.begin(), w.end());
    for (int k = 0; k < n; ++k) {
      const double d = 2 * (n - k) - 1;
      const double exact = 3 * std::sqrt(d * (d + 1) / 2 - 1);
      EXPECT_NEAR(w[static_cast<std::size_t>(k)], exact, d > 1 ? 1e-12 * exact : 1e-6) << n << " beads";
    }
  }
}

TEST(LinearModel, RefusesStatesOfTheWrongSize) {
  const Scene scene = test::randomScene(2, 1);
  EXPECT_THROW(linearModel(scene, 0, VectorXd::Zero(3), VectorXd::Zero(2)), std::invalid_argument);
  EXPECT_THROW(linearModel(scene, 0, VectorXd::Zero(2), VectorXd::Zero(1)), std::invalid_argument);
}

}  // namespace
}  // namespace planar_chain
