#pragma once

/// Reads what holds the tip, and closes the chain with it.

#include <optional>

#include "planar_chain/scene.h"
#include "reading/section.h"

namespace planar_chain {

/// Key `tip` of a scene: {pin: [x, y]}, {pin: {x: LAW, y: LAW}} or {line: {point, direction}}.
std::optional<TipLaws> takeTip(const Section& top);
/// Takes the key `tip`, and records a fault for what a chain with a held tip may not have.
std::optional<TipLaws> takeTip(const Section& top, const Chain& chain, const std::vector<Drive>& drives);

/// Moves the initial state onto the tip's condition, with a note of how far. Records a fault, and returns
/// false, if it cannot.
bool closeStart(Scene& scene, const Section& top);

}  // namespace planar_chain
