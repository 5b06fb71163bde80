#pragma once

/// Rows of ode/nystrom.h, for `laneCount` positions and rates at a time.

#include <cstddef>

#include "simd/lanes.h"
#include "simd/vectors.h"

namespace planar_chain::simd {
namespace {

/// With so many terms. The last one is in no position: ā_ij = Σ a_ik a_kj needs a k between i and j.
template <int count>
class NystromLanes {
 public:
  NystromLanes(const NystromSums& row, std::ptrdiff_t n) : row_(row), n_(n), drift_(row.h * row.drift) {
    for (int j = 0; j < count; ++j) {
      forRates_[j] = Lanes(row.h * row.forRates[j]);
      forPositions_[j] = Lanes(row.h * row.h * row.forPositions[j]);
    }
  }

  /// Calls loop(write), where write(i, size, last) makes the sums of those from i on with that last term.
  template <class Loop>
  [[gnu::always_inline]] inline void run(Loop loop) const {
    const auto toSum = [this](std::ptrdiff_t i, int size, Lanes /*omega*/, Lanes position, Lanes rate) {
      storeSome(row_.sum + i, position, size);
      storeSome(row_.sum + n_ + i, rate, size);
    };
    const auto toOut = [this](std::ptrdiff_t i, int size, Lanes omega, Lanes position, Lanes rate) {
      storeSome(row_.out + i, loadSome(row_.base + i, size) + position, size);
      storeSome(row_.out + n_ + i, omega + rate, size);
    };
    if (!row_.out) {
      loop(summed(toSum));
    } else if (!row_.sum) {
      loop(summed(toOut));
    } else {
      loop(summed([=](auto... all) { toSum(all...), toOut(all...); }));
    }
  }

  Lanes lastTerm(std::ptrdiff_t i, int size) const { return loadSome(row_.terms[count - 1] + i, size); }

 private:
  template <class Write>
  [[gnu::always_inline]] inline auto summed(Write write) const {
    return [this, write](std::ptrdiff_t i, int size, Lanes last) {
      const Lanes omega = loadSome(row_.base + n_ + i, size);
      Lanes rate, position = drift_ * omega;
      for (int j = 0; j < count - 1; ++j) {
        const Lanes term = loadSome(row_.terms[j] + i, size);
        rate = j == 0 ? forRates_[j] * term : mulAdd(forRates_[j], term, rate);
        position = mulAdd(forPositions_[j], term, position);
      }
      rate = count == 1 ? forRates_[count - 1] * last : mulAdd(forRates_[count - 1], last, rate);
      write(i, size, omega, position, rate);
    };
  }

  const NystromSums row_;
  const std::ptrdiff_t n_;
  Lanes drift_, forRates_[count], forPositions_[count];
};

}  // namespace
}  // namespace planar_chain::simd
