#pragma once

/// The numbers of Radau IIA with seven stages, order 13: collocation at the zeros c of P_7 − P_6 (Legendre,
/// on [0, 1]), the last of which is 1 (Hairer, Wanner, Solving ODEs II, sections IV.5 and IV.8).

#include <Eigen/Core>
#include <array>
#include <complex>

namespace planar_chain::ode {

struct RadauTable {
  static constexpr int stages = 7;
  static constexpr int pairs = 3;
  using Vector = Eigen::Matrix<double, stages, 1>;
  using Square = Eigen::Matrix<double, stages, stages>;

  Vector c;
  Square A;  ///< a_ij = ∫₀^{c_i} l_j, l_j of Lagrange; the last row is b
  Square W;  ///< A⁻¹
  /// W = T Λ T⁻¹ in real numbers: Λ has lambda, then a block [α −β; β α] for each mu = α + iβ.
  Square T, inverseT;
  double lambda;
  std::array<std::complex<double>, pairs> mu;
  /// The error λ h⁻¹-filtered: f(t, y)/λ h + Σ e_i Z_i vanishes for polynomials up to degree 7.
  Vector e;
  /// The polynomial through 0 at 0 and Z_j at c_j is Σ_j x Π_{m≠j} (x − c_m) p_j Z_j.
  Vector p;
};

const RadauTable& radau13();

}  // namespace planar_chain::ode
