/// The notes' lines, ticked off one by one, each against something that knows nothing of the matrices:
/// differentiation of positions and energies, and Lagrange's equations (reference/equations).

#include "planar_chain/kane.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <complex>
#include <functional>
#include <map>

#include "planar_chain/energy.h"
#include "support/random_scene.h"
#include "support/reference_data.h"

namespace planar_chain {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::randomScene;

/// Central differences with step h lose |f'''| h²/6 and 2^-53 |f|/h: some 1e-9 here.
constexpr double h = 1e-5;
constexpr double byDifferences = 1e-8;
/// Products of a few matrices of a few dozen terms, each rounded.
constexpr double byRounding = 1e-13;

VectorXd vector(const std::vector<double>& v) {
  return Eigen::Map<const VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

double largest(const MatrixXd& m) {
  return m.size() == 0 ? 0 : m.cwiseAbs().maxCoeff();
}

#define EXPECT_SAME(a, b, tolerance) \
  EXPECT_LE(largest(MatrixXd(a) - MatrixXd(b)), (tolerance) * (1 + largest(MatrixXd(b))))

/// A random chain at its random state.
struct Case {
  Scene scene;
  VectorXd q, qd;
  Kane k;

  explicit Case(int n, test::With with = {})
      : scene(randomScene(n, 100 + static_cast<unsigned>(n), with)),
        q(vector(scene.q)),
        qd(vector(scene.qd)),
        k(at(q, qd)) {}

  Kane at(const VectorXd& q_, const VectorXd& qd_) const {
    return kane(scene.chain, q_, qd_, activeForces(scene, 0.2, q_, qd_));
  }
  /// d/dt of what `of` takes from the matrices, while q moves with q̇.
  MatrixXd rate(const std::function<MatrixXd(const Kane&)>& of) const {
    return (of(at(q + h * qd, qd)) - of(at(q - h * qd, qd))) / (2 * h);
  }
};

/// Centres of mass x_1 y_1 x_2 y_2 … for angles of any number type.
template <class Number>
std::vector<Number> centresOfMass(const Chain& chain, const std::vector<Number>& q) {
  using std::cos;
  using std::sin;
  std::vector<Number> result;
  Number theta = 0, x = 0, y = 0;
  for (std::size_t i = 0; i < q.size(); ++i) {
    theta += q[i];
    const Number c = cos(theta), s = sin(theta);
    const Vec2d r = chain.links()[i].com, p = chain.links()[i].pin;
    result.push_back(x + c * r.x - s * r.y);
    result.push_back(y + s * r.x + c * r.y);
    x += c * p.x - s * p.y;
    y += s * p.x + c * p.y;
  }
  return result;
}

/// ∂(centres of mass)/∂qᵀ to rounding: the imaginary part of x(q + i ε e_k), over ε.
MatrixXd gradientOfCentres(const Chain& chain, const VectorXd& q) {
  constexpr double epsilon = 1e-100;
  MatrixXd result(q.size(), 2 * q.size());
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    std::vector<std::complex<double>> disturbed(q.data(), q.data() + q.size());
    disturbed[static_cast<std::size_t>(k)] += std::complex<double>(0, epsilon);
    const auto x = centresOfMass(chain, disturbed);
    for (Eigen::Index j = 0; j < result.cols(); ++j) {
      result(k, j) = x[static_cast<std::size_t>(j)].imag() / epsilon;
    }
  }
  return result;
}

Energy energyAt(const Chain& chain, const VectorXd& q, const VectorXd& qd) {
  const VectorXd theta = (q.transpose() * MatrixXd::Ones(q.size(), q.size()).triangularView<Eigen::Upper>());
  const VectorXd omega = (qd.transpose() * MatrixXd::Ones(q.size(), q.size()).triangularView<Eigen::Upper>());
  return energyOf(chain, theta.data(), omega.data());
}

const std::vector<int> sizes{1, 2, 3, 4, 7, 12};

TEST(Notes, ShiftersAreRotationsOneUponTheOther) {
  for (const int n : sizes) {
    const Case c(n);
    Matrix2d S_i0 = Matrix2d::Identity();
    for (int i = 0; i < n; ++i) {
      // S_i0 = S_i,i−1 S_i−1,0
      S_i0 = (Matrix2d() << cos(c.q(i)), sin(c.q(i)), -sin(c.q(i)), cos(c.q(i))).finished() * S_i0;
      const Matrix2d& S = c.k.S[static_cast<std::size_t>(i)];
      EXPECT_SAME(S, S_i0, byRounding);
      EXPECT_SAME(S * S.transpose(), Matrix2d::Identity(), byRounding);
      EXPECT_NEAR(S.determinant(), 1, byRounding);
    }
  }
}

TEST(Notes, AngularVelocityMatrixIsSDotSTransposed) {
  for (const int n : sizes) {
    const Case c(n);
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
      const MatrixXd S_dot = c.rate([i](const Kane& k) { return k.S[i]; });
      EXPECT_SAME(c.k.omega[i], S_dot * c.k.S[i].transpose(), byDifferences);
    }
  }
}

