#pragma once

/// An initial value problem with a known solution, for every method.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <utility>
#include <vector>

#include "ode/local_stiffness.h"
#include "ode/stepper.h"
#include "ode/system.h"

namespace planar_chain::ode::test {

/// Not autonomous, not linear, solved exactly: y_1 = sin t², y_2 = cos t², y_3 = exp(sin t).
class TestSystem : public SeriesSystem {
 public:
  int size() const override { return 3; }
  void derivative(double t, const double* y, double* dydt) override {
    dydt[0] = 2 * t * y[1];
    dydt[1] = -2 * t * y[0];
    dydt[2] = y[2] * std::cos(t);
  }
  void linearize(double t, const double* y, double* dydt) override {
    derivative(t, y, dydt);
    J_ << 0, 2 * t, 0, -2 * t, 0, 0, 0, 0, std::cos(t);
    ft_ << 2 * y[1], -2 * y[0], -y[2] * std::sin(t);
  }
  bool timeDerivative(double* ft) override {
    Eigen::Map<Eigen::Vector3d>{ft} = ft_;
    return true;
  }
  LinearCosts linearCosts() const override { return {2, 1, 2, 2}; }
  void factor(double s) override { lu_.compute(s * Eigen::Matrix3d::Identity() - J_); }
  void solve(const double* rhs, double* x) override {
    const Eigen::Vector3d solution = lu_.solve(Eigen::Map<const Eigen::Vector3d>(rhs));
    Eigen::Map<Eigen::Vector3d>{x} = solution;
  }

  void reserve(int complexCount) override {
    complexLu_.resize(std::max(complexLu_.size(), static_cast<std::size_t>(complexCount)));
  }
  void factorComplex(int k, std::complex<double> s) override {
    complexLu_[static_cast<std::size_t>(k)].compute(s * Eigen::Matrix3cd::Identity() - J_);
  }
  void solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) override {
    const Eigen::Vector3cd solution =
        complexLu_[static_cast<std::size_t>(k)].solve(Eigen::Map<const Eigen::Vector3cd>(rhs));
    Eigen::Map<Eigen::Vector3cd>{x} = solution;
  }

  bool seriesAreWorthwhile() const override { return true; }
  void reserveSeries(int /*order*/) override {}
  int driving() const override { return 3; }
  void series(double t, const double* y, const double* /*carry*/, int order, double* c) override {
    std::copy(y, y + 3, c);
    double cosine = std::cos(t), sine = std::sin(t);
    std::vector<double> cosines;  // cos(t + h) in powers of h
    for (int k = 0; k < order; ++k) {
      cosines.push_back(cosine);
      double y3 = 0;
      for (int j = 0; j <= k; ++j) y3 += c[3 * (k - j) + 2] * cosines[static_cast<std::size_t>(j)];
      const double *at = c + 3 * k, *before = k > 0 ? at - 3 : nullptr;
      double* next = c + 3 * (k + 1);
      next[0] = 2 * (t * at[1] + (before ? before[1] : 0)) / (k + 1);
      next[1] = -2 * (t * at[0] + (before ? before[0] : 0)) / (k + 1);
      next[2] = y3 / (k + 1);
      const double nextCosine = -sine / (k + 1);
      sine = cosine / (k + 1);
      cosine = nextCosine;
    }
  }
  bool hasIntegrands() const override { return false; }
  void integrands(double /*t*/, const double* /*y*/, double* /*rates*/) override {}
  double seriesCost(int order) const override { return order; }

 private:
  Eigen::Matrix3d J_;
  Eigen::Vector3d ft_;
  Eigen::PartialPivLU<Eigen::Matrix3d> lu_;
  std::vector<Eigen::PartialPivLU<Eigen::Matrix3cd>> complexLu_;
};
inline TestSystem testSystem() {
  return {};
}
inline State testStart() {
  State state(3);
  state.y << 0, 1, 1;
  return state;
}
inline double testError(const State& state) {
  const double t = state.t;
  const Eigen::Vector3d exact(std::sin(t * t), std::cos(t * t), std::exp(std::sin(t)));
  return (state.y - exact).cwiseAbs().maxCoeff();
}

/// Error of equal steps over [0, 2].
inline double errorOfEqualSteps(Stepper&& stepper, int steps) {
  State state = testStart();
  for (int k = 0; k < steps; ++k) {
    stepper.step(k * (2.0 / steps), 2.0 / steps, state.y);
    state.y += stepper.increment();
    stepper.accept();
  }
  state.t = 2;
  return testError(state);
}

/// A kernel whose sums write nothing.
inline const simd::VectorKernel& idleVectors() {
  static const simd::VectorKernel idle = [] {
    simd::VectorKernel kernel = simd::vectorsBaseline;
    kernel.combine.fill(
        [](double, const double*, const double* const*, const double*, double*, double*, std::ptrdiff_t) {});
    kernel.polynomial = [](double, const double*, int, double*, std::ptrdiff_t) {};
    kernel.largestRatio = [](const simd::ErrorVectors&, const simd::AllowedErrors&, std::ptrdiff_t) {
      return 0.0;
    };
    return kernel;
  }();
  return idle;
}

inline std::unique_ptr<Integrator> adaptiveSteps(std::unique_ptr<Stepper> stepper, Tolerance tolerance) {
  auto stiffness = std::make_shared<LocalStiffness>(stepper->system());
  return ode::adaptiveSteps(std::move(stepper), std::move(tolerance), std::move(stiffness));
}

}  // namespace planar_chain::ode::test
