#pragma once

/// The springs and dampers of the joints. On the outer body of joint i, and backwards on the inner one, acts
///
///     τ_i = −k_i (q_i − q0_i) − d_i q̇_i                q_i = θ_i − θ_{i−1}
///
/// Flat arrays from the first joint that has either to the last one; with 0 for what is missing between.

#include <vector>

#include "planar_chain/chain.h"

namespace planar_chain {

class Springs {
 public:
  explicit Springs(const Chain& chain);

  bool empty() const { return k_.empty(); }
  /// Whether there is a damper.
  bool dissipate() const { return !d_.empty(); }

  /// Adds τ_i − τ_{i+1} to N_i (N m, n of them); returns Σ d q̇², W. Allocates nothing.
  double apply(const double* theta, const double* omega, double* N);
  /// Adds τ_i to tau_i, n of them.
  void addTorques(const double* theta, const double* omega, double* tau);
  /// Adds k_i and d_i to those of each joint, n of them.
  void addStiffness(double* k, double* d) const;
  /// How Σ d q̇² changes with ω along v.
  double dissipationAlong(const double* omega, const double* v) const;

 private:
  /// To torque_; returns Σ d q̇².
  double findTorques(const double* theta, const double* omega);
  std::size_t size() const { return k_.size(); }

  std::size_t first_ = 0;
  std::vector<double> k_, rest_, d_, torque_;
};

}  // namespace planar_chain
