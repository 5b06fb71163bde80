#pragma once

/// Rosenbrock methods: linearly implicit Runge–Kutta methods. One factorization a step, no iteration.
///
/// In the form that needs no product with J (Hairer, Wanner, Solving ODEs II, section IV.7), with J = ∂f/∂y
/// and f_t = ∂f/∂t at (t, y):
///
///     (1/(hγ) − J) U_i = f(t + c_i h, y + Σ a_ij U_j) + Σ (C_ij/h) U_j + d_i h f_t
///     y(t + h) ≈ y + Σ m_i U_i          error ≈ Σ e_i U_i

#include <vector>

#include "ode/combination.h"
#include "ode/stepper.h"
#include "simd/cache_lines.h"

namespace planar_chain::ode {

struct RosenbrockTableau : MethodFacts {
  double gamma;
  std::vector<double> c, d;               ///< one a stage
  std::vector<std::vector<double>> a, C;  ///< row i has i entries
  std::vector<double> m, e;
};

/// Rodas5P: order 5(4), stiffly accurate, L-stable (G. Steinebach, BIT 63 (2023) 27, doi
/// 10.1007/s10543-023-00967-x).
const RosenbrockTableau& rodas5p();
/// ROS34PW2: order 3(2), stiffly accurate, L-stable (J. Rang, L. Angermann, BIT 45 (2005) 761-787).
const RosenbrockTableau& ros34pw2();

class Rosenbrock : public ImplicitStepper {
 public:
  /// The table and f must outlive the stepper. Allocates.
  /// @throws std::invalid_argument for a table of more than 13 stages.
  Rosenbrock(const RosenbrockTableau& table, LinearizedSystem& f);

  double cost() const override {
    const LinearCosts linear = f_.linearCosts();
    const auto stages = static_cast<double>(U_.size());
    return linear.factor + stages - 1 + stages * linear.solve;
  }
  void step(double t, double h, const Vector& y) override;

 private:
  const RosenbrockTableau& table_;
  CacheRows rows_;
  std::vector<double*> U_ = rows_.rows();
  std::vector<NystromRow> a_, C_;  ///< of a stage: Σ a_ij U_j and Σ C_ij U_j
  NystromRow m_, e_;
  Vector timeSlope_ = startSlope_;                    ///< ∂f/∂t where the step starts
  Vector stage_ = startSlope_, slope_ = startSlope_;  ///< y of a stage, and f there
};

}  // namespace planar_chain::ode
