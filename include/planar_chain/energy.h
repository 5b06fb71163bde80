#pragma once

/// Energy and momentum of a chain: T = ½ Σ m|v|² + I ω², V = −Σ m g·x + ½ Σ k (q − q0)² + what the
/// stops hold (stops.h).

#include <vector>

#include "planar_chain/chain.h"

namespace planar_chain {

struct Energy {
  double kinetic = 0;  ///< T, J
  double potential =
      0;  ///< V, J: gravity (zero where a centre of mass is level with the ground pin) and springs
  double elastic = 0;  ///< the part of V that springs and stops hold, J
  double total() const { return kinetic + potential; }
};

/// theta, omega: absolute angles (rad) and angular velocities (rad/s), n each. Allocates nothing.
Energy energyOf(const Chain& chain, const double* theta, const double* omega);

/// Σ m x×v + I ω about the ground pin, kg m²/s. Allocates nothing.
double angularMomentum(const Chain& chain, const double* theta, const double* omega);

}  // namespace planar_chain
