#pragma once

/// Vectors of the integrators in SIMD registers: sums of stages, error norms, polynomials. The same source is
/// compiled once for each kind of CPU (cpu.h).

#include <array>
#include <cstddef>

#include "simd/cpu.h"

namespace planar_chain::simd {

/// What an error norm reads, component by component.
struct ErrorVectors {
  const double *error, *y, *ceiling, *noise;
};

/// A row of ode/nystrom.h: the sums alone, and with those of base; either may be nullptr.
struct NystromSums {
  const double *forRates, *forPositions;  ///< weights, one a term; the last term is in no position
  const double* const* terms;
  int count;
  double drift, h;
  const double* base;
  double *sum, *out;
};

/// Of two sums of the same terms.
struct WeightsOfTwo {
  const double *first, *second;
  const double* const* terms;
};

/// Vectors of the integrators.
struct VectorKernel {
  int lanes;
  static constexpr int mostTerms = 13;
  /// sum = factor Σ weights_j terms_j, out = base + sum; sum or out may be nullptr, and any two may be the
  /// same.
  using Combine = void (*)(double factor, const double* weights, const double* const* terms,
                           const double* base, double* sum, double* out, std::ptrdiff_t n);
  std::array<Combine, mostTerms> combine;  ///< of 1, 2 … terms
  /// The same for n positions and their n rates, which stand behind them.
  using CombineTwice = void (*)(const NystromSums& row, std::ptrdiff_t n);
  std::array<CombineTwice, mostTerms> combineTwice;
  /// out = base + Σ first_j terms_j, other = offset + factor Σ second_j terms_j; offset: or nullptr.
  using CombineForTwo = void (*)(const WeightsOfTwo& weights, double factor, const double* base, double* out,
                                 const double* offset, double* other, std::ptrdiff_t n);
  static constexpr int mostTermsForTwo = 7;
  std::array<CombineForTwo, mostTermsForTwo> combineForTwo;
  /// error ← error² / √(error² + 0.01 coarse²), component by component.
  void (*damp)(double* error, const double* coarse, std::ptrdiff_t n);
  /// Adds the increment to y, and to carry what rounding takes away. False, and nothing has changed, when y
  /// would not be finite.
  bool (*addCarried)(double* y, double* carry, const double* increment, std::ptrdiff_t n);
  /// sum = Σ_{0<k≤order} c_k h^k; c_k: row k of n numbers.
  void (*polynomial)(double h, const double* c, int order, double* sum, std::ptrdiff_t n);
  /// max |error| / max(most (1 + min(|y|, ceiling)), rounding noise); NaN when one is not finite.
  double (*largestRatio)(const ErrorVectors& of, double most, double rounding, std::ptrdiff_t n);
};

/// Those that this CPU can run, the best first.
const Kernels<VectorKernel>& vectorKernels();

/// The best for vectors of this size.
const VectorKernel& vectorsFor(std::ptrdiff_t size);

}  // namespace planar_chain::simd
