#pragma once

/// The condition that a held tip puts on a state, and the projection onto it.
///
///     c_j·(x_T(t) − x_tip) = 0            c_j·(ẋ_T(t) − ẋ_tip) = 0            rows c_j: tip_constraint.h
///
/// A gap is closed by the motion of least kinetic energy that moves the tip so far: that of an
/// impulse on the tip of the chain at rest. For positions this is Newton's method in the metric of the
/// mass matrix, for rates it is exact. Each iteration is one sweep, O(n). Prescribed joints stay where they
/// are.
///
/// Source: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, section IV.4: a step that ends
/// with a projection keeps its order.

#include <vector>

#include "dynamics/mechanism.h"
#include "effects/joint_constraint.h"
#include "lanes/general_chain.h"

namespace planar_chain {

/// Only the constructor allocates.
class Closure {
 public:
  /// The share of the size below which a gap is closed, at angles below some hundred radians.
  static constexpr double closed = 1e-13;

  /// The mechanism must outlive this object.
  explicit Closure(const Mechanism& mechanism);

  /// The gap along the rows: of the position, m, and of the velocity, m/s. y = [ψ ψ̇] in chain order.
  Vec2d gap(const Couplings& at, const double* y);
  Vec2d rateGap(const Couplings& at, const double* y);
  /// Moves a state onto the condition. `change` has room for n numbers more than y: it is added to y with the
  /// rounding errors `carry`, which may be nullptr (Kahan). Returns false if the gap stays: y is as near as
  /// it came.
  bool project(const Couplings& at, double* y, double* carry);
  /// How near the chain is to a pose, stretched between its ends, in which a force on the tip does not move
  /// it: the smaller eigenvalue of the tip's answer to forces over the larger one. Of one row it is the
  /// answer along it over the larger eigenvalue.
  double spread(const Couplings& at, const double* y);
  /// spread() where the last project() ended.
  double lastSpread(const Couplings& at) const;
  /// The length that gaps are compared with: the reach and the position of the tip, m.
  double sizeAt(const Couplings& at) const;

 private:
  void couple(const Couplings& at);
  void pose(const Couplings& at, const double* y);
  PointAt<double> tip(const Couplings& at, const double* y);
  Vec2d alongRows(const Couplings& at, Vec2d a) const;
  void move(const Couplings& at, Vec2d tip, double most, double* values, double* carry);
  TipReaction<double> impulse(Tip<double> tip);
  double leastGap(const double* y) const;
  bool close(const Couplings& at, double* y, double* carry);

  const Mechanism& mechanism_;
  const int n_;
  const double reach_;
  GeneralChain recursion_;
  std::vector<JointLaw<double>> laws_;  ///< as they are, at rest
  std::vector<Rotation<double>> e_;
  std::vector<Displacement<double>> displaced_;  ///< at rest
  std::vector<double> omega_, change_, none_, moments_;
  Sym2<double> answer_;  ///< of the tip to forces, where the last impulse was
};

}  // namespace planar_chain
