#pragma once

/// Steps along the Taylor series of the solution, of an order that the tolerance asks for:
///
///     y(t + h) = Σ_{k≤p} c_k h^k          c_k = y^(k)(t)/k!
///
/// The last terms tell the error of order p − 1: |c_p| h^p, and, as every other coefficient may vanish by
/// symmetry, a quarter of |c_{p−1}| h^{p−1}; both are taken twenty times, which makes steps a tenth shorter,
/// and runs as exact for a tolerance as those of the other methods, whose estimates say too much as well. So
/// it is known for every h before a step is made, and each is as long as it may be; one that has to be
/// shorter takes no new series. Integrals along the way are taken by Gauss's rule. Source: Jorba and Zou, see
/// motion_series.h.

#include <vector>

#include "ode/stepper.h"

namespace planar_chain::simd {
struct VectorKernel;
}

namespace planar_chain::ode {

class Taylor : public Stepper {
 public:
  /// f must outlive the stepper.
  Taylor(SeriesSystem& f, double tolerance);

  const char* name() const override { return "taylor"; }
  int order() const override { return order_; }
  int errorOrder() const override { return order_ - 1; }

  /// Of the last try.
  double cost() const override { return cost_; }
  double stabilityLimit() const override { return stabilityLimit_; }
  System& system() override { return f_; }
  const Vector& derivative(double t, const Vector& y) override;
  bool foresees(double t, double h, const Vector& y) override;
  void step(double t, double h, const Vector& y) override;
  void stepAgain(double t, double h, const Vector& y) override;
  const Vector& increment() const override { return increment_; }
  const Vector& error() const override { return error_; }
  void accept() override { forget(); }
  void forget() override { isKnown_ = false; }

 private:
  void findSeries(double t, const Vector& y);
  void findError(double h);
  void findIncrement(double t, double h);

  SeriesSystem& f_;
  const simd::VectorKernel& vectors_;
  int order_;
  double stabilityLimit_, cost_;
  Eigen::VectorXd nodes_, weights_;  ///< of Gauss's rule on [0, 1]
  std::vector<double> c_;
  Vector y_, sum_, integrandRates_;  ///< in the order of the series
  Vector increment_, error_, derivative_;
  bool isKnown_ = false;
};

}  // namespace planar_chain::ode
