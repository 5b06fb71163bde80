#pragma once

/// The force that pulls a point of the chain to a place: a critically damped spring, whatever hangs on the
/// point.
///
/// A force F at a point X of a link adds Λ⁻¹ F to the acceleration of X. Along a unit vector u it acts on the
/// effective mass m_eff:
///
///     Λ⁻¹ = J M_q⁻¹ Jᵀ,   v_X = J q̇              1/m_eff = u·Λ⁻¹ u
///
/// The columns of Λ⁻¹ take O(n): they are the accelerations of X in the chain at rest without gravity, under
/// a force of 1 N along x and along y. A mass m on a spring m ω² with a damper 2 m ω comes to rest soonest
/// without overshoot. So, with d from X to the target,
///
///     F = Λ (ω² d − 2 ω v_X)                      adds ω² d − 2 ω v_X to the acceleration of X
///
/// Along an axis of Λ⁻¹ the effective mass may exceed that of the whole chain; along a taut chain it is
/// infinite. There the mass of the chain is used instead. So the force is bounded, and the damping is less
/// than critical.

#include <vector>

#include "lanes/coupled_chain.h"
#include "planar_chain/chain.h"

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
  /// The chain must outlive this object.
  explicit Pull(const Chain& chain);

  /// Returns the motion of a point of a link. q, qd: relative angles (rad) and rates (rad/s), n each; point:
  /// link frame, m. Allocates nothing.
  PointMotion motionOf(const double* q, const double* qd, int link, Vec2d point);

  /// Returns F on that point, N. pulsation: ω, rad/s, > 0.
  Vec2d force(const PointMotion& point, Vec2d target, double pulsation) const;

 private:
  Vec2d answer(int link, Vec2d force);

  const Chain& chain_;
  double mass_ = 0;  ///< of the chain, kg
  CoupledChain recursion_;
  std::vector<Coupling<double>> joints_;
  Vec2d arm_;  ///< from the link's inner pin to the point, base frame
  std::vector<Rotation<double>> e_;
  std::vector<double> theta_, omega_, still_, N_, alpha_, moments_;
  std::vector<Vec2d> F_;
};

}  // namespace planar_chain
