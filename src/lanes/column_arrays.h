#pragma once

/// The kernel of column_series.h, compiled for each kind of CPU.

#include <vector>

#include "simd/cpu.h"

namespace planar_chain::simd {

/// Storage. Every series of single numbers has its orders side by side, zeros before them, and lies `apart`
/// from the next one.
struct ColumnArrays {
  static constexpr int most = 8;    ///< links
  static constexpr int before = 8;  ///< zeros
  static constexpr int tail = 6;    ///< orders of which the error counts
  /// Where the numbers of a chain stand, and how they change.
  struct Terms {
    static constexpr int inertia(int i) { return i; }                   ///< J_i
    static constexpr int weight(int i, int n) { return n + 2 * i; }     ///< G_i
    static constexpr int joint(int i, int n) { return 3 * n + 4 * i; }  ///< armature, d, k, τ at q = 0
    /// c_ij, i < j
    static constexpr int coupling(int i, int j, int n) { return 7 * n + 2 * (i < j ? i * n + j : j * n + i); }
    static constexpr int count(int n) { return 7 * n + 2 * n * n; }
  };
  static constexpr int count(int n) { return 5 * n * (n + 1) / 2 + 3 * n + 6 * n * n + 1; }  ///< of series

  int n, leading;
  int order;  ///< of the motion; that of the columns is one more
  int apart, width, numbers, firstNumber;
  const double* own;      ///< Terms
  const double* changes;  ///< those by each number, one after the other
  const double* free;     ///< 1, or 0 of a prescribed joint
  const double* inverses;
  double *series, *inverse;
  double *columns, *sources;  ///< order by order, joint by joint; `width` numbers each
};

struct ColumnKernel {
  int lanes;
  /// Reads c, as SeriesRun writes it, and orders 0 and 1 of the columns. Writes the others.
  void (*find)(const ColumnArrays& arrays, const double* c);
  /// Writes the columns at h, and their rates. Returns the largest ratio of the last orders, each times its
  /// weight, to the size of a column.
  double (*at)(const ColumnArrays& arrays, double h, const double* weights, double* to);
  /// As Kernel::rotations.
  void (*rotations)(const double* theta, double* e, int n);
};

extern const ColumnKernel columnsBaseline, columnsAvx2, columnsAvx512;

/// The kernels that this CPU runs, the best first.
const std::vector<const ColumnKernel*>& columnKernels(KernelChoice choice = {});

}  // namespace planar_chain::simd
