#include "lanes/arrangement.h"

#include <algorithm>

#include "lanes/kernel.h"

namespace planar_chain {

namespace {

/// Calls move(j, place) for each body j.
template <int lanes, class Move>
[[gnu::always_inline]] inline void forPlacesOf(std::ptrdiff_t n, std::ptrdiff_t steps, Move move) {
  const std::ptrdiff_t inAllLanes = std::max<std::ptrdiff_t>(0, n - (lanes - 1) * steps);
  for (std::ptrdiff_t i = 0; i < inAllLanes; ++i) {
#pragma GCC unroll 8
    for (int s = 0; s < lanes; ++s) move(s * steps + i, i * lanes + s);
  }
  for (std::ptrdiff_t i = inAllLanes; i < steps; ++i) {
    for (int s = 0; s < lanes && s * steps + i < n; ++s) move(s * steps + i, i * lanes + s);
  }
}

/// The number of lanes as a constant halves the time.
template <class Move>
[[gnu::always_inline]] inline void forPlaces(int n, int lanes, int steps, Move move) {
  if (lanes == 8) return forPlacesOf<8>(n, steps, move);
  if (lanes == 4) return forPlacesOf<4>(n, steps, move);
  forPlacesOf<2>(n, steps, move);
}

}  // namespace

Arrangement::Arrangement(int n, const simd::Kernel* kernel)
    : n_(n), lanes_((kernel ? *kernel : simd::kernelFor(n)).lanes), steps_((n + lanes_ - 1) / lanes_) {}

template <class Quantity>
void Arrangement::arrange(const Quantity* values, Quantity* arranged) const {
  std::fill_n(arranged, places(), Quantity{});
  forPlaces(n_, lanes_, steps_, [&](std::ptrdiff_t j, std::ptrdiff_t place) { arranged[place] = values[j]; });
}
template void Arrangement::arrange(const double*, double*) const;
template void Arrangement::arrange(const Vec2d*, Vec2d*) const;

void Arrangement::restore(const double* arranged, double* values) const {
  forPlaces(n_, lanes_, steps_, [&](std::ptrdiff_t j, std::ptrdiff_t place) { values[j] = arranged[place]; });
}

}  // namespace planar_chain
