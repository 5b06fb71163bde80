#pragma once

/// What every link does at one instant, from the accelerations that f gave.

#include "planar_chain/chain.h"
#include "planar_chain/motion.h"

namespace planar_chain {

/// y: θ and ω, and alpha: α, n of each, absolute. e: exp(i θ_j). F: forces at the links without gravity, N,
/// or nullptr. Writes n motions. The forces in the pins follow from the tip inwards: F_pin,j = m (a_j − g) −
/// F_j + F_pin,j+1. Allocates nothing.
void linkMotions(const Chain& chain, const double* y, const double* alpha, const Rotation<double>* e,
                 const Vec2d* F, LinkMotion* motions);

}  // namespace planar_chain
