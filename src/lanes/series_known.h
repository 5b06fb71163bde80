#pragma once

/// The parts of the products of a Taylor series that follow from lower orders: see series_kernel.h.

#include <type_traits>

#include "lanes/lane_kernel.h"

namespace planar_chain::simd {
namespace {

// ---- Known products ------------------------------------------------------------------------------------

/// The sums Σ_{0<j<k} x_j y_{k−j} of a pair of columns, for four orders k = K … K + 3 at a time. When order
/// K − 1 is known, so are all terms with j and k − j below K. They are added then: each number is loaded once
/// for four sums. The other terms follow order by order.
///
/// Without this, loads from the caches take longer than all else.
enum PairKind {
  apart,    ///< two products
  sharing,  ///< with the same x: that of the first column
  summed,   ///< only their sum is asked for
};

class KnownPair {
 public:
  static constexpr int orders = SeriesArrays::knownOrders;

  /// The columns begin at x and y of order 0, orders lie `apart`. Sums of order k go to known + k % 4 × row.
  KnownPair(const double* x, const double* y, int apart, double* known, int row)
      : x_(x), y_(y), apart_(apart), known_(known), row_(row) {}

  /// Order k > 0, late = k % 4.
  template <PairKind kind, int late>
  [[gnu::always_inline]] void find(int k) const {
    if constexpr (late == 0) return findFour<kind>(k);
    double* known = known_ + late * row_;
    Pack sums[2];
    PLANAR_CHAIN_WRITTEN_OUT
    for (int c = 0; c < 2; ++c) {
      const int factor = kind == sharing ? 0 : c;
      Pack& sum = sums[c];
      if (k > late) {
        if (kind != summed || c == 0) sum = read(known, c);
        PLANAR_CHAIN_WRITTEN_OUT
        for (int j = 1; j <= late; ++j) {
          sum = mulAdd(x(j, factor), y(k - j, c), mulAdd(x(k - j, factor), y(j, c), sum));
        }
      } else {
        PLANAR_CHAIN_WRITTEN_OUT
        for (int j = 1; j < late; ++j) sum = mulAdd(x(j, factor), y(late - j, c), sum);
      }
    }
    store<kind>(sums[0], sums[1], known);
  }

 private:
  template <PairKind kind>
  [[gnu::always_inline]] static void store(Pack first, Pack second, double* known) {
    if constexpr (kind == summed) return (first + second).store(known);
    first.store(known);
    second.store(known + laneCount);
  }
  Pack x(int order, int column) const { return Pack::load(x_ + order * apart_ + column * laneCount); }
  Pack y(int order, int column) const { return Pack::load(y_ + order * apart_ + column * laneCount); }

  template <PairKind kind>
  [[gnu::always_inline]] void findFour(int K) const {
    Pack sums[2][orders], last[2][orders];  // last[c][d]: y_{K−j+d}
    const auto add = [&](int j, auto count) {
      const Pack shared = x(j, 0);
      PLANAR_CHAIN_WRITTEN_OUT
      for (int c = 0; c < 2; ++c) {
        const Pack factor = kind == sharing || c == 0 ? shared : x(j, c);
        for (int d = orders - 1; d > 0; --d) last[c][d] = last[c][d - 1];
        last[c][0] = y(K - j, c);
        PLANAR_CHAIN_WRITTEN_OUT
        for (int d = 0; d < decltype(count)::value; ++d) sums[c][d] = mulAdd(factor, last[c][d], sums[c][d]);
      }
    };
    add(1, std::integral_constant<int, 1>());
    add(2, std::integral_constant<int, 2>());
    add(3, std::integral_constant<int, 3>());
    for (int j = 4; j < K; j += 4) {
      PLANAR_CHAIN_WRITTEN_OUT
      for (int i = 0; i < 4; ++i) add(j + i, std::integral_constant<int, 4>());
    }
    for (int d = 0; d < orders; ++d) store<kind>(sums[0][d], sums[1][d], known_ + d * row_);
  }

  const double *x_, *y_;
  int apart_;
  double* known_;
  int row_;
};

/// All columns. In every group of so many columns the first `same` ones have the same x, pair by pair.
template <int columns, int same, int late>
[[gnu::always_inline]] inline void knowAllPairs(const double* rows, int width, int k, double* known) {
  const int row = width * laneCount;
  for (int group = 0; group < width; group += columns) {
    PLANAR_CHAIN_WRITTEN_OUT
    for (int column = 0; column < columns; column += 2) {
      const int at = (group + column) * laneCount;
      const KnownPair pair(rows + at, rows + row + at, 2 * row, known + at, row);
      column < same ? pair.find<sharing, late>(k) : pair.find<apart, late>(k);
    }
  }
}

/// Returns the sums of order k.
template <int columns, int same>
[[gnu::always_inline]] inline double* knowPairs(const double* rows, int width, int k, double* known) {
  const int late = k % KnownPair::orders;
  if (late == 0) knowAllPairs<columns, same, 0>(rows, width, k, known);
  if (late == 1) knowAllPairs<columns, same, 1>(rows, width, k, known);
  if (late == 2) knowAllPairs<columns, same, 2>(rows, width, k, known);
  if (late == 3) knowAllPairs<columns, same, 3>(rows, width, k, known);
  return known + late * width * laneCount;
}

}  // namespace
}  // namespace planar_chain::simd
