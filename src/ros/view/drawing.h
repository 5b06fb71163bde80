#pragma once

/// How large a scene is drawn: its bodies in the URDF, and what acts on them in markers.

#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain {

struct Drawing {
  explicit Drawing(const Scene& scene);

  double reach;   ///< m: no point of the chain comes farther from the ground pin
  double unit;    ///< m: mean length of a link; where links are many and short, an eighth of the reach
  double bar;     ///< m: width of a link
  double force;   ///< N, drawn one half unit long: the weight; without gravity, the largest load
  double torque;  ///< N m: that force on half the reach

  /// From an arrow's tail to its head, m: in proportion, but never longer than one unit and a half.
  Vec2d arrow(Vec2d f) const;
};

/// A straight part of a body, in its link's axes, m.
struct Bar {
  Vec2d from, to;
  double share = 1;  ///< of the full width
};

/// A body as bars. Thin from pin to pin. Thick where the mass is: the uniform rod that has the body's mass,
/// centre of mass and moment of inertia, where it lies along the pins; else arms from both pins to the centre
/// of mass.
std::vector<Bar> barsOf(const Link& link, const Drawing& drawing);
/// Whether it is about as short as it is wide: one of many, drawn as a plain bar without its pin.
bool isShort(const Link& link, const Drawing& drawing);
/// Whether all mass is drawn at one point, a bob.
bool isPoint(const Link& link, const Drawing& drawing);

}  // namespace planar_chain
