#pragma once

/// A point of the chain drawn to a place, as by a hand: a spring that is critically damped, whatever hangs on
/// the point.
///
/// A force F at a point X of a link adds Λ⁻¹ F to the acceleration of X, and along a unit vector u it meets
/// the effective mass m_eff:
///
///     Λ⁻¹ = J M_q⁻¹ Jᵀ,   v_X = J q̇              1/m_eff = u·Λ⁻¹ u
///
/// The columns of Λ⁻¹ are found in O(n): accelerations of X, by the recursion of articulated.h, in the chain
/// at rest without gravity, under a force of 1 N along x and along y. A mass m on a spring m ω² with a damper
/// 2 m ω comes to rest soonest without going past. So with d from X to where it is drawn
///
///     F = Λ (ω² d − 2 ω v_X)                      adds ω² d − 2 ω v_X to the acceleration of X
///
/// Along the axes of Λ⁻¹ on which it meets more than the mass of the whole chain (a taut one along itself:
/// infinitely much), that mass stands in place of it: the force has a bound, the damping is less than
/// critical.

#include <vector>

#include "planar_chain/chain.h"
#include "recursion/articulated.h"

namespace planar_chain {

/// A point of a link in motion; base-frame components.
struct PointMotion {
  Vec2d position;           ///< m
  Vec2d velocity;           ///< m/s
  Rotation<double> turn;    ///< of the link
  Sym2<double> mobility{};  ///< Λ⁻¹, 1/kg
};

class Pull {
 public:
  /// The chain must outlive this.
  explicit Pull(const Chain& chain);

  /// q, qd: relative angles (rad) and rates (rad/s), n each; point: link frame, m. Allocates nothing.
  PointMotion motionOf(const double* q, const double* qd, int link, Vec2d point);

  /// F on that point, N. pulsation: ω, rad/s, > 0.
  Vec2d force(const PointMotion& point, Vec2d target, double pulsation) const;

 private:
  Vec2d answer(int link, Vec2d force);

  const Chain& chain_;
  double mass_ = 0;  ///< of the chain, kg
  Articulated<double> recursion_;
  Vec2d arm_;  ///< from the link's inner pin to the point, base frame
  std::vector<Rotation<double>> e_;
  std::vector<double> theta_, omega_, still_, N_, alpha_;
  std::vector<Vec2d> F_;
};

}  // namespace planar_chain
