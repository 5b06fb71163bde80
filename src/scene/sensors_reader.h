#pragma once

/// Reads keys `sensors` and `seed` of a scene.

#include <vector>

#include "effects/effect_kind.h"
#include "planar_chain/scene.h"
#include "reading/section.h"

namespace planar_chain {

/// An entry with `joints` is an encoder, one with `link` an IMU. names: nullptr if the links could not be
/// read.
std::vector<Sensor> readSensors(const Section& top, const PublishSettings& publish, const ChainNames* names);

/// Key `seed`: a whole number, by default 0.
long long readSeed(const Section& top);

}  // namespace planar_chain