TEST(Notes, TwoBodiesPrintedAsThere) {
  const Case c(2);
  const auto& [body1, body2] = std::tie(c.scene.chain.links()[0], c.scene.chain.links()[1]);
  const Eigen::RowVector2d S_r1(-body1.com.y, body1.com.x), S_p1(-body1.pin.y, body1.pin.x);
  const Eigen::RowVector2d S_r2(-body2.com.y, body2.com.x);
  const Matrix2d& S_10 = c.k.S[0];
  const Matrix2d& S_20 = c.k.S[1];
  MatrixXd T(2, 2), B(2, 4), C(2, 4);
  T << 1, 1,  //
      0, 1;
  B << S_r1 * S_10, S_p1 * S_10,  //
      0, 0, S_r2 * S_20;
  C << S_r1 * c.k.omega[0] * S_10, S_p1 * c.k.omega[0] * S_10,  //
      0, 0, S_r2 * c.k.omega[1] * S_20;
  const MatrixXd m = Eigen::Vector4d(body1.mass, body1.mass, body2.mass, body2.mass).asDiagonal();
  const MatrixXd I = Eigen::Vector2d(body1.inertia, body2.inertia).asDiagonal();
  EXPECT_EQ(c.k.T, T);
  EXPECT_EQ(c.k.W_pd, T);
  EXPECT_SAME(c.k.V_pd, T * B, byRounding);
  EXPECT_SAME(c.k.A_1, T * C * m, byRounding);
  EXPECT_SAME(c.k.A_2, T * B * m, byRounding);
  EXPECT_SAME(c.k.A_3, T * I, byRounding);
}

TEST(Notes, PartialVelocitiesAreDerivativesOfPositions) {
  // v = Σ (∂x/∂q_k) q̇_k, hence ∂v/∂q̇_k = ∂x/∂q_k.
  for (const int n : sizes) {
    const Case c(n);
    EXPECT_SAME(c.k.V_pd, gradientOfCentres(c.scene.chain, c.q), byRounding);
    EXPECT_EQ(c.k.W_pd, c.k.T);
  }
}

TEST(Notes, InertiaMatricesGiveMassTimesAcceleration) {
  // v = q̇ᵀ (∂x/∂qᵀ), hence a = q̇ᵀ d/dt(∂x/∂qᵀ) + q̈ᵀ (∂x/∂qᵀ), and m a = q̇ᵀ A_1 + q̈ᵀ A_2.
  for (const int n : sizes) {
    const Case c(n);
    const Chain& chain = c.scene.chain;
    VectorXd m(2 * n), I(n);
    for (int i = 0; i < n; ++i) {
      const Link& link = chain.links()[static_cast<std::size_t>(i)];
      m.segment<2>(2 * i).setConstant(link.mass);
      I(i) = link.inertia;
    }
    const MatrixXd rate =
        (gradientOfCentres(chain, c.q + h * c.qd) - gradientOfCentres(chain, c.q - h * c.qd)) / (2 * h);
    EXPECT_SAME(c.k.A_1, rate * m.asDiagonal(), byDifferences);
    EXPECT_SAME(c.k.A_2, gradientOfCentres(chain, c.q) * m.asDiagonal(), byRounding);
    // I α, α = q̈ᵀ T
    EXPECT_SAME(c.k.A_3, c.k.T * I.asDiagonal(), byRounding);
  }
}

TEST(Notes, KanesEquationsHold) {
  for (const int n : sizes) {
    const Case c(n);
    const ActiveForces active = activeForces(c.scene, 0.2, c.q, c.qd);
    const VectorXd &F = active.F, &M = active.M, &tau = active.tau;
    const VectorXd F_in = -c.k.A_1.transpose() * c.qd - c.k.A_2.transpose() * c.k.qdd;
    const VectorXd M_in = -c.k.A_3.transpose() * c.k.qdd;
    const VectorXd sum = c.k.V_pd * (F + F_in) + c.k.W_pd * (M + M_in) + tau;
    EXPECT_LE(largest(sum), 1e-12 * (1 + largest(c.k.V_pd * F_in))) << n;
  }
}

TEST(Laws, MassMatrixIsThatOfTheKineticEnergy) {
  for (const int n : sizes) {
    const Case c(n);
    EXPECT_SAME(c.k.M_q, c.k.M_q.transpose(), byRounding);
    EXPECT_EQ(Eigen::LLT<MatrixXd>(c.k.M_q).info(), Eigen::Success) << "positive definite";
    const double kinetic = energyAt(c.scene.chain, c.q, c.qd).kinetic;
    EXPECT_NEAR(0.5 * c.qd.dot(c.k.M_q * c.qd), kinetic, byRounding * (1 + kinetic));
  }
}

