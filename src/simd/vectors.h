#pragma once

/// The integrators' vectors in SIMD registers: sums of stages, error norms, polynomials. This source is
/// compiled once for each kind of CPU (cpu.h). No function here allocates or throws.
///
/// AVX-512 has no kernel of its own here: against AVX2 it gains less than 1 % of any step.

#include <array>
#include <cstddef>
#include <vector>

#include "simd/cpu.h"

namespace planar_chain::simd {

/// The input of an error norm, component by component.
struct ErrorVectors {
  const double *error, *y, *unit, *ceiling, *noise;
};

/// The error that is allowed of the first `angles` components, and of the rates behind (ode/integrator.h).
struct AllowedErrors {
  double most, mostOfRates;
  std::ptrdiff_t angles;
  double perNoise;
  double slowUnits, turningTime;
};

/// A row of ode/combination.h in Nyström's form. `sum` gets the sums, `out` those added to `base`; one of
/// the two may be nullptr.
struct NystromSums {
  const double *forRates, *forPositions;  ///< weights, one a term; the last term is in no position
  const double* const* terms;
  double drift, h;
  const double* base;
  double *sum, *out;
};

struct VectorKernel {
  /// One function for each number of terms. This saves most with one link (src/README.md).
  static constexpr int mostTerms = 13;
  /// sum = factor Σ weights_j terms_j, out = base + sum. `sum` or `out` may be nullptr; arrays may be the
  /// same.
  using Combine = void (*)(double factor, const double* weights, const double* const* terms,
                           const double* base, double* sum, double* out, std::ptrdiff_t n);
  std::array<Combine, mostTerms> combine;  ///< of 1, 2 … terms
  /// Sums of n positions and, behind them, their n rates.
  using CombineTwice = void (*)(const NystromSums& row, std::ptrdiff_t n);
  std::array<CombineTwice, mostTerms> combineTwice;
  /// error ← error² / √(error² + 0.01 coarse²), component by component.
  void (*damp)(double* error, const double* coarse, std::ptrdiff_t n);
  /// Adds `increment` to y, and the rounding error of that to `carry`. Returns false, and changes nothing, if
  /// y would not be finite.
  bool (*addCarried)(double* y, double* carry, const double* increment, std::ptrdiff_t n);
  /// sum = Σ_{0<k≤order} c_k h^k, order > 2. c_k is row k of n numbers.
  void (*polynomial)(double h, const double* c, int order, double* sum, std::ptrdiff_t n);
  /// error = max of weights_k |c_k|, the last two of which are added. If these are not finite, neither is the
  /// error. c_k is row k of n numbers.
  static constexpr int tailOrders = 6;
  void (*tail)(const std::array<double, tailOrders>& weights, const double* c, double* error,
               std::ptrdiff_t n);
  /// max |error| / max(most size, perNoise noise). size = min(unit + |y|, ceiling), and of a rate at most
  /// slowUnits unit + turningTime |y|. NaN if one of them is not finite.
  double (*largestRatio)(const ErrorVectors& of, const AllowedErrors& allowed, std::ptrdiff_t n);
};

extern const VectorKernel vectorsAvx2, vectorsBaseline;

/// The kernels that this CPU runs, the best first.
const std::vector<const VectorKernel*>& vectorKernels(KernelChoice choice = {});

/// The best of them.
const VectorKernel& vectors(KernelChoice choice);

}  // namespace planar_chain::simd
