#pragma once

/// The loads of a scene: see Load in scene.h. timed_terms.h has what they do.

#include "effects/effect_kind.h"

namespace planar_chain {

/// Key `loads` of a scene.
const EffectKind& loadKind();

}  // namespace planar_chain
