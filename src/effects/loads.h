#pragma once

/// The loads of a scene: see Load in scene.h. timed_terms.h has what they do.

#include "effects/effect_kind.h"

namespace planar_chain {

/// Key `loads` of a scene.
const EffectKind& loadKind();

/// Returns the index of the link or joint that `key` names, or Load::none. key: "link" or "joint".
int takeReference(const Section& in, const std::string& key, const ChainNames* names);

/// The phases that a sine may have. Beyond them the rounding of ω t + phase is a noise that the energy guard
/// notices.
inline NumberRule phaseRule() {
  return {" from -1e4 to 1e4 rad", -1e4, 1e4, true};
}

}  // namespace planar_chain
