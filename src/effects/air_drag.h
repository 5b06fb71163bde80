#pragma once

/// Air drag of a link: a force against the velocity v of one of its points, which air at rest brakes,
///
///     F = −c |v| v        F_v = −c (|v| + v vᵀ/|v|), 0 at v = 0        power taken: c |v|³
///
/// c = ½ ρ c_d A: density of the air, drag coefficient, area.

#include "effects/effect_kind.h"

namespace planar_chain {

/// c, N s²/m², 0 if there is no drag; and the point, link frame.
struct AirDrag {
  double coefficient;
  Vec2d point;
};
AirDrag airDragOf(const Link& link);

/// The key `drag` of links. Link::others has its value as `drag`, and its point as `drag/point/0` and
/// `drag/point/1`; without them the point is the centre of mass.
const EffectKind& airDragKind();

}  // namespace planar_chain
