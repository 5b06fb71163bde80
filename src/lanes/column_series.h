#pragma once

/// The derivatives of a chain's motion as Taylor series, from that of the motion: columns u of relative
/// coordinates.
///
/// With e_j = exp(i θ_j), S_j = m_j r_j + p_j Σ m of the links behind, c_ij = p̄_i S_j for i < j, c_ji = c̄_ij,
/// J_j = I + m|r|² + |p|² Σ m behind, and the acceleration of gravity g, the motion obeys
///
///     J_i α_i + Im(ē_i Σ_{j≠i} c_ij F_j − ē_i S̄_i g) = N_i                F_j = ë_j
///
/// So do a first joint, or two, that slide along axes a: with e_i = −i, p_i = S_i = a_i times the mass
/// behind, F_i = s̈_i and J_i = that mass. Along a column, δe_j = i e_j δθ_j:
///
///     Σ_j M_ij ü_j + D_ij u̇_j + K_ij u_j = δN_i − δJ_i α_i − Im(ē_i Σ δc_ij F_j − ē_i δ(S̄_i g))
///
///     M_ij = Re(c_ij ē_i e_j)     D_ij = 2 Re(c_ij ē_i ė_j)     K_ij = Re(c_ij ē_i ë_j)
///     M_ii = J_i                  D_ii = 0                      K_ii = Re(ē_i S̄_i g) − Σ Re(c_ij ē_i F_j)
///
/// where K_ii of a joint that slides is 0. Sums over the joints behind turn rows and columns into those of
/// relative coordinates, where springs, dampers and rotors stand on the diagonals. As every term is a product
/// of known series with u, order k of the equation gives order k + 2 of u:
///
///     (k+1)(k+2) M_0 u_{k+2} = f_k − Σ_{m<k+2} (m(m−1) M_{k+2−m} + m D_{k+1−m} + K_{k−m}) u_m
///
/// Prescribed joints have ü = 0. Source: the rules for products of motion_series.h.

#include <Eigen/Core>
#include <vector>

#include "lanes/column_arrays.h"
#include "planar_chain/chain.h"
#include "simd/cache_lines.h"

namespace planar_chain {

class ColumnSeries {
 public:
  using Terms = simd::ColumnArrays::Terms;

  /// True if such a chain has these series here: it is short, and no joint behind a revolute one slides.
  static bool areFor(const Chain& chain);
  /// The numbers of a chain in the equation; those of its joints are 0.
  static Eigen::VectorXd termsOf(const Chain& chain);

  /// `order`: of the motion. `numbers` of the columns, the last ones, are by numbers of the chain. Allocates;
  /// nothing else does.
  ColumnSeries(const Chain& chain, int order, int columns, int numbers, const simd::ColumnKernel& kernel);

  int order() const { return arrays_.order; }
  /// The terms of the joints.
  double* joint(int i) { return own_.data() + Terms::joint(i, arrays_.n); }
  /// How all terms change by a number.
  Eigen::Map<Eigen::VectorXd> change(int number);
  void setFree(int joint, bool isFree) { free_[index(joint)] = isFree ? 1 : 0; }
  /// What moves a column at all times.
  void setSource(int column, int joint, double torque);
  /// u of a column, at order 0 or 1: u or u̇.
  double& start(int order, int joint, int column) { return columns_[place(order, joint, column)]; }

  /// From the series c of the motion, as MotionSeries::find() writes it.
  void find(const double* c);
  /// Computes u and u̇ at h. Returns their error relative to the largest entry of the column.
  double evaluate(double h);
  /// The values of the last evaluate().
  double value(int order, int joint, int column) const { return values_[place(order, joint, column)]; }
  /// Begins there.
  void take();

 private:
  std::size_t place(int order, int joint, int column) const {
    return static_cast<std::size_t>((order * arrays_.n + joint) * arrays_.width + column);
  }
  double* series(int number) {
    return series_.data() + static_cast<std::ptrdiff_t>(number) * arrays_.apart + simd::ColumnArrays::before;
  }

  const simd::ColumnKernel& kernel_;
  simd::ColumnArrays arrays_;
  CacheLines own_, changes_, free_, inverses_, series_, inverse_, columns_, sources_, values_;
  std::vector<Rotation<double>> e_;
};

}  // namespace planar_chain
