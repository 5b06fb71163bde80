#pragma once

/// Sizes and shapes of a drawn scene, for the URDF and for the markers.

#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain {

struct Drawing {
  explicit Drawing(const Scene& scene);

  double reach;   ///< m: the largest possible distance from the ground pin
  double unit;    ///< m: the mean length of a link, at least an eighth of the reach
  double bar;     ///< m: the width of a link
  double force;   ///< N: drawn half a unit long. The chain's weight; without gravity, the largest load
  double torque;  ///< N m: `force` at half the reach

  /// Returns the arrow of a force f (N), in m: proportional to it, but at most 1.5 units long. An arrow that
  /// starts within reach, at `from` in the base frame, ends at most 1.2 reaches from the ground pin: in view.
  Vec2d arrow(Vec2d f, Vec2d from) const;
};

/// A straight part of a body, in the link frame, m.
struct Bar {
  Vec2d from, to;
  double share = 1;  ///< of the full width
};

/// Returns a body as bars. A thin one joins the pins. A thick one shows the mass: the uniform rod with the
/// body's mass, centre of mass and moment of inertia, if the centre of mass is in line with the pins. Else
/// two thick bars join the pins to the centre of mass.
std::vector<Bar> barsOf(const Link& link, const Drawing& drawing);
/// True if the link is about as short as it is wide. It is drawn as one bar without a pin.
bool isShort(const Link& link, const Drawing& drawing);
/// True if the mass is drawn as a bob at one point.
bool isPoint(const Link& link, const Drawing& drawing);

}  // namespace planar_chain
