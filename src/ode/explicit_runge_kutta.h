#pragma once

/// Explicit Runge–Kutta methods as data, and their steps.
///
///     k_i = f(t + c_i h, y + h Σ_j a_ij k_j)     y(t + h) ≈ y + h Σ b_i k_i     error ≈ h Σ e_i k_i

#include <vector>

#include "ode/combination.h"
#include "ode/stepper.h"
#include "simd/cache_lines.h"

namespace planar_chain::ode {

struct Tableau : MethodFacts {
  std::vector<double> c;               ///< one a stage
  std::vector<std::vector<double>> a;  ///< row i has i entries
  std::vector<double> b;
  std::vector<double> e;  ///< b minus the embedded weights; empty: no error estimate
  /// A second, coarser estimate ẽ; empty: none. With both, component by component, the error is
  /// e² / √(e² + 0.01 ẽ²): small where both agree that the step is fine.
  std::vector<double> coarse;
  bool lastIsFirst;  ///< the last stage is the first of the next step (FSAL)
};

/// W. Kutta's classical method (Hairer, Nørsett, Wanner, Solving ODEs I, table II.1.2).
const Tableau& rk4();
/// Dormand and Prince's 5(4) (the same, table II.5.2).
const Tableau& dopri5();
/// Dormand and Prince's 8(5,3) (the same, section II.5, the doubles nearest to dop853.f).
const Tableau& dop853();

class ExplicitRungeKutta : public Stepper {
 public:
  /// The table and f must outlive the stepper. Allocates.
  /// @throws std::invalid_argument for a table of more than 13 stages.
  ExplicitRungeKutta(const Tableau& table, System& f);

  double cost() const override { return static_cast<double>(table_.b.size()) - (table_.lastIsFirst ? 1 : 0); }
  const Vector& derivative(double t, const Vector& y) override;
  void step(double t, double h, const Vector& y) override;
  void accept() override;
  void forget() override { firstIsKnown_ = false; }
  void saveOrRestore(Snapshot& snapshot) override {
    snapshot(firstIsKnown_);
    if (firstIsKnown_) snapshot.block(k_.front(), static_cast<std::size_t>(rates_));
  }

 private:
  /// Shorter chains' sums are not slower with the rates of the stages (src/README.md).
  static constexpr Eigen::Index leastInNystromsForm = 64;

  void evaluateFirst(double t, const double* y) {
    if (!firstIsKnown_) evaluate(t, y, k_.front());
    firstIsKnown_ = true;
  }
  [[gnu::always_inline]] void evaluate(double t, const double* y, double* k) {
    slopesAreWhole_ ? system_.slope(t, y, k) : system_.rates(t, y, k);
  }

  const Tableau& table_;
  const Eigen::Index size_ = increment_.size();
  const Eigen::Index positions_ = system_.positions() < leastInNystromsForm ? 0 : system_.positions();
  const Eigen::Index rates_ = size_ - positions_;                 ///< the components of a slope
  const bool slopesAreWhole_ = system_.positions() > positions_;  ///< with the rates of positions
  CacheRows slopes_;
  std::vector<double*> k_ = slopes_.rows();  ///< one a stage
  std::vector<NystromRow> a_;
  NystromRow b_, e_, coarseRow_;
  Vector stage_ = increment_, coarse_ = increment_, slope_ = increment_;
  bool firstIsKnown_ = false;
};

}  // namespace planar_chain::ode
