#pragma once

/// Checks the energy balance. A method that makes or loses energy opens a gap that no error estimate of a
/// step shows:
///
///     gap = T + V − (T + V before) − W_s + W_d
///
/// Gaps of about the last second are added up. A gap is accepted while the tolerance explains it. Angles off
/// by ε and rates off by ε (1 + max|ω|) change the energy by at most
///
///     2 √(T T_ε) + T_ε + 2 √(V_e V_ε) + V_ε + ε Σ m |g| ρ
///
///     T_ε         kinetic energy of that rate error, at worst
///     V_e, V_ε    elastic energy; 2 ε² Σ k
///     ρ_j         |r_j| + Σ_{k<j} |p_k|, the farthest that body j can be from the ground
///     ε           10 tolerances, and rounding
///
/// A share of the energy that moves is allowed besides: a thousand tolerances. Methods of fixed step promise
/// no tolerance; for them the share is a tenth.

#include "dynamics/stored_energy.h"
#include "ode/system.h"
#include "planar_chain/scene.h"

namespace planar_chain {

class EnergyGuard {
 public:
  /// works: how many components of y stand behind angles and rates, 0 or 2. The chain must outlive this
  /// object.
  EnergyGuard(const Chain& chain, const IntegratorSettings& settings, int works);

  /// Starts the balance at this state. y: the same state in chain order.
  void begin(const ode::State& state, const double* y);
  /// Returns true if the balance closes from the last good state to this one, which then is the last good
  /// state. Allocates nothing.
  bool accept(const ode::State& state, const double* y);
  /// The energy of a state in chain order. Allocates nothing.
  Energy energyAt(const double* y) const { return energyOf(chain_, kinds_, y, y + n_); }
  const ode::State& lastGood() const { return good_; }
  /// The last good state, of the same energy and motion, but with other angles.
  void moveTo(const ode::State& state) { good_ = state; }
  /// The gap that was last refused, J: positive if there was too much energy.
  double gap() const { return refused_; }

 private:
  /// W_s and W_d.
  Eigen::Vector2d worksOf(const double* y) const;
  double errorEnergy(double t, const double* y, const Energy& now) const;

  const Chain& chain_;
  std::vector<const EffectKind*> kinds_;  ///< that store energy
  int n_, works_;
  double tolerance_;      ///< ε without rounding; 0 for fixed steps
  double share_;          ///< of the energy that moves
  double inertia_ = 0;    ///< Σ m ρ² + I
  double stiffness_ = 0;  ///< Σ k
  double weight_ = 0;     ///< Σ m |g| ρ
  ode::State good_;
  Energy energyThen_;
  Eigen::Vector2d worksThen_;
  double gap_ = 0, moved_ = 0;  ///< of about the last second
  double refused_ = 0;
};

}  // namespace planar_chain
