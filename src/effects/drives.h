#pragma once

/// Joint constraints that a scene gives: rotors, driven joints, the motion of the base, the held tip.
///
///     rotor     T = ½ J q̇²                       drive    q = law(t), and the torque follows
///     base      pin at (x(t), y(t)); joint 1 measures its angle from angle(t)
///     tip       at (x(t), y(t)), or on a line; the force follows

#include "effects/effect_kind.h"

namespace planar_chain {

/// Key `rotor_inertia` of a joint.
const EffectKind& rotorKind();
/// Scene::drives.
const EffectKind& driveKind();
/// Scene::base.
const EffectKind& baseKind();
/// Scene::tip.
const EffectKind& tipKind();

}  // namespace planar_chain
