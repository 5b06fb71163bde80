#pragma once

/// Reads what a scene has of prismatic links.

#include <vector>

#include "planar_chain/scene.h"
#include "reading/section.h"

namespace planar_chain {

/// True if the joint of a link is prismatic. Other values of `type` are faults.
bool takeType(const Section& link);

/// Records what a chain with prismatic links may not have.
void refuseBesideSlides(const Section& top, const Chain& chain, const IntegratorSettings& integrator,
                        const std::vector<Load>& loads);

}  // namespace planar_chain
