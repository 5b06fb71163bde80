#pragma once

/// A number in each lane of a SIMD register. In an unnamed namespace on purpose: each file that includes this
/// is compiled for another CPU, and none may share a function with another.

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include <cmath>
#include <cstddef>
#include <cstring>

#include "planar_chain/planar.h"

/// The next loop is unrolled; the next function inlines all that it calls. Not for the sanitizers, whose
/// tests would take minutes.
#ifdef PLANAR_CHAIN_SANITIZE
#define PLANAR_CHAIN_WRITTEN_OUT
#define PLANAR_CHAIN_IN_ONE_PIECE
#else
#define PLANAR_CHAIN_WRITTEN_OUT _Pragma("GCC unroll 12")
#define PLANAR_CHAIN_IN_ONE_PIECE [[gnu::flatten]]
#endif

namespace planar_chain::simd {
namespace {

#if defined(__AVX512F__)
constexpr int laneCount = 8;
#elif defined(__AVX2__)
constexpr int laneCount = 4;
#else
constexpr int laneCount = 2;
#endif

struct Lanes {
  typedef double Register __attribute__((vector_size(8 * laneCount)));
  Register v;

  Lanes() : v{} {}
  Lanes(Register v_) : v(v_) {}
  explicit Lanes(double x) : v(x - Register{}) {}

  [[gnu::always_inline]] static Lanes load(const double* from) {
    Lanes a;
    std::memcpy(&a.v, from, sizeof a.v);
    return a;
  }
  [[gnu::always_inline]] void store(double* to) const { std::memcpy(to, &v, sizeof v); }

