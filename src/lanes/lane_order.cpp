#include "lanes/lane_order.h"

#include <algorithm>

namespace planar_chain {

namespace {

/// Copies n numbers or vectors to lane order, or back from it.
template <bool isBack, int lanes, class Quantity>
void copyOf(std::ptrdiff_t n, std::ptrdiff_t steps, const Quantity* from, Quantity* to) {
  const auto laneIndex = [](std::ptrdiff_t i, int s) { return i * lanes + s; };
  const auto body = [steps](std::ptrdiff_t i, int s) { return s * steps + i; };
  const std::ptrdiff_t whole = std::max<std::ptrdiff_t>(0, n - (lanes - 1) * steps);  // with all lanes in use
  for (std::ptrdiff_t i = 0; i < whole; ++i) {
    Quantity row[lanes];
    for (int s = 0; s < lanes; ++s) row[s] = from[isBack ? laneIndex(i, s) : body(i, s)];
    for (int s = 0; s < lanes; ++s) to[isBack ? body(i, s) : laneIndex(i, s)] = row[s];
  }
  for (std::ptrdiff_t i = whole; i < steps; ++i) {
    for (int s = 0; s < lanes && body(i, s) < n; ++s) {
      to[isBack ? body(i, s) : laneIndex(i, s)] = from[isBack ? laneIndex(i, s) : body(i, s)];
    }
  }
}

/// The number of lanes as a constant halves the time.
template <bool isBack, class Quantity>
void copy(int n, int lanes, int steps, const Quantity* from, Quantity* to) {
  const auto run = lanes == 8   ? copyOf<isBack, 8, Quantity>
                   : lanes == 4 ? copyOf<isBack, 4, Quantity>
                   : lanes == 2 ? copyOf<isBack, 2, Quantity>
                                : copyOf<isBack, 1, Quantity>;
  run(n, steps, from, to);
}

}  // namespace

template <class Quantity>
void LaneOrder::toLaneOrder(const Quantity* values, Quantity* laneOrdered) const {
  std::fill(laneOrdered + std::max(0, n_ - (lanes_ - 1) * steps_) * lanes_, laneOrdered + paddedSize(),
            Quantity{});
  copy<false>(n_, lanes_, steps_, values, laneOrdered);
}
template void LaneOrder::toLaneOrder(const double*, double*) const;
template void LaneOrder::toLaneOrder(const Vec2d*, Vec2d*) const;
template void LaneOrder::toLaneOrder(const Rotation<double>*, Rotation<double>*) const;

void LaneOrder::toChainOrder(const double* laneOrdered, double* values) const {
  copy<true>(n_, lanes_, steps_, laneOrdered, values);
}

}  // namespace planar_chain
