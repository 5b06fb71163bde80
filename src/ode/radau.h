#pragma once

/// Radau IIA of order 13: an implicit Runge–Kutta method, L-stable.
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

#include "ode/local_stiffness.h"
#include "ode/stepper.h"

namespace planar_chain::ode {

/// The numbers of Radau IIA with seven stages: collocation at the zeros c of P_7 − P_6 (Legendre, on [0, 1]),
/// the last of which is 1 (the same, sections IV.5 and IV.8).
struct RadauTable {
  static constexpr int stages = 7;
  static constexpr int pairs = 3;
  using PerStage = Eigen::Matrix<double, stages, 1>;
  using Square = Eigen::Matrix<double, stages, stages>;

  PerStage c;
  Square A;  ///< a_ij = ∫₀^{c_i} l_j, l_j of Lagrange; the last row is b
  Square W;  ///< A⁻¹
  /// W = T Λ T⁻¹ in real numbers: Λ has lambda, then a block [α −β; β α] for each mu = α + iβ.
  Square T, inverseT;
  double lambda;
  std::complex<double> mu[pairs];
  /// The error λ h⁻¹-filtered: f(t, y)/λ h + Σ e_i Z_i vanishes for polynomials up to degree 7.
  PerStage e;
  /// The polynomial through 0 at 0 and Z_j at c_j is Σ_j x Π_{m≠j} (x − c_m) p_j Z_j.
  PerStage p;
};

const RadauTable& radau13();

class Radau : public ImplicitStepper {
 public:
  /// f must outlive the stepper. tolerance and stiffness are those of the error control: the stages need only
  /// be as exact as the step. If the stages are not found, increment() is NaN and error() halves the step.
  /// Allocates.
  Radau(LinearizedSystem& f, Tolerance tolerance, std::shared_ptr<const LocalStiffness> stiffness);

  /// The cost of the last attempt.
  double cost() const override {
    constexpr double sums = 1;  // of all stages, in evaluations
    const LinearCosts linear = f_.linearCosts();
    const double once = linear.factor + RadauTable::pairs * linear.factorComplex + linear.solve;
    const double iteration = stages + linear.solve + RadauTable::pairs * linear.solveComplex + sums;
    return once + iterations_ * iteration;
  }
  void step(double t, double h, const Vector& y) override;
  void setTolerance(const Tolerance& tolerance) override { tolerance_ = tolerance; }
  void accept() override {
    last_.swap(Z_);
    hLast_ = hTried_;
    ImplicitStepper::accept();
  }
  void forget() override {
    hLast_ = 0;
    rate_ = 1;
    ImplicitStepper::forget();
  }
  void saveOrRestore(Snapshot& snapshot) override {
    ImplicitStepper::saveOrRestore(snapshot);
    snapshot(hLast_, rate_, iterations_);
    if (hLast_ > 0) snapshot.block(last_.data(), static_cast<std::size_t>(last_.size()));
  }

 private:
  static constexpr int stages = RadauTable::stages;
  using Stages = Eigen::Matrix<double, Eigen::Dynamic, stages>;  ///< a column a stage

  void multiply(const Stages& x, const RadauTable::Square& weights, const Stages* base, Stages& sums) const;
  void carryOn(double h);
  double solveStages(double t, double h, const Vector& y);
  void improve(double t, double h, const Vector& y);
  void estimate(double t, double h, const Vector& y);
  /// The largest change of any component of any stage, times perUnit.
  double largest(const Vector& perUnit) const {
    return (change_.array().abs().colwise() * perUnit.array()).maxCoeff();
  }

  const RadauTable& table_ = radau13();
  Tolerance tolerance_;
  std::shared_ptr<const LocalStiffness> stiffness_;
  Vector stage_ = startSlope_, combined_ = startSlope_;
  Stages Z_ = Stages::Zero(startSlope_.size(), stages), last_ = Z_, R_ = Z_, change_ = Z_;
  Eigen::VectorXcd pair_ = Eigen::VectorXcd::Zero(startSlope_.size());
  Eigen::ArrayXd allowed_ = Eigen::ArrayXd::Zero(tolerance_.ceiling.size()), mayVanish_ = allowed_;
  Vector perExactEnough_ = startSlope_, perLost_ = startSlope_;  ///< 1 over it
  double hTried_ = 0, hLast_ = 0;
  double rate_ = 1;  ///< θ/(1 − θ) of the second iteration, θ: by how much it shrank the change
  int iterations_ = 4;
};

}  // namespace planar_chain::ode
