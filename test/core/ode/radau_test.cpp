/// Radau IIA of order 13 against its own promises: its numbers, its order, its damping, and what it does when
/// Newton's method fails.

#include "ode/radau.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <complex>

#include "dynamics/dynamics.h"
#include "ode/local_stiffness.h"
#include "ode/methods.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "support/random_scene.h"
#include "test_system.h"

namespace planar_chain::ode {
namespace {

using Complex = std::complex<double>;
constexpr int s = RadauTable::stages;

Tolerance toleranceOf(double value, int size) {
  return {value, Eigen::ArrayXd::Constant(size, 1e300)};
}

std::unique_ptr<Radau> radauFor(LinearizedSystem& f, double tolerance) {
  return std::make_unique<Radau>(f, toleranceOf(tolerance, f.size()), std::make_shared<LocalStiffness>(f));
}

/// c^k, component by component.
RadauTable::PerStage power(int k) {
  return radau13().c.array().pow(k).matrix();
}

// Butcher's simplifying assumptions. B(13), C(7) and D(6) together make order 13, as 13 ≤ 7 + 6 + 1 and
// 13 ≤ 2·7 + 2 (Hairer, Nørsett, Wanner I, theorem II.7.4).
TEST(RadauTable, MeetsTheConditionsOfOrder13AndNotOf14) {
  const RadauTable& table = radau13();
  const RadauTable::PerStage b = table.A.row(s - 1);
  EXPECT_EQ(table.c[s - 1], 1);
  for (int k = 1; k <= 13; ++k) EXPECT_NEAR(b.dot(power(k - 1)), 1. / k, 1e-15) << "B " << k;
  EXPECT_GT(std::abs(b.dot(power(13)) - 1. / 14), 1e-9);
  for (int k = 1; k <= 7; ++k) {
    EXPECT_LT((table.A * power(k - 1) - power(k) / k).cwiseAbs().maxCoeff(), 1e-15) << "C " << k;
  }
  for (int k = 1; k <= 6; ++k) {
    const RadauTable::PerStage left = table.A.transpose() * b.cwiseProduct(power(k - 1));
    const RadauTable::PerStage right = b.cwiseProduct(RadauTable::PerStage::Ones() - power(k)) / k;
    EXPECT_LT((left - right).cwiseAbs().maxCoeff(), 1e-15) << "D " << k;
  }
}

TEST(RadauTable, IsTransformedToOneRealAndThreeComplexNumbers) {
  const RadauTable& table = radau13();
  RadauTable::Square blocks = RadauTable::Square::Zero();
  blocks(0, 0) = table.lambda;
  for (int k = 0; k < RadauTable::pairs; ++k) {
    const Complex mu = table.mu[static_cast<std::size_t>(k)];
    blocks.block<2, 2>(1 + 2 * k, 1 + 2 * k) << mu.real(), -mu.imag(), mu.imag(), mu.real();
  }
  const double size = table.W.norm();
  EXPECT_LT((table.W * table.A - RadauTable::Square::Identity()).norm(), 1e-15 * size);
  EXPECT_LT((table.inverseT * table.W * table.T - blocks).norm(), 1e-12 * size);
  EXPECT_LT((table.T * table.inverseT - RadauTable::Square::Identity()).norm(), 1e-12);
}

TEST(RadauTable, EstimatesTheErrorByAnEmbeddedSolutionOfOrder7) {
  // y = x^k on [0, 1]: Z_i = c_i^k, f = k x^(k−1). What is estimated is 0 up to k = 7.
  const RadauTable& table = radau13();
  for (int k = 1; k <= 8; ++k) {
    const double estimate = (k == 1 ? 1 / table.lambda : 0) + table.e.dot(power(k));
    if (k <= 7) {
      EXPECT_NEAR(estimate, 0, 1e-15) << k;
    } else {
      EXPECT_GT(std::abs(estimate), 1e-6);
    }
  }
}

/// R(z) = 1 + z bᵀ (1 − z A)⁻¹ 1.
Complex stability(Complex z) {
  using Square = Eigen::Matrix<Complex, s, s>;
  const Square system = Square::Identity() - z * radau13().A.cast<Complex>();
  const Eigen::Matrix<Complex, s, 1> one = Eigen::Matrix<Complex, s, 1>::Ones();
  return 1.0 + z * (radau13().A.row(s - 1).cast<Complex>() * system.partialPivLu().solve(one))(0);
}

TEST(Radau, IsLStable) {
  // A-stable: |R| ≤ 1 on the imaginary axis (R has no pole to its left). L-stable: R(∞) = 0.
  for (double w = 1e-3; w < 1e6; w *= 1.2) EXPECT_LE(std::abs(stability({0, w})), 1 + 1e-12) << w;
  EXPECT_LT(std::abs(stability(-1e8)), 1e-6);
  EXPECT_LT(std::abs(stability({0, 1e8})), 1e-6);
}

TEST(Radau, HasTheMeasuredOrder) {
  auto f = test::testSystem();
  const auto error = [&](int steps) {
    return test::errorOfEqualSteps(std::move(*radauFor(f, 1e-14)), steps);
  };
  // Fewer steps are too long for Newton's method, more leave nothing but rounding.
  EXPECT_NEAR(std::log(error(5) / error(7)) / std::log(7. / 5), 13, 0.5);
}

TEST(Radau, SolvesToTheTolerance) {
  for (const double tolerance : {1e-3, 1e-5, 1e-7, 1e-9, 1e-11}) {
    auto f = test::testSystem();
    State state = test::testStart();
    const auto method = makeMethod("radau13", f, 0, toleranceOf(tolerance, 3));
    ASSERT_EQ(method->integrate(state, 5, 100), Outcome::arrived);
    EXPECT_LT(test::testError(state), 5 * tolerance);
  }
}

/// ẏ = −1000 (y − cos t), with a J that is wrong by a factor.
class Misled : public LinearizedSystem {
 public:
  explicit Misled(double factor) : factor_(factor) {}
  int size() const override { return 1; }
  void derivative(double t, const double* y, double* dydt) override { *dydt = -1000 * (*y - std::cos(t)); }
  void linearize(double t, const double* y, double* dydt) override { derivative(t, y, dydt); }
  bool timeDerivative(double*) override { return false; }
  LinearCosts linearCosts() const override { return {1, 1, 1, 1}; }
  void factor(double shift) override { shift_ = shift; }
  void solve(const double* rhs, double* x) override { *x = *rhs / (shift_ + 1000 * factor_); }
  void reserve(int complexCount) override { shifts_.resize(static_cast<std::size_t>(complexCount)); }
  void factorComplex(int k, Complex shift) override { shifts_[static_cast<std::size_t>(k)] = shift; }
  void solveComplex(int k, const Complex* rhs, Complex* x) override {
    *x = *rhs / (shifts_[static_cast<std::size_t>(k)] + 1000 * factor_);
  }

