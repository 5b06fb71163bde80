#pragma once

/// Radau IIA of order 13: an implicit Runge–Kutta method, L-stable. See radau_table.h for its numbers.
///
/// With Z_i = Y_i − y the stages solve (Hairer, Wanner, Solving ODEs II, section IV.8)
///
///     R_i = f(t + c_i h, y + Z_i) − Σ_j W_ij Z_j / h = 0          W = A⁻¹ = T Λ T⁻¹
///
/// by simplified Newton, J = ∂f/∂y at (t, y): with one factorization for the real λ and one for each complex
/// pair μ,
///
///     (λ/h − J) ζ = T⁻¹ R      Z ← Z + T ζ
///
/// from the polynomial of the last step. Then y(t + h) ≈ y + Z_7, and as y + Z_7 less an
/// embedded solution of order 7 the error is
///
///     (λ/h − J)⁻¹ (f(t, y) + λ/h Σ e_i Z_i)
///
/// This error includes a stiff component in full, though the step damps it. If the error is too large for a
/// step, but no larger than the tolerance itself, it is computed once more with f(t, y + error) for f(t, y).
/// Then the stiff component vanishes from the error as it does from the solution.

#include <complex>
#include <memory>
#include <vector>

#include "ode/allowance.h"
#include "ode/radau_table.h"
#include "ode/stepper.h"

namespace planar_chain::ode {

class Radau : public ImplicitStepper {
 public:
  /// f must outlive the stepper. tolerance and stiffness are those of the error control: the stages need only
  /// be as exact as the step. If the stages are not found, increment() is NaN and error() halves the step.
  /// Allocates.
  Radau(LinearizedSystem& f, Tolerance tolerance, std::shared_ptr<const LocalStiffness> stiffness);

  /// Of the last attempt.
  double cost() const override;
  void step(double t, double h, const Vector& y) override;
  void accept() override;
  void forget() override;

 private:
  static constexpr int stages = RadauTable::stages;
  using Stages = Eigen::Matrix<double, Eigen::Dynamic, stages>;  ///< a column a stage
  enum class Newton { converged, failed, notFinite };

  void carryOn(double h);
  Newton solveStages(double t, double h, const Vector& y);
  void improve(double t, double h, const Vector& y);
  void estimate(double t, double h, const Vector& y);
  double largest(const Vector& perUnit) const;

  const RadauTable& table_;
  Tolerance tolerance_;
  std::shared_ptr<const LocalStiffness> stiffness_;
  Vector stage_, combined_;
  Stages Z_, last_, R_, change_;
  std::vector<std::complex<double>> pair_;
  Eigen::ArrayXd allowed_, mayVanish_;
  Vector perExactEnough_, perLost_;  ///< 1 over it
  double hTried_ = 0, hLast_ = 0;
  double rate_ = 1;  ///< θ/(1 − θ) of the last iteration, θ: by how much it shrank the change
  int iterations_ = 4;
};

}  // namespace planar_chain::ode
