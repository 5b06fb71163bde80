#pragma once

/// A scene as URDF, for rviz and other engines.

#include <string>

#include "planar_chain/scene.h"

namespace planar_chain {

/// The root is publish.baseFrame; every link's frame sits at its inner pin, and its continuous joint
/// (axis +z, the scene's damping) at the outer pin of the link before. What URDF has no word for is
/// left out: springs, loads, gravity. An inertia I about +z is written as a plane body's: izz = I,
/// ixx = iyy = I/2. Names are without frame prefix.
std::string urdfOf(const Scene& scene);

}  // namespace planar_chain
