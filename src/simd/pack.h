#pragma once

/// A number in each lane of a SIMD register. In an unnamed namespace on purpose: each file that includes this
/// is compiled for another CPU, and none may share a function with another.

#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__ARM_FEATURE_FMA)
#include <arm_neon.h>
#endif

#include <cmath>
#include <cstddef>
#include <utility>

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

template <int count>
struct RegisterOf {
  typedef double type __attribute__((vector_size(8 * count)));
};
template <>
struct RegisterOf<1> {
  using type = double;
};

template <int count>
struct PackOf {
  using Register = typename RegisterOf<count>::type;
  Register v;

  PackOf() : v{} {}
  PackOf(Register v_) : v(v_) {}
  /// One number in all lanes.
  template <class Real>
  explicit PackOf(Real x) : v(static_cast<double>(x) - Register{}) {}

  /// In memory, at any place. Before GCC 12, memcpy to a register goes through the stack.
  struct [[gnu::packed, gnu::may_alias]] Stored {
    Register v;
  };
  [[gnu::always_inline]] static PackOf load(const double* from) {
    return reinterpret_cast<const Stored*>(from)->v;
  }
  [[gnu::always_inline]] void store(double* to) const { reinterpret_cast<Stored*>(to)->v = v; }

  friend PackOf operator+(PackOf a, PackOf b) { return a.v + b.v; }
  friend PackOf operator-(PackOf a, PackOf b) { return a.v - b.v; }
  friend PackOf operator*(PackOf a, PackOf b) { return a.v * b.v; }
  friend PackOf operator/(PackOf a, PackOf b) { return a.v / b.v; }
  friend PackOf operator-(PackOf a) { return -a.v; }
  PackOf& operator+=(PackOf b) { return *this = *this + b; }
  PackOf& operator-=(PackOf b) { return *this = *this - b; }
};

/// In code that is compiled for one kind of CPU: a full register; a double, whose functions too are compiled
/// for this CPU alone; and a vector in each lane. As template parameters, Real is a double, a dual number, a
/// Pack or a Lane, and Scalar is such a number or a complex one.
using Pack = PackOf<laneCount>;
using Lane = PackOf<1>;
using Vec2p = Vec2<Pack>;
using Integers = decltype(Pack::Register() < Pack::Register());

using planar_chain::mulAdd;
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
#define PLANAR_CHAIN_FUSES
inline Lane mulAdd(Lane a, Lane b, Lane c) {
  return __builtin_fma(a.v, b.v, c.v);
}
#endif
#ifdef __FMA__
inline PackOf<2> mulAdd(PackOf<2> a, PackOf<2> b, PackOf<2> c) {
  return {_mm_fmadd_pd(a.v, b.v, c.v)};
}
PackOf<4> mulAdd(PackOf<4> a, PackOf<4> b, PackOf<4> c) {
  return {_mm256_fmadd_pd(a.v, b.v, c.v)};
}
#endif
#if defined(__AVX512F__)
Pack mulAdd(Pack a, Pack b, Pack c) {
  return {_mm512_fmadd_pd(a.v, b.v, c.v)};
}
#elif defined(__ARM_FEATURE_FMA)
Pack mulAdd(Pack a, Pack b, Pack c) {
  return {vfmaq_f64(c.v, a.v, b.v)};
}
#endif

inline Vec2<Lane> vectorOf(const Vec2d& a) {
  return {a.x, a.y};
}

/// Lane s of the result is number index(s) of those of a and, behind them, b.
template <int count, class Index, int... s>
[[gnu::always_inline]] inline PackOf<count> shuffled(PackOf<count> a, PackOf<count> b, Index index,
                                                     std::integer_sequence<int, s...>) {
#ifdef __clang__
  return {__builtin_shufflevector(a.v, b.v, std::integral_constant<int, index(s)>::value...)};
#else
  return {__builtin_shuffle(a.v, b.v, decltype(a.v < b.v){std::integral_constant<int, index(s)>::value...})};
#endif
}
template <int count, class Index>
[[gnu::always_inline]] inline PackOf<count> shuffled(PackOf<count> a, PackOf<count> b, Index index) {
  return shuffled(a, b, index, std::make_integer_sequence<int, count>());
}