TEST(Laws, MassRateLessTwiceCoriolisIsSkew) {
  // With C = V_pd A_1ᵀ: velocities do no work beyond what the changing mass matrix takes.
  for (const int n : sizes) {
    const Case c(n);
    const MatrixXd M_dot = c.rate([](const Kane& k) { return k.M_q; });
    const MatrixXd coriolis = c.k.V_pd * c.k.A_1.transpose();
    const MatrixXd N = M_dot - 2 * coriolis;
    EXPECT_LE(largest(N + N.transpose()), byDifferences * (1 + largest(coriolis))) << n;
  }
}

TEST(Laws, PowerInEqualsEnergyRate) {
  // d(T + V)/dt along q̇, q̈ equals the power of everything that has no potential.
  for (const int n : sizes) {
    const Case c(n);
    const auto energyAfter = [&](double t) {
      return energyAt(c.scene.chain, c.q + t * c.qd + t * t / 2 * c.k.qdd, c.qd + t * c.k.qdd).total();
    };
    Scene conservative = c.scene;
    std::vector<Joint> joints = c.scene.chain.joints();
    for (Joint& joint : joints) joint.damping = 0;
    conservative.chain = Chain(c.scene.chain.links(), joints, c.scene.chain.gravity());
    conservative.loads.clear();
    const ActiveForces forces = activeForces(conservative, 0.2, c.q, c.qd);
    const VectorXd withPotential = kane(conservative.chain, c.q, c.qd, forces).f_ext;

    const double power = c.qd.dot(c.k.f_ext - withPotential);
    const double dt = h / 10;  // q̈ reaches 100 rad/s², which bends the energy sharply
    const double rate = (energyAfter(dt) - energyAfter(-dt)) / (2 * dt);
    const double scale = energyAfter(0) + largest(c.k.qdd) * largest(c.k.M_q * c.qd);
    EXPECT_NEAR(power, rate, byDifferences * (1 + std::abs(scale))) << n;
  }
}

TEST(Laws, GravityAndSpringsArePotentialGradients) {
  for (const int n : sizes) {
    const Case c(n, {true, false, false});
    VectorXd gradient(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const VectorXd step = h * VectorXd::Unit(n, i);
      gradient(i) = (energyAt(c.scene.chain, c.q + step, c.qd).potential -
                     energyAt(c.scene.chain, c.q - step, c.qd).potential) /
                    (2 * h);
    }
    EXPECT_SAME(c.k.f_ext, -gradient, byDifferences);
  }
}

TEST(Reference, LagrangesEquationsBySympy) {
  // 20 digits, so what differs is double arithmetic here: relative to the largest entry, and for q̈ times
  // the condition of M_q, at most some 1e3 in these chains.
  for (const int n : {1, 2, 3, 4, 7}) {
    const std::string name = "equations/chain_" + std::to_string(n);
    const Scene scene = test::referenceScene(name + ".yaml");
    std::map<std::string, std::map<std::string, MatrixXd>> expected;
    for (const test::Row& row : test::referenceTable(name + ".csv")) {
      MatrixXd& quantity = expected[row.text("t")][row.text("quantity")];
      if (quantity.size() == 0) quantity = MatrixXd::Zero(n, row.text("quantity") == "M" ? n : 1);
      quantity(row.index("row"), row.index("column")) = row.number("value");
    }
    ASSERT_EQ(expected.size(), 4U);
    for (const auto& [t, x] : expected) {
      SCOPED_TRACE(name + " at t = " + t);
      const VectorXd q = x.at("q"), qd = x.at("qd");
      const Kane k = kane(scene.chain, q, qd, activeForces(scene, std::stod(t), q, qd));
      EXPECT_SAME(k.M_q, x.at("M"), 1e-14);
      EXPECT_SAME(k.f_ext, x.at("f_ext"), 1e-14);
      EXPECT_SAME(k.f, x.at("f"), 1e-14);
      EXPECT_SAME(k.qdd, x.at("qdd"), 1e-12);
    }
  }
}

TEST(Refusal, WrongSizesAndUnknownBodiesThrow) {
  Case c(3);
  const VectorXd two = VectorXd::Zero(2), three = VectorXd::Zero(3);
  const ActiveForces active = activeForces(c.scene, 0, three, three);
  const ActiveForces wrong[] = {
      {three, active.M, active.tau}, {active.F, two, active.tau}, {active.F, active.M, two}};
  EXPECT_THROW(kane(c.scene.chain, two, three, active), std::invalid_argument);
  EXPECT_THROW(kane(c.scene.chain, three, two, active), std::invalid_argument);
  for (const ActiveForces& w : wrong) {
    EXPECT_THROW(kane(c.scene.chain, three, three, w), std::invalid_argument);
  }
  EXPECT_THROW(activeForces(c.scene, 0, two, three), std::invalid_argument);
  EXPECT_THROW(activeForces(c.scene, 0, three, two), std::invalid_argument);
  c.scene.loads[0].link = 3;
  EXPECT_THROW(activeForces(c.scene, 0, three, three), std::invalid_argument);
}

}  // namespace
}  // namespace planar_chain
