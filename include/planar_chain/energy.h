#pragma once

/// Energy and momentum of a chain:
///
///     T = ½ Σ m |v|² + I ω² + J q̇²   V = −Σ m g·x + V_e     V_e = ½ Σ k (q − q0)² + ½ Σ k_stop x²
///     L = Σ m x×v + I ω
///
/// x, v: position and velocity of a centre of mass; x of a stop: how deep the joint is in it
/// (effects/stops.h); J: of a joint's rotor.

#include "planar_chain/chain.h"

namespace planar_chain {

struct Energy {
  double kinetic = 0;  ///< T, J
  /// V, J. A body whose centre of mass is level with the ground pin adds no energy of gravity.
  double potential = 0;
  double elastic = 0;  ///< V_e, J: the part of V that springs and stops store
  double total() const { return kinetic + potential; }
};

/// Returns the energy at the absolute angles theta (rad) and angular velocities omega (rad/s), n each.
/// Allocates a little.
Energy energyOf(const Chain& chain, const double* theta, const double* omega);

/// Returns L about the ground pin, kg m²/s. Allocates nothing.
double angularMomentum(const Chain& chain, const double* theta, const double* omega);

}  // namespace planar_chain
