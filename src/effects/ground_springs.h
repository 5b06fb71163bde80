#pragma once

/// Springs with dampers from a point of a link to a point x_0 of the ground. With the length L, the direction
/// u = (x − x_0)/L of the spring, and its pull S,
///
///     F = −S u     S = k (L − L_0) + d L̇     L̇ = u·v          V = ½ k (L − L_0)²     power taken: d L̇²
///
///     F_x = −u (k u + (d/L) w)ᵀ − (S/L)(1 − u uᵀ)     w = v − L̇ u          F_v = −d u uᵀ
///
/// At L = 0 there is no direction, and F = 0. A spring with L_0 = 0 needs none; its damper acts against all
/// of the velocity: F = −k (x − x_0) − d v.
///
/// A spring that goes slack, L_0 > 0, only pulls. As a stop (effects/stops.h) it is in one of three states:
///
///     slack      L ≤ L_0               F = 0, V = 0
///     pulls      L > L_0, S > 0        as above
///     relaxes    L > L_0, S ≤ 0        F = 0: V passes to the damper, whose power is −k (L − L_0) L̇

#include "effects/effect_kind.h"

namespace planar_chain {

/// The key `springs` of scenes: Link::springs.
const EffectKind& groundSpringKind();

/// How hard a spring pulls, N; negative: it pushes. v: the velocity of its point x.
double pullOf(const GroundSpring& spring, Vec2d x, Vec2d v);

}  // namespace planar_chain
