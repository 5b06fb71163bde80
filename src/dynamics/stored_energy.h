#pragma once

/// energyOf() of energy.h for those who ask often: which kinds of effect store energy in a chain is found
/// once.

#include <vector>

#include "effects/effect_kind.h"
#include "planar_chain/energy.h"

namespace planar_chain {

/// The kinds that store energy in one of the chain's joints or bodies. Allocates.
std::vector<const EffectKind*> storingKinds(const Chain& chain);

/// As energyOf(), of the chain that `kinds` were found for, without rotors. Allocates nothing.
Energy energyOf(const Chain& chain, const std::vector<const EffectKind*>& kinds, const double* theta,
                const double* omega, const BaseState& base = {});

}  // namespace planar_chain
