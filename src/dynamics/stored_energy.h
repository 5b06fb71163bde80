#pragma once

/// energyOf() of energy.h for those who ask often: what stores energy in a chain is found once.

#include <vector>

#include "effects/effect_kind.h"
#include "planar_chain/energy.h"

namespace planar_chain {

struct Stores {
  /// Allocates.
  explicit Stores(const Chain& chain);

  std::vector<const EffectKind*> kinds;  ///< that store energy in one of the joints or bodies
  std::vector<double> rotors;            ///< J of the joints, kg m²; empty: none
};

/// As energyOf(), of the chain that `stores` was made for. Allocates nothing.
Energy energyOf(const Chain& chain, const Stores& stores, const double* theta, const double* omega,
                const BaseState& base = {});

/// The value of q near which springs and stops of a joint alone have least energy, searched from q as far as
/// their torque is more than `acting`, N m.
double leastStored(const Stores& stores, const Joint& joint, double q, double acting);

}  // namespace planar_chain
