#pragma once

/// The order in which a chain cut into segments is gone through: the segments stand side by side in SIMD
/// lanes, so lane s of step i is body s·steps + i, from the ground. Arranged, a number of each body takes
/// `steps` rows of a number a lane, one after the other. Places beyond the end hold 0.
///
/// Whatever goes through the bodies in this order reads and writes whole rows, and need not gather them.

#include <cstddef>

#include "planar_chain/planar.h"

namespace planar_chain {

namespace simd {
struct Kernel;
}

class Arrangement {
 public:
  /// Of n bodies, for the best kernel of this CPU or the one given.
  explicit Arrangement(int n, const simd::Kernel* kernel = nullptr);

  int lanes() const { return lanes_; }
  int steps() const { return steps_; }
  /// Numbers that an arranged quantity takes.
  int places() const { return steps_ * lanes_; }

  /// Of the number of body j.
  std::size_t placeOf(std::size_t j) const {
    const auto steps = static_cast<std::size_t>(steps_);
    return j % steps * static_cast<std::size_t>(lanes_) + j / steps;
  }

  /// n numbers to their places; and back. Not in place. They allocate nothing.
  void arrange(const double* values, double* arranged) const { arrange_(n_, steps_, values, arranged); }
  void restore(const double* arranged, double* values) const { restore_(n_, steps_, arranged, values); }
  void arrange(const Vec2d* values, Vec2d* arranged) const;

 private:
  int n_, lanes_, steps_;
  void (*arrange_)(int n, int steps, const double* values, double* arranged);
  void (*restore_)(int n, int steps, const double* arranged, double* values);
};

}  // namespace planar_chain
