#pragma once

/// What the links do at one instant, for those who look: poses, velocities, accelerations, pin
/// forces.

#include <vector>

#include "planar_chain/planar.h"

namespace planar_chain {

/// One link; vectors in base-frame components.
struct LinkMotion {
  Vec2d innerPin;      ///< position of the inner pin: the origin of the link frame, m
  double angle = 0;    ///< θ, rad, not wrapped
  Vec2d com;           ///< position of the centre of mass, m
  Vec2d velocity;      ///< of the centre of mass, m/s
  double omega = 0;    ///< rad/s
  Vec2d acceleration;  ///< of the centre of mass, m/s²
  double alpha = 0;    ///< rad/s²
  Vec2d pinForce;      ///< on this link at its inner pin, by the link before or the ground, N
};

}  // namespace planar_chain
