#pragma once

/// The motion of the links at one instant: positions, velocities, accelerations, pin forces.

#include "planar_chain/planar.h"

namespace planar_chain {

/// The motion of one link. Vectors have base-frame components.
struct LinkMotion {
  Vec2d innerPin;      ///< position of the inner pin, the origin of the link frame, m
  double angle = 0;    ///< θ, rad, not wrapped
  Vec2d com;           ///< position of the centre of mass, m
  Vec2d velocity;      ///< of the centre of mass, m/s
  double omega = 0;    ///< rad/s
  Vec2d acceleration;  ///< of the centre of mass, m/s²
  double alpha = 0;    ///< rad/s²
  Vec2d pinForce;      ///< N, on this link at its inner pin, from the previous link or the ground
};

}  // namespace planar_chain