 private:
  double factor_, shift_ = 0;
  std::vector<Complex> shifts_;
};

TEST(Radau, EstimatesTheErrorByItsFormula) {
  // (λ/h − J)⁻¹ (f + λ/h Σ e_i Z_i), where the stages solve Z = h A f(y + Z), which is linear here.
  const RadauTable& table = radau13();
  for (const double h : {0.003, 0.03}) {
    Misled f(1);
    const auto radau = radauFor(f, 1e-13);
    const double t = 0.5;
    const Eigen::VectorXd y = Eigen::VectorXd::Constant(1, 2);
    radau->step(t, h, y);

    const RadauTable::PerStage slopes = -1000 * (y[0] - (t + h * table.c.array()).cos());
    const RadauTable::Square system = RadauTable::Square::Identity() + 1000 * h * table.A;
    const RadauTable::PerStage Z = system.partialPivLu().solve(h * table.A * slopes);
    double side = 0;
    f.derivative(t, y.data(), &side);
    side += table.lambda / h * table.e.dot(Z);
    const double expected = side / (table.lambda / h + 1000);
    EXPECT_GT(std::abs(expected), 1e-6);
    EXPECT_NEAR(radau->error()[0], expected, 1e-9 * std::abs(expected) + 1e-14);
  }
}

TEST(Radau, RejectsAStepWhoseStagesAreNotFound) {
  // A tenth of the true J lets Newton's method diverge, but for steps that are short against 1/1000.
  Misled f(0.1);
  const auto radau = radauFor(f, 1e-6);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(1);
  radau->step(0, 1, y);
  EXPECT_TRUE(std::isnan(radau->increment()[0]));
  EXPECT_GT(radau->error()[0], 10 * 0.25e-6);

  State state(1);
  const auto method = test::adaptiveSteps(radauFor(f, 1e-6), toleranceOf(1e-6, 1));
  ASSERT_EQ(method->integrate(state, 1, 100), Outcome::arrived);
  EXPECT_GT(method->count().rejected, 0);
  EXPECT_NEAR(state.y[0], std::cos(1.0) + std::sin(1.0) / 1000, 2e-6);
}

// The pole is driven, so its angle is exact after one iteration and the cart's rate after two. The third
// changes nothing but digits, which says nothing of the first iteration of the next step. The momentum along
// the rail stays.
TEST(Radau, FindsTheStagesWhereAllElseIsDriven) {
  Scene scene = readSceneText(
      "chain: [cart, pole]\nlinks:\n"
      "  cart: {mass: 2, joint: {type: prismatic}, initial: {velocity: 1.5}}\n"
      "  pole: {mass: 1, inertia: 0.04, com: [0.3, 0], pin: [0.6, 0],\n"
      "         joint: {drive: {amplitude: 0.95, frequency: 3}}}\n");
  for (const double tolerance : {1e-4, 1e-5, 1e-6, 1e-8}) {
    scene.integrator = {"radau13", tolerance};
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(0.1));
    const double q = simulation.q()[1], qd = simulation.qd()[1];
    EXPECT_NEAR(3 * simulation.qd()[0] - 0.3 * std::sin(q) * qd, 3 * 1.5, tolerance) << tolerance;
  }
}

TEST(Radau, DampsWhatIsStiffInOneStep) {
  Misled f(1);
  const auto radau = radauFor(f, 1e-3);
  Eigen::VectorXd y = Eigen::VectorXd::Constant(1, 2);
  radau->step(0, 10, y);
  EXPECT_NEAR(y[0] + radau->increment()[0], std::cos(10.0) + std::sin(10.0) / 1000, 1e-2);
}

TEST(Radau, SolvesWithComplexShiftsWorksIncluded) {
  // (s − J) x = rhs, J x by differences of f along the real and the imaginary part of x. Link by link and
  // in lane order, in segments.
  for (const int n : {5, 20, 70}) {
    const Scene scene = planar_chain::test::randomScene(n, 77);
    Dynamics dynamics(scene);
    dynamics.enter(0.1);
    const int size = dynamics.size();
    Eigen::VectorXd y = Eigen::VectorXd::Zero(size), plus(size), minus(size);
    for (int i = 0; i < n; ++i) {
      y[i] = (i > 0 ? y[i - 1] : 0) + scene.q[static_cast<std::size_t>(i)];
      y[n + i] = (i > 0 ? y[n + i - 1] : 0) + scene.qd[static_cast<std::size_t>(i)];
    }
    const double t = 0.2, h = 1e-6;
    dynamics.reserve(2);
    Eigen::VectorXd laneOrdered(dynamics.sizeInLaneOrder()), f(laneOrdered);
    dynamics.toLaneOrder(y.data(), laneOrdered.data());
    dynamics.linearize(t, laneOrdered.data(), f.data());
    const Complex shifts[] = {{20, 30}, {5, -3}};
    for (int k = 0; k < 2; ++k) dynamics.factorComplex(k, shifts[k]);
    for (int k = 0; k < 2; ++k) {
      Eigen::VectorXcd rhs(size), x(size), laneOrderedX(dynamics.sizeInLaneOrder());
      rhs.real() = Eigen::VectorXd::LinSpaced(size, -1, 1);
      rhs.imag() = Eigen::VectorXd::LinSpaced(size, 2, -1);
      const auto part = [&](const Eigen::VectorXd& values) {
        dynamics.toLaneOrder(values.data(), laneOrdered.data());
        return laneOrdered;
      };
      laneOrderedX.real() = part(rhs.real());
      laneOrderedX.imag() = part(rhs.imag());
      dynamics.solveComplex(k, laneOrderedX.data(), laneOrderedX.data());
      const auto restored = [&](const Eigen::VectorXd& values) {
        Eigen::VectorXd inOrder(size);
        dynamics.toChainOrder(values.data(), inOrder.data());
        return inOrder;
      };
      x.real() = restored(laneOrderedX.real());
      x.imag() = restored(laneOrderedX.imag());
      const auto along = [&](const Eigen::VectorXd& direction) {
        Eigen::VectorXd shifted = y + h * direction;
        dynamics.derivative(t, shifted.data(), plus.data());
        shifted = y - h * direction;
        dynamics.derivative(t, shifted.data(), minus.data());
        return Eigen::VectorXd((plus - minus) / (2 * h));
      };
      Eigen::VectorXcd Jx(size);
      Jx.real() = along(x.real());
      Jx.imag() = along(x.imag());
      EXPECT_LT((shifts[k] * x - Jx - rhs).norm(), 1e-7 * (Jx.norm() + rhs.norm())) << n << " " << k;
    }
  }
}

}  // namespace
}  // namespace planar_chain::ode
