#pragma once

/// The likely reason for short steps: the fastest of what a scene's keys ask for.

#include <string>

#include "planar_chain/scene.h"

namespace planar_chain {

/// Returns "the fastest key is stop_damping of elbow (1e+100 N m s/rad); ", or nothing if no key asks for
/// much within steps of this length, s: a stiffness k, damping d or drag c by √(k/J), d/J or c/J · 1 rad/s,
/// J the inertia of the joint's own link; at t a law by its frequency, or by its shortest time between two
/// points. Allocates.
std::string stiffestParameter(const Scene& scene, double t, double step);

}  // namespace planar_chain
