#pragma once

/// What couples the accelerations of neighbours and is given: rotors, driven joints, the motion of the base.
///
///     rotor     T = ½ J q̇²                       drive    q = law(t), and the torque follows
///     base      pin at (x(t), y(t)); joint 1 measures its angle from angle(t)

#include "effects/effect_kind.h"

namespace planar_chain {

/// Key `rotor_inertia` of a joint.
const EffectKind& rotorKind();
/// Scene::drives.
const EffectKind& driveKind();
/// Scene::base.
const EffectKind& baseKind();

}  // namespace planar_chain
