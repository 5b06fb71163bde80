#pragma once

/// energyOf() of energy.h for those who ask often: which kinds of effect store energy in a chain is found
/// once.

#include <vector>

#include "effects/effect_kind.h"
#include "planar_chain/energy.h"

namespace planar_chain {

/// The kinds that store energy in one of the chain's joints. Allocates.
std::vector<const EffectKind*> storingKinds(const Chain& chain);

/// The base: position (m) and velocity (m/s) of the ground pin, and what θ and ω are measured from.
struct BaseState {
  Vec2d pin, velocity;
  double angle = 0, rate = 0;
};

/// As energyOf(), of the chain that `kinds` were found for, without rotors. Allocates nothing.
Energy energyOf(const Chain& chain, const std::vector<const EffectKind*>& kinds, const double* theta,
                const double* omega, const BaseState& base = {});

}  // namespace planar_chain
