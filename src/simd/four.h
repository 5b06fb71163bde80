#pragma once

/// Two pairs of numbers. The compiler options of the including file choose the CPU; see lanes.h.

#include "simd/lanes.h"

namespace planar_chain::simd {
namespace {

using Four = LanesOf<4>;

/// Both numbers of a pair are the same.
Four pairsOf(double first, double second) {
  return {Four::Register{first, first, second, second}};
}
Four pairsOf(Vec2d first, Vec2d second) {
  return {Four::Register{first.x, first.y, second.x, second.y}};
}

/// Both numbers of each pair become its first, or its second.
Four firsts(Four a) {
  return shuffled(a, a, [](int s) { return s & ~1; });
}
Four seconds(Four a) {
  return shuffled(a, a, [](int s) { return s | 1; });
}
/// The numbers of each pair change places.
Four turned(Four a) {
  return shuffled(a, a, [](int s) { return s ^ 1; });
}
/// The pairs change places.
Four exchanged(Four a) {
  return shuffled(a, a, [](int s) { return s ^ 2; });
}
/// The first numbers of all pairs.
Four heads(Four a, Four b) {
  return shuffled(a, b, [](int s) { return 2 * s; });
}

}  // namespace
}  // namespace planar_chain::simd
