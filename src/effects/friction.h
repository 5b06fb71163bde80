#pragma once

/// Dry friction in joints, without smoothing.
///
///     slips     μ = −c sign(q̇)                  P_d = c |q̇|
///     sticks    q̈ = 0, |μ| ≤ breakaway torque   P_d = 0
///
/// A joint that sticks is prescribed (recursion/general.h), so μ comes out, and its angle keeps every bit.
/// The integrator lands where q̇ of a slipping joint passes 0, and where μ of a stuck one passes its breakaway
/// torque.
///
/// Three parts: stick_slip.h is the state machine, complementarity.h decides which of several joints at rest
/// stick, and friction_events.h has the event functions.
///
/// A joint that comes to rest with |q̈| = a reverses without sticking if a > 2 c Y, where Y = ∂q̈/∂μ. Y is
/// known from the last time that it came to rest. If it has changed so much that the joint does stick, the
/// next round corrects this.

#include "effects/effect_kind.h"

namespace planar_chain {

/// Keys `friction` and `breakaway` of a joint.
const EffectKind& frictionKind();

}  // namespace planar_chain
