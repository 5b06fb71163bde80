#pragma once

/// Watches the energy balance: what no error estimate of a step can see, energy made or lost by the method
/// itself, opens a gap in
///
///     T + V = (T + V before) + W_s − W_d
///
/// Gaps of about the last second are added up; they are no sign of trouble while what the tolerance allows
/// explains them. Angles off by ε and rates off by ε (1 + max|ω|) move the energy by at most
///
///     2 √(T T_ε) + T_ε + 2 √(V_e V_ε) + V_ε + ε Σ m |g| ρ     T_ε: kinetic energy of that rate error at
///     worst
///
/// with V_e the elastic energy, V_ε = 2 ε² Σ k, ρ_j = |r_j| + Σ_{k<j} |p_k| the farthest that body j can be
/// from the ground; ε = 10 tolerances and what rounding does. To this comes a share of the energy that moves:
/// a thousand tolerances; a tenth for methods of fixed step, which promise no tolerance.

#include "dynamics/stored_energy.h"
#include "ode/system.h"
#include "planar_chain/scene.h"

namespace planar_chain {

class EnergyGuard {
 public:
  /// The chain must outlive this object; works: the components of y behind angles and rates, 0 or 2.
  EnergyGuard(const Chain& chain, const IntegratorSettings& settings, int works);

  /// The balance starts at this state; y: it in the order of the chain.
  void begin(const ode::State& state, const double* y);
  /// True when the balance from the last good state to this one closes; it is the last good one from then on.
  /// Allocates nothing.
  bool closes(const ode::State& state, const double* y);
  const ode::State& lastGood() const { return good_; }
  /// What was too much (or missing, if negative) when the balance last did not close, J.
  double gap() const { return refused_; }

 private:
  struct Works {
    double in = 0, out = 0;
  };
  Works worksOf(const double* y) const;
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
  Works worksThen_;
  double gap_ = 0, moved_ = 0;  ///< of about the last second
  double refused_ = 0;
};

}  // namespace planar_chain
