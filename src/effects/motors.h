#pragma once

/// Motors: what becomes of the torques that are commanded in a joint.
///
///     commands, after their dead time → sum u, cut off at ± L → lag → x → torque–speed line → torque τ
///
///     T ẋ = u − x                 x(t) = u + (x_0 − u) exp(−(t − t_0)/T)      t_0: the last change of u
///     |τ| ≤ L (1 − s q̇/ω_0)       s = sign x                                  L: effort_limit
///                                                                             ω_0: no_load_speed
///
/// u is constant from one command to the next, so x is exact. The line comes last. It is a function of q̇
/// alone and leaves x as it is. With m = s x ≥ 0 and l = L (1 − s q̇/ω_0), a motor is
///
///     free      m < l            τ = x
///     on the line      0 < l < m        τ = s l = s L − (L/ω_0) q̇: a damper
///     idle      l < 0, m > 0     τ = 0: faster than ω_0 it does not drive, and does not brake
///
/// Where it brakes, s q̇ < 0, the line is above L, and the cut off of u holds: |τ| ≤ L. τ is continuous. It
/// has a corner at each change, where the integrator lands (ode/events.h).
///
/// x is part of the state of a simulation: 0 at the start and after a reset. It stays if q and q̇ are set.

#include <memory>

#include "effects/commands.h"

namespace planar_chain {

/// Keys of a joint; the first two stand in the map `motor`.
inline constexpr const char* noLoadSpeed = "motor/no_load_speed";
inline constexpr const char* timeConstant = "motor/time_constant";

/// True if the joint has a motor or a dead time: a linear model has neither.
bool changesCommands(const Joint& joint);

/// The effect of commands in this chain; nullptr if there may be none.
std::unique_ptr<CommandEffect> makeCommands(const Chain& chain, int capacity);

/// Returns the joints with motors, and those whose torque is cut off, after tau (n, N m) has been commanded
/// for long. omega: the rates ω, in chain order. Allocates.
std::vector<LinearMotor> steadyMotors(const Chain& chain, const double* tau, const double* omega);

/// Keys `motor` and `command_delay` of a joint.
const EffectKind& motorKind();

}  // namespace planar_chain
