#pragma once

/// Elementary functions whose digits are the same on every CPU. Those of the C library are not: it has other
/// code for a CPU with fused multiplication.

namespace planar_chain::simd {

/// log2 x and 2^x to about 1e-9, which is enough for the length of a step. log2 takes x < 1e-300
/// as 1e-300; exp2 gives ∞ and 0 beyond 2^±1000.
double log2(double x);
/// e^x to 1 part in 1e15; ∞ and 0 beyond ±708.
double exp(double x);
double exp2(double x);
/// x^y, 0 ≤ x < ∞, |y| ≤ ½, with a relative error of at most 0.061 |y| + 0.0002, in half the time of power().
double roughPower(double x, double y);
/// x^y, x > 0.
inline double power(double x, double y) {
  return exp2(y * log2(x));
}

}  // namespace planar_chain::simd