  friend Lanes operator+(Lanes a, Lanes b) { return a.v + b.v; }
  friend Lanes operator-(Lanes a, Lanes b) { return a.v - b.v; }
  friend Lanes operator*(Lanes a, Lanes b) { return a.v * b.v; }
  friend Lanes operator/(Lanes a, Lanes b) { return a.v / b.v; }
  friend Lanes operator-(Lanes a) { return -a.v; }
  Lanes& operator+=(Lanes b) { return *this = *this + b; }
  Lanes& operator-=(Lanes b) { return *this = *this - b; }
};

using planar_chain::mulAdd;
#if defined(__AVX512F__)
Lanes mulAdd(Lanes a, Lanes b, Lanes c) {
  return Lanes(_mm512_fmadd_pd(a.v, b.v, c.v));
}
#elif defined(__FMA__)
Lanes mulAdd(Lanes a, Lanes b, Lanes c) {
  return Lanes(_mm256_fmadd_pd(a.v, b.v, c.v));
}
#endif

using Integers = long long __attribute__((vector_size(8 * laneCount)));

/// One after the other.
template <class... Numbers>
[[gnu::always_inline]] inline void storeAll(double* to, Numbers... numbers) {
  ((numbers.store(to), to += laneCount), ...);
}

/// Pairs (x, y), in memory one after the other.
struct Pairs {
  Lanes x, y;
};

#if defined(__AVX512F__)

// All of maskz: GCC 12 takes the unmasked ones for reading what was never written.
[[gnu::always_inline]] inline Pairs loadPairs(const double* from) {
  const __m512d low = _mm512_loadu_pd(from), high = _mm512_loadu_pd(from + 8);
  const __m512i x = _mm512_setr_epi64(0, 2, 4, 6, 8, 10, 12, 14);
  const __m512i y = _mm512_setr_epi64(1, 3, 5, 7, 9, 11, 13, 15);
  return {Lanes(_mm512_permutex2var_pd(low, x, high)), Lanes(_mm512_permutex2var_pd(low, y, high))};
}

[[gnu::always_inline]] inline void storePairs(double* to, Pairs pairs) {
  const __m512i low = _mm512_setr_epi64(0, 8, 1, 9, 2, 10, 3, 11);
  const __m512i high = _mm512_setr_epi64(4, 12, 5, 13, 6, 14, 7, 15);
  _mm512_storeu_pd(to, _mm512_permutex2var_pd(pairs.x.v, low, pairs.y.v));
  _mm512_storeu_pd(to + 8, _mm512_permutex2var_pd(pairs.x.v, high, pairs.y.v));
}

[[gnu::always_inline]] inline bool all(Integers mask) {
  return _mm512_movepi64_mask(reinterpret_cast<__m512i>(mask)) == 0xff;
}

#elif defined(__AVX2__)

[[gnu::always_inline]] inline Pairs loadPairs(const double* from) {
  const __m256d low = _mm256_loadu_pd(from), high = _mm256_loadu_pd(from + 4);
  const __m256d inner = _mm256_permute2f128_pd(low, high, 0x20);
  const __m256d outer = _mm256_permute2f128_pd(low, high, 0x31);
  return {Lanes(_mm256_unpacklo_pd(inner, outer)), Lanes(_mm256_unpackhi_pd(inner, outer))};
}

[[gnu::always_inline]] inline void storePairs(double* to, Pairs pairs) {
  const __m256d even = _mm256_unpacklo_pd(pairs.x.v, pairs.y.v);
  const __m256d odd = _mm256_unpackhi_pd(pairs.x.v, pairs.y.v);
  _mm256_storeu_pd(to, _mm256_permute2f128_pd(even, odd, 0x20));
  _mm256_storeu_pd(to + 4, _mm256_permute2f128_pd(even, odd, 0x31));
}

[[gnu::always_inline]] inline bool all(Integers mask) {
  return _mm256_movemask_pd(reinterpret_cast<__m256d>(mask)) == 0xf;
}

#else

[[gnu::always_inline]] inline Pairs loadPairs(const double* from) {
  Pairs pairs;
  for (int s = 0; s < laneCount; ++s) pairs.x.v[s] = from[2 * s], pairs.y.v[s] = from[2 * s + 1];
  return pairs;
}

[[gnu::always_inline]] inline void storePairs(double* to, Pairs pairs) {
  for (int s = 0; s < laneCount; ++s) to[2 * s] = pairs.x.v[s], to[2 * s + 1] = pairs.y.v[s];
}

[[gnu::always_inline]] inline bool all(Integers mask) {
  bool each = true;
  for (int s = 0; s < laneCount; ++s) each = each && mask[s] != 0;
  return each;
}

#endif

// ---- The first numbers of a register, so many as there are -----------------------------------------

#if defined(__AVX2__) && !defined(__AVX512F__)

[[gnu::always_inline]] inline __m256i maskOf(int count) {
  alignas(32) static constexpr long long masks[2 * laneCount] = {-1, -1, -1, -1, 0, 0, 0, 0};
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(masks + laneCount - count));
}

#endif

/// The others are 0.
[[gnu::always_inline]] inline Lanes loadSome(const double* from, int count) {
  if (count >= laneCount) return Lanes::load(from);
#if defined(__AVX512F__)
  return Lanes(_mm512_maskz_loadu_pd(static_cast<__mmask8>((1 << count) - 1), from));
#elif defined(__AVX2__)
  return Lanes(_mm256_maskload_pd(from, maskOf(count)));
#else
  Lanes a;
  for (int s = 0; s < count; ++s) a.v[s] = from[s];
  return a;
#endif
}

[[gnu::always_inline]] inline void storeSome(double* to, Lanes a, int count) {
  if (count >= laneCount) return a.store(to);
#if defined(__AVX512F__)
  _mm512_mask_storeu_pd(to, static_cast<__mmask8>((1 << count) - 1), a.v);
#elif defined(__AVX2__)
  // Not with a mask, which takes some CPUs as long as ten stores.
  __m128d left = _mm256_castpd256_pd128(a.v);
  if (count & 2) {
    _mm_storeu_pd(to, left);
    left = _mm256_extractf128_pd(a.v, 1);
    to += 2;
  }
  if (count & 1) _mm_store_sd(to, left);
#else
  for (int s = 0; s < count; ++s) to[s] = a.v[s];
#endif
}

// ---- Lanes of other groups -------------------------------------------------------------------------

/// For each pair of groups of `size` lanes: both groups get the numbers of the inner one, or of the outer
/// one.
template <int size>
inline Lanes ofInner(Lanes a) {
#if defined(__AVX512F__)
  if constexpr (size == 1) return Lanes(_mm512_maskz_movedup_pd(0xff, a.v));
  if constexpr (size == 2) return Lanes(_mm512_maskz_permutex_pd(0xff, a.v, 0x44));
  if constexpr (size == 4) return Lanes(_mm512_maskz_shuffle_f64x2(0xff, a.v, a.v, 0x44));
#elif defined(__AVX2__)
  if constexpr (size == 1) return Lanes(_mm256_movedup_pd(a.v));
  if constexpr (size == 2) return Lanes(_mm256_permute2f128_pd(a.v, a.v, 0x00));
#else
  Lanes b;
  for (int s = 0; s < laneCount; ++s) b.v[s] = a.v[s & ~size];
  return b;
#endif
}

template <int size>
inline Lanes ofOuter(Lanes a) {
#if defined(__AVX512F__)
  if constexpr (size == 1) return Lanes(_mm512_maskz_permute_pd(0xff, a.v, 0xff));
  if constexpr (size == 2) return Lanes(_mm512_maskz_permutex_pd(0xff, a.v, 0xee));
  if constexpr (size == 4) return Lanes(_mm512_maskz_shuffle_f64x2(0xff, a.v, a.v, 0xee));
#elif defined(__AVX2__)
  if constexpr (size == 1) return Lanes(_mm256_permute_pd(a.v, 0xf));
  if constexpr (size == 2) return Lanes(_mm256_permute2f128_pd(a.v, a.v, 0x11));
#else
  Lanes b;
  for (int s = 0; s < laneCount; ++s) b.v[s] = a.v[s | size];
  return b;
#endif
}

/// In the lanes of inner groups the first, in those of outer ones the second.
template <int size>
inline Lanes either(Lanes inner, Lanes outer) {
  Integers isOuter;
  for (int s = 0; s < laneCount; ++s) isOuter[s] = s & size ? -1 : 0;
  return Lanes(isOuter ? outer.v : inner.v);
}

// ---- Size ------------------------------------------------------------------------------------------

// All three compare once; of a number and what is none, the first two give b.

[[gnu::always_inline]] inline Lanes root(Lanes a) {
#if defined(__AVX512F__)
  return Lanes(_mm512_maskz_sqrt_pd(0xff, a.v));
#elif defined(__AVX2__)
  return Lanes(_mm256_sqrt_pd(a.v));
#else
  for (int s = 0; s < laneCount; ++s) a.v[s] = std::sqrt(a.v[s]);
  return a;
#endif
}

/// Sets small numbers to zero: G shrinks exponentially along a segment, and denormal numbers are slow. Every
/// few steps are enough, as numbers do not become denormal between.
constexpr int stepsPerFlush = 8;
[[gnu::always_inline]] inline Lanes flushed(Lanes a) {
  const Integers large = (a.v > Lanes(1e-140).v) | (a.v < Lanes(-1e-140).v);
  return Lanes(reinterpret_cast<Lanes::Register>(reinterpret_cast<Integers>(a.v) & large));
}

}  // namespace
}  // namespace planar_chain::simd
