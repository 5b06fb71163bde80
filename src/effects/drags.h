#pragma once

/// Drag in the joints, the example of src/README.md for an effect:
///
///     τ = −c |q̇| q̇        P_d = c |q̇|³        −∂τ/∂q̇ = 2 c |q̇|
///
/// |q̇| q̇ has a corner in its second derivative at q̇ = 0, so the drag is computed as s q̇², with s the sign of
/// q̇, and the integrator lands where the sign changes.

#include "effects/effect_kind.h"

namespace planar_chain {

/// Key `drag` of a joint: c, N m s²/rad², ≥ 0.
const EffectKind& dragKind();

}  // namespace planar_chain
