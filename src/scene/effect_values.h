#pragma once

/// The values of effects in a scene: numbers below a joint, a link and the scene itself, by the keys that the
/// kinds of effect have.

#include <vector>

#include "effects/effect_kind.h"
#include "reading/section.h"

namespace planar_chain {

/// The joint with some stiffness of its stop, if it has a limit.
Joint withStop(Joint joint);

/// The keys of numbers that effects have in a link, or in the scene.
std::vector<NumberKey> numberKeys(std::vector<NumberKey> (EffectKind::*of)() const);
/// Reads those that are given.
void takeNumbers(const Section& in, const std::vector<NumberKey>& keys, NamedNumbers& to);

/// Reads and checks the values of the effects in a joint. A joint with faults keeps none. A stop without a
/// stiffness keeps 0.
void takeEffects(const Section& in, Joint& joint);

/// True if the joint has a value that a driven joint may not have.
bool hasMoreThanDrive(const Joint& joint);

}  // namespace planar_chain
