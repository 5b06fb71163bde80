#pragma once

/// The parts `integrator` and `publish` of a scene, and counts.

#include "effects/effect_kind.h"
#include "planar_chain/scene.h"
#include "reading/section.h"

namespace planar_chain {

constexpr int mostLinks = 100000;

/// Returns true if the key is absent or an integer from 1 to mostLinks.
bool takeCount(const Section& in, const char* key, int& target);

IntegratorSettings readIntegrator(const Section& in);

/// names: nullptr if the links could not be read.
PublishSettings readPublish(const Section& in, const ChainNames* names);

}  // namespace planar_chain
