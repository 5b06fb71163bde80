#pragma once

/// Sines and cosines of angles, for `laneCount` lanes. The compiler options of the including file choose the
/// CPU.

#include <algorithm>
#include <cmath>

#include "simd/pack.h"

namespace planar_chain::simd {
namespace {

[[gnu::always_inline]] inline Rotation<Pack> loadRotations(const double* e) {
  const Vec2p pairs = loadPairs(e);
  return {pairs.x, pairs.y};
}

/// exp(i θ) by the machine's library.
[[gnu::cold, gnu::noinline]] void rotate(const double* theta, double* e, int n) {
  for (int j = 0; j < n; ++j) {
    e[2 * j] = std::cos(theta[j]);
    e[2 * j + 1] = std::sin(theta[j]);
  }
}

/// π/2 in parts, such that the first difference θ − k π/2 is exact: by fused multiplication, or as k has 20
/// bits and the first parts 33.
#ifdef PLANAR_CHAIN_FUSES
constexpr double largestReducible = 1e9;
constexpr double halfPi[] = {1.57079632679489655800e+00, 6.12323399573676603587e-17,
                             -1.49738490485916983294e-33};
#else
constexpr double largestReducible = 1.6e6;
constexpr double halfPi[] = {1.57079632673412561417e+00, 6.07710050630396597660e-11,
                             2.02226624879595063154e-21};
#endif

/// θ = k π/2 + r, |r| ≤ π/4, with π/2 in three parts (W. Cody, W. Waite, Software Manual for the Elementary
/// Functions, 1980; the parts are fdlibm's). Then sin r and cos r by the polynomials of Sun's fdlibm
/// (k_sin.c, k_cos.c).
[[gnu::always_inline]] inline Rotation<Pack> rotationsOf(Pack theta) {
  // Adding 1.5·2⁵² rounds to an integer, whose last bits are then k's.
  const Pack shift(6755399441055744.0);
  const Pack shifted = mulAdd(theta, Pack(6.36619772367581382433e-01), shift);
  const Pack k = shifted - shift;
#ifdef PLANAR_CHAIN_FUSES
  Pack r = mulAdd(k, Pack(-halfPi[0]), theta);
  r = mulAdd(k, Pack(-halfPi[1]), r);
  r = mulAdd(k, Pack(-halfPi[2]), r);
#else
  const Pack first = theta - k * Pack(halfPi[0]), second = k * Pack(halfPi[1]), rounded = first - second;
  const Pack r = rounded + (((first - rounded) - second) - k * Pack(halfPi[2]));
#endif

  const Pack z = r * r;
  Pack p = mulAdd(z, Pack(1.58969099521155010221e-10), Pack(-2.50507602534068634195e-08));
  p = mulAdd(z, p, Pack(2.75573137070700676789e-06));
  p = mulAdd(z, p, Pack(-1.98412698298579493134e-04));
  p = mulAdd(z, p, Pack(8.33333333332248946124e-03));
  p = mulAdd(z, p, Pack(-1.66666666666666324348e-01));
  const Pack sine = mulAdd(z * r, p, r);

  Pack q = mulAdd(z, Pack(-1.13596475577881948265e-11), Pack(2.08757232129817482790e-09));
  q = mulAdd(z, q, Pack(-2.75573143513906633035e-07));
  q = mulAdd(z, q, Pack(2.48015872894767294178e-05));
  q = mulAdd(z, q, Pack(-1.38888888888741095749e-03));
  q = mulAdd(z, q, Pack(4.16666666666666019037e-02));
  const Pack half = Pack(0.5) * z;
  const Pack w = Pack(1) - half;
  const Pack cosine = w + mulAdd(z * z, q, (Pack(1) - w) - half);

  // Quadrant k mod 4: odd ones exchange sine and cosine; the signs follow. Casts keep the bits.
  using Register = Pack::Register;
  const auto bits = reinterpret_cast<Integers>(shifted.v);
  const Integers odd = (bits & 1) != 0;
  const Integers sineSign = (bits & 2) << 62;
  const Integers cosineSign = ((bits + 1) & 2) << 62;
  const Register s = odd ? cosine.v : sine.v;
  const Register c = odd ? sine.v : cosine.v;
  return {Pack(reinterpret_cast<Register>(reinterpret_cast<Integers>(c) ^ cosineSign)),
          Pack(reinterpret_cast<Register>(reinterpret_cast<Integers>(s) ^ sineSign))};
}

/// The library computes angles for which k π/2 is not exact enough, and those that are not finite.
bool areReducible(Pack theta) {
  return all((theta.v < Pack(largestReducible).v) & (theta.v > Pack(-largestReducible).v));
}

/// Computes each alone, so that no angle changes the result for another.
[[gnu::cold, gnu::noinline]] void rotateIrreducible(const double* theta, double* e, int count) {
  for (int j = 0; j < count; ++j) {
    if (!(std::abs(theta[j]) < largestReducible)) rotate(theta + j, e + 2 * j, 1);
  }
}

/// exp(i θ) of `count` angles, in lanes and in e, which has room for laneCount of them.
[[gnu::always_inline]] inline Rotation<Pack> rotationsOfSome(const double* theta, int count, double* e) {
  const Pack angles = loadSome(theta, count);
  Rotation<Pack> turns = rotationsOf(angles);
  storePairs(e, {turns.c, turns.s});
  if (__builtin_expect(!areReducible(angles), false)) {
    rotateIrreducible(theta, e, count < laneCount ? count : laneCount);
    turns = loadRotations(e);
  }
  return turns;
}

void rotations(const double* theta, double* e, int n) {
  int j = 0;
  for (; j + laneCount <= n; j += laneCount) rotationsOfSome(theta + j, laneCount, e + 2 * j);
  if (j == n) return;
  double last[2 * laneCount];
  rotationsOfSome(theta + j, n - j, last);
  std::copy(last, last + 2 * (n - j), e + 2 * j);
}

}  // namespace
}  // namespace planar_chain::simd
