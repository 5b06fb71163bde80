#pragma once

/// Reads a MotionLaw: {amplitude, frequency, phase, offset} or {times, values}.

#include "planar_chain/motion_law.h"
#include "reading/section.h"

namespace planar_chain {

/// The law at a key. unit: "rad" or "m". `hold`, where it is allowed, stands still at 0.
MotionLaw readLaw(const Section& in, const char* key, const char* unit, bool mayHold);

/// Key `base` of a scene.
BaseLaws readBase(const Section& base);

}  // namespace planar_chain
