#pragma once

/// Rosenbrock methods: linearly implicit Runge–Kutta methods. One factorization a step, no iteration.
///
/// In the form that needs no product with J (Hairer, Wanner, Solving ODEs II, section IV.7), with J = ∂f/∂y
/// and f_t = ∂f/∂t at (t, y):
///
///     (1/(hγ) − J) U_i = f(t + c_i h, y + Σ a_ij U_j) + Σ (C_ij/h) U_j + d_i h f_t
///     y(t + h) ≈ y + Σ m_i U_i          error ≈ Σ e_i U_i

#include <limits>
#include <vector>

#include "ode/combination.h"
#include "ode/stepper.h"
#include "simd/cache_lines.h"

namespace planar_chain::ode {

struct RosenbrockTableau {
  const char* name;
  const char* source;
  int order;
  int errorOrder;
  double gamma;
  std::vector<double> c, d;               ///< one a stage
  std::vector<std::vector<double>> a, C;  ///< row i has i entries
  std::vector<double> m, e;
};

/// Steinebach's Rodas5P: order 5(4), stiffly accurate, L-stable.
const RosenbrockTableau& rodas5p();
/// Rang and Angermann's ROS34PW2: order 3(2), stiffly accurate, L-stable.
const RosenbrockTableau& ros34pw2();

class Rosenbrock : public Stepper {
 public:
  /// f must outlive the stepper; the table is copied. Allocates.
  /// @throws std::invalid_argument for a table of more than eight stages.
  Rosenbrock(const RosenbrockTableau& table, LinearizedSystem& f);

  const char* name() const override { return table_.name; }
  int order() const override { return table_.order; }
  int errorOrder() const override { return table_.errorOrder; }

  double cost() const override;
  double stabilityLimit() const override { return std::numeric_limits<double>::infinity(); }
  System& system() override { return f_; }
  const Vector& derivative(double t, const Vector& y) override;
  void step(double t, double h, const Vector& y) override;
  const Vector& increment() const override { return increment_; }
  const Vector& error() const override { return error_; }
  void accept() override { forget(); }
  void forget() override { linearized_ = false; }

 private:
  void linearize(double t, const Vector& y);
  void findSide(std::size_t i, double t, double h, const double* y);

  RosenbrockTableau table_;
  LinearizedSystem& f_;
  CacheRows rows_;
  std::vector<double*> U_;                                ///< these
  std::vector<TwoCombinations> positionSums_, rateSums_;  ///< of a stage: Σ a_ij U_j and Σ C_ij U_j
  Combination m_, e_;
  Vector startSlope_, timeSlope_;  ///< f where the step starts; ∂f/∂t
  Vector stage_, rates_;           ///< y of a stage, and f but for the positions'
  Vector increment_, error_;
  bool linearized_ = false;
  bool timeDependent_ = false;
};

}  // namespace planar_chain::ode
