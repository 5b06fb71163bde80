/// The states within a step, from its ends, against a motion that is known exactly.

#include "ode/dense_output.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test_system.h"

namespace planar_chain::ode {
namespace {

/// θ = sin t, so ω = cos t and ω̇ = −θ, and a work with Ẇ = ω².
class Oscillator : public test::TestSystem {
 public:
  int positions() const override { return 1; }
  void rates(double t, const double* y, double* out) override {
    out[0] = -y[0];
    integrands(t, y, out + 1);
  }
  bool hasIntegrands() const override { return true; }
  void integrands(double /*t*/, const double* y, double* rates) override { rates[0] = y[1] * y[1]; }
};

constexpr double start = 0.3;

Eigen::Vector3d exact(double t) {
  return {std::sin(t), std::cos(t), t / 2 + std::sin(2 * t) / 4};
}

struct Step {
  explicit Step(double h) : from(f, exact(start)), to(f, exact(start + h)) {
    for (State* state : {&from, &to}) state->carry.setZero();
    from.t = start;
    to.t = start + h;
    dense.take(from, to);
  }
  Oscillator f;
  State from, to;
  DenseOutput dense{f};
};

double worst(const Eigen::VectorXd& y, double t) {
  return (y - exact(t)).head(2).cwiseAbs().maxCoeff();
}

TEST(DenseOutput, MeetsTheMotionFarBelowItsBound) {
  for (const double h : {0.4, 0.2}) {
    for (const double s : {0.1, 0.3, 0.45, 0.7, 0.9}) {
      const double t = start + s * h;
      Step step(h);
      const Eigen::VectorXd y = step.dense.at(t);
      const Vector bound = step.dense.errorAt(t).cwiseAbs();
      EXPECT_LT(bound.maxCoeff(), 1e-3 * std::pow(h, 5)) << h << " " << s;
      for (int k = 0; k < 2; ++k) EXPECT_LT(std::abs(y[k] - exact(t)[k]), 0.3 * bound[k]) << h << " " << s;
    }
  }
}

TEST(DenseOutput, IsExactAtTheEnds) {
  Step step(0.4);
  EXPECT_LT(worst(step.dense.at(step.from.t), step.from.t), 1e-15);
  EXPECT_EQ(step.dense.at(step.to.t), step.to.y.matrix());
}

TEST(DenseOutput, TakesNoRoundingOfAnAngleForARate) {
  for (const double h : {1e-6, 1e-8, 1e-10}) {
    Step step(h);
    step.to.y[0] += 4e-16;
    step.dense.take(step.from, step.to);
    const double t = start + h / 2;
    EXPECT_NEAR(step.dense.at(t)[1], std::cos(t), 1e-15) << h;
  }
}

/// Its steps end with a projection.
class Projected : public Oscillator {
 public:
  int freedoms() const override { return 2; }
};

TEST(DenseOutput, TakesNoProjectionOfAnAngleForARate) {
  for (const double h : {1e-6, 1e-8, 1e-10, 1e-13}) {
    Projected f;
    DenseOutput dense(f);
    Step step(h);
    step.to.y[0] += 1e-13;
    dense.take(step.from, step.to);
    const double t = start + h / 2;
    EXPECT_NEAR(dense.at(t)[1], std::cos(t), 1e-15) << h;
  }
}

TEST(DenseOutput, UsesTheKernelOfItsSystem) {
  struct : Oscillator {
    const simd::VectorKernel& vectors() const override { return test::idleVectors(); }
  } f;
  DenseOutput dense(f);
  const Step step(0.4);
  dense.take(step.from, step.to);
  EXPECT_EQ(dense.at(start + 0.1).head(2), Eigen::Vector2d::Zero());
}

TEST(DenseOutput, KnowsTheAccelerations) {
  for (const double s : {0.0, 0.3, 0.5, 1.0}) {
    Step step(0.2);
    const double t = start + s * 0.2;
    EXPECT_NEAR(step.dense.accelerationsAt(t)[0], -std::sin(t), 1e-6) << s;
  }
}

TEST(DenseOutput, LandsWithTheWorksFromEitherEnd) {
  for (const double s : {0.2, 0.8}) {
    Step step(0.4);
    const double t = start + s * 0.4;
    State landed = step.to;
    step.dense.land(t, landed);
    EXPECT_EQ(landed.t, t);
    EXPECT_LT(worst(landed.restoredBy(step.f), t), 1e-7);
    EXPECT_LT(std::abs(landed.y[2] - exact(t)[2]), 1e-8) << s;
  }
}

}  // namespace
}  // namespace planar_chain::ode
