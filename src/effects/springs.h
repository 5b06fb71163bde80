#pragma once

/// The springs and dampers of the joints. On the outer body of joint i, and backwards on the inner one, acts
///
///     τ_i = −k_i (q_i − q0_i) − d_i q̇_i                q_i = θ_i − θ_{i−1}
///
/// Flat arrays from the first joint that has either to the last one, with 0 for what is missing between; or
/// all numbers of a lane order, where the inner body stands a row before.

#include <vector>

#include "effects/effect_kind.h"
#include "lanes/lane_order.h"
#include "planar_chain/chain.h"

namespace planar_chain {

class Springs {
 public:
  /// All that comes and goes is in chain order, or in that of `lanes`.
  explicit Springs(const Chain& chain, const LaneOrder* lanes = nullptr);

  bool empty() const { return k_.empty(); }
  /// True if there is a damper.
  bool dissipate() const { return !d_.empty(); }

  /// Adds τ_i − τ_{i+1} to N_i (N m); returns Σ d q̇², W. Allocates nothing.
  double apply(const double* theta, const double* omega, double* N);
  /// Adds τ_i to tau_i.
  void addTorques(const double* theta, const double* omega, double* tau);
  /// Adds k_i and d_i to those of each joint.
  void addStiffness(double* k, double* d) const;
  /// Returns how Σ d q̇² changes with ω along v.
  double dissipationAlong(const double* omega, const double* v) const;

 private:
  /// To torque_; returns Σ d q̇².
  double findTorques(const double* theta, const double* omega);
  std::size_t size() const { return k_.size(); }
  template <class F>
  void forJoints(std::size_t count, F f) const;
  template <class Term>
  double sumOver(std::size_t count, Term term) const;

  std::size_t first_ = 0;
  std::size_t row_ = 1;  ///< from the inner body's number to that of the outer one
  std::vector<double> k_, rest_, d_, torque_;
};

/// Keys `stiffness`, `rest_angle` and `damping` of a joint.
const EffectKind& springKind();

}  // namespace planar_chain