/// Pairs (x, y), in memory one after the other.
[[gnu::always_inline]] inline Vec2p loadPairs(const double* from) {
  const Pack low = Pack::load(from), high = Pack::load(from + laneCount);
  return {shuffled(low, high, [](int s) { return 2 * s; }),
          shuffled(low, high, [](int s) { return 2 * s + 1; })};
}

/// Returns the index of number i of the pairs: pairs 0, 2 … in the first register, 1, 3 … in the second.
constexpr int indexInPairs(int i) {
  return i / 2 % 2 * laneCount + i / 4 * 2 + i % 2;
}

[[gnu::always_inline]] inline void storePairs(double* to, Vec2p pairs) {
  const Pack even = shuffled(pairs.x, pairs.y, [](int s) { return s % 2 * laneCount + s / 2 * 2; });
  const Pack odd = shuffled(pairs.x, pairs.y, [](int s) { return s % 2 * laneCount + s / 2 * 2 + 1; });
  shuffled(even, odd, [](int s) { return indexInPairs(s); }).store(to);
  shuffled(even, odd, [](int s) { return indexInPairs(laneCount + s); }).store(to + laneCount);
}

[[gnu::always_inline]] inline bool all(Integers mask) {
#if defined(__AVX512F__)
  return _mm512_movepi64_mask(reinterpret_cast<__m512i>(mask)) == 0xff;
#elif defined(__AVX2__)
  return _mm256_movemask_pd(reinterpret_cast<__m256d>(mask)) == 0xf;
#else
  return mask[0] != 0 && mask[1] != 0;
#endif
}

// ---- The first numbers of a register, so many as there are -----------------------------------------

/// The others are 0.
[[gnu::always_inline]] inline Pack loadSome(const double* from, int count) {
  if (count >= laneCount) return Pack::load(from);
#if defined(__AVX512F__)
  return Pack(_mm512_maskz_loadu_pd(static_cast<__mmask8>((1 << count) - 1), from));
#elif defined(__AVX2__)
  return Pack(_mm256_maskload_pd(from, reinterpret_cast<__m256i>(Integers{0, 1, 2, 3} < count)));
#else
  Pack a;
  for (int s = 0; s < count; ++s) a.v[s] = from[s];
  return a;
#endif
}

[[gnu::always_inline]] inline void storeSome(double* to, Pack a, int count) {
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
inline Pack ofInner(Pack a) {
  return shuffled(a, a, [](int s) { return s & ~size; });
}
template <int size>
inline Pack ofOuter(Pack a) {
  return shuffled(a, a, [](int s) { return s | size; });
}

/// In the lanes of inner groups the first, in those of outer ones the second.
template <int size>
inline Pack either(Pack inner, Pack outer) {
  return shuffled(inner, outer, [](int s) { return s & size ? laneCount + s : s; });
}

// ---- Size ------------------------------------------------------------------------------------------

inline Pack larger(Pack a, Pack b) {
  return {a.v > b.v ? a.v : b.v};
}
inline Pack smaller(Pack a, Pack b) {
  return {a.v < b.v ? a.v : b.v};
}
inline Pack absolute(Pack a) {
  return Pack(reinterpret_cast<Pack::Register>(reinterpret_cast<Integers>(a.v) & ~(1ll << 63)));
}

[[gnu::always_inline]] inline Pack root(Pack a) {
#if defined(__AVX512F__)
  return Pack(_mm512_maskz_sqrt_pd(0xff, a.v));
#elif defined(__AVX2__)
  return Pack(_mm256_sqrt_pd(a.v));
#else
  return {Pack::Register{std::sqrt(a.v[0]), std::sqrt(a.v[1])}};
#endif
}

/// Sets small numbers to zero: G shrinks exponentially along a segment, and denormal numbers are slow. Every
/// few steps are enough, as numbers do not become denormal between.
constexpr int stepsPerFlush = 8;
constexpr double leastKept = 1e-140;  ///< products of two are normal numbers, above 1e-308
[[gnu::always_inline]] inline Pack flushed(Pack a) {
  const Integers large = (a.v > Pack(leastKept).v) | (a.v < Pack(-leastKept).v);
  return Pack(reinterpret_cast<Pack::Register>(reinterpret_cast<Integers>(a.v) & large));
}

}  // namespace
}  // namespace planar_chain::simd
