#pragma once

/// Reads what holds the tip, and closes the chain with it.

#include <optional>

#include "planar_chain/scene.h"
#include "reading/section.h"

namespace planar_chain {

/// Key `tip` of a scene: {pin: [x, y]}, {pin: {x: LAW, y: LAW}} or {line: {point, direction}}.
std::optional<TipLaws> takeTip(const Section& top);

/// Records what a chain whose tip is held may not have. Returns true if there is nothing of it.
bool checkTip(const Section& top, const TipLaws& tip, const Chain& chain, const std::vector<Drive>& drives);

/// Moves the initial state onto the tip's condition, with a note of how far. Records a fault if it cannot.
void closeStart(Scene& scene, const Section& top);

}  // namespace planar_chain
