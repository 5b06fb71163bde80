#pragma once

/// Copies numbers between the order of the chain and that of the segments in lanes; see arrangement.h. Blocks
/// of as many steps as lanes are transposed.

#include <algorithm>

#include "lanes/join_kernel.h"
#include "simd/lanes.h"

namespace planar_chain::simd {
namespace {

/// Rows become columns: groups of `size` lanes change places in pairs of rows, and so do all larger ones.
template <int size = 1>
[[gnu::always_inline]] inline void transpose(Real* rows) {
  if constexpr (size < laneCount) {
    PLANAR_CHAIN_WRITTEN_OUT
    for (int i = 0; i < laneCount; ++i) {
      if (i & size) continue;
      const Real inner = rows[i], outer = rows[i | size];
      rows[i] = either<size>(inner, ofInner<size>(outer));
      rows[i | size] = either<size>(ofOuter<size>(inner), outer);
    }
    transpose<2 * size>(rows);
  }
}

/// Calls f(s, begin, count) for the bodies of each segment s in the block of `size` steps from `first` on.
template <class F>
[[gnu::always_inline]] inline void forStretches(int n, int steps, int first, int size, F f) {
  const int whole = n / steps;  // segments
  PLANAR_CHAIN_WRITTEN_OUT
  for (int s = 0; s < laneCount; ++s) {
    const std::ptrdiff_t begin = static_cast<std::ptrdiff_t>(s) * steps + first;
    if (s < whole) {
      f(s, begin, size);
    } else if (begin < n) {
      f(s, begin, std::min(size, static_cast<int>(n - begin)));
    }
  }
}

void arrange(int n, int steps, const double* values, double* arranged) {
  for (int first = 0; first < steps; first += laneCount) {
    const int size = std::min(laneCount, steps - first);
    Real rows[laneCount];
    forStretches(n, steps, first, size,
                 [&](int s, std::ptrdiff_t begin, int count) { rows[s] = loadSome(values + begin, count); });
    transpose(rows);
    double* to = arranged + static_cast<std::ptrdiff_t>(first) * laneCount;
    PLANAR_CHAIN_WRITTEN_OUT
    for (int i = 0; i < laneCount; ++i) {
      if (i < size) rows[i].store(to + i * laneCount);
    }
  }
}

void restore(int n, int steps, const double* arranged, double* values) {
  for (int first = 0; first < steps; first += laneCount) {
    const int size = std::min(laneCount, steps - first);
    const double* from = arranged + static_cast<std::ptrdiff_t>(first) * laneCount;
    Real rows[laneCount];
    PLANAR_CHAIN_WRITTEN_OUT
    for (int i = 0; i < laneCount; ++i) {
      if (i < size) rows[i] = Real::load(from + i * laneCount);
    }
    transpose(rows);
    forStretches(n, steps, first, size,
                 [&](int s, std::ptrdiff_t begin, int count) { storeSome(values + begin, rows[s], count); });
  }
}

}  // namespace
}  // namespace planar_chain::simd
