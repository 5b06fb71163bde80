#include "lanes/arrangement.h"

#include "lanes/kernel.h"

namespace planar_chain {

namespace {

/// Steps of the longest of so many segments. One more where the segments would stand as far apart, along the
/// chain, as a CPU's cache repeats itself.
int stepsOf(int n, int lanes) {
  constexpr int apart = 128;  // numbers: 1 KB, of a cache that repeats itself every 4
  const int steps = (n + lanes - 1) / lanes;
  return steps % apart == 0 ? steps + 1 : steps;
}

}  // namespace

Arrangement::Arrangement(int n, const simd::Kernel* given) : n_(n) {
  const simd::Kernel& kernel = given ? *given : simd::kernelFor(n);
  lanes_ = kernel.lanes;
  steps_ = stepsOf(n, lanes_);
  arrange_ = kernel.arrange;
  restore_ = kernel.restore;
}

void Arrangement::arrange(const Vec2d* values, Vec2d* arranged) const {
  for (int s = 0, j = 0; s < lanes_; ++s) {
    for (int i = 0; i < steps_; ++i, ++j) arranged[i * lanes_ + s] = j < n_ ? values[j] : Vec2d{};
  }
}

}  // namespace planar_chain
