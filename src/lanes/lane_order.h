#pragma once

/// The order of the bodies of a chain that is cut into segments. The segments lie side by side in SIMD lanes:
/// lane s of step i is body s·steps + i, counted from the ground. A quantity in lane order has `steps` rows
/// of one number a lane. Numbers beyond the end of the chain hold 0. Code in this order reads and writes
/// whole rows.

#include <cstddef>
#include <initializer_list>

#include "planar_chain/planar.h"

namespace planar_chain {

/// Writes the quantities of one body, which lie `lanes` apart. laneIndex: its index in a quantity in lane
/// order.
inline void putInLane(double* rows, std::size_t laneIndex, std::size_t lanes,
                      std::initializer_list<double> quantities) {
  double* to = rows + laneIndex / lanes * lanes * quantities.size() + laneIndex % lanes;
  for (const double each : quantities) {
    *to = each;
    to += lanes;
  }
}

class LaneOrder {
 public:
  /// The order of n bodies.
  LaneOrder(int n, int lanes) : n_(n), lanes_(lanes), steps_((n + lanes - 1) / lanes) {}

  int bodies() const { return n_; }
  int lanes() const { return lanes_; }
  int steps() const { return steps_; }
  /// The rounds in which the segments are joined two by two.
  int rounds() const {
    int rounds = 0;
    while (1 << rounds < lanes_) ++rounds;
    return rounds;
  }
  /// The length of a quantity in lane order.
  int paddedSize() const { return steps_ * lanes_; }

  /// The index of body j in a quantity in lane order.
  std::size_t laneIndexOf(std::size_t j) const {
    const auto steps = static_cast<std::size_t>(steps_);
    return j % steps * static_cast<std::size_t>(lanes_) + j / steps;
  }

  /// Copies n numbers or vectors to lane order, with 0 beyond the end, and back. The arrays must be
  /// different ones. They allocate nothing.
  template <class Quantity>
  void toLaneOrder(const Quantity* values, Quantity* laneOrdered) const;
  void toChainOrder(const double* laneOrdered, double* values) const;

 private:
  int n_, lanes_, steps_;
};

}  // namespace planar_chain
