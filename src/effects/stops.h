#pragma once

/// Joint limits: one-sided spring-dampers, which push and never pull.
///
/// With x = q − upper at the upper limit and x = lower − q at the lower one (how deep the joint is in the
/// stop, if positive) and s = k x + d ẋ, a stop is
///
///     free       x < 0            no torque        V = 0          P_d = 0
///     pushing    x > 0, s > 0     s against x      V = ½ k x²     P_d = d ẋ²
///     parted     x > 0, s < 0     no torque        V = ½ k x²     P_d = −k x ẋ
///
/// Parted, the joint leaves faster than the stop follows, which relaxes into its own damper; so V depends on
/// the angle alone, P_d ≥ 0, and the energy balance closes. At each of these changes the torque has a corner,
/// and a jump where a damped stop is hit; the integrator lands there (ode/events.h), so that each step sees
/// one smooth f.

#include "effects/effect_kind.h"

namespace planar_chain {

/// Keys `lower`, `upper`, `stop_stiffness` and `stop_damping` of a joint.
const EffectKind& stopKind();

}  // namespace planar_chain
