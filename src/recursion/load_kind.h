#pragma once

#include "planar_chain/planar.h"

namespace planar_chain {

/// The loads on the bodies besides pins, gravity and inertia. Each kind includes the previous ones.
enum class LoadKind {
  nothing,
  moments,  ///< in joints, equal and opposite on two bodies: springs, dampers, stops, joint torques
  forces,   ///< from outside, at points of links, with the moments that they have; moments from outside
};

/// The arrays that it stands in, n of each: e = exp(i θ_j); N: moments about the inner pins, N m; F: forces
/// without gravity, N, ground components; and the acceleration of the ground pin less gravity, m/s².
struct Loads {
  Rotation<double>* e;
  const double* N;
  const Vec2d* F;
  Vec2d ground;
};

}  // namespace planar_chain
