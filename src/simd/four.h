#pragma once

/// Two pairs of numbers, in one register or in two. The compiler options of the including file choose the
/// CPU; see lanes.h.

#include "simd/lanes.h"

namespace planar_chain::simd {
namespace {

#if defined(__AVX2__)

struct Four {
  __m256d v;

  Four() : v(_mm256_setzero_pd()) {}
  Four(__m256d v_) : v(v_) {}
  explicit Four(double x) : v(_mm256_set1_pd(x)) {}
  /// Both numbers of a pair are the same.
  Four(double first, double second) : v(_mm256_setr_pd(first, first, second, second)) {}
  Four(Vec2d first, Vec2d second) : v(_mm256_setr_pd(first.x, first.y, second.x, second.y)) {}

  static Four load(const double* from) { return _mm256_loadu_pd(from); }
  void store(double* to) const { _mm256_storeu_pd(to, v); }

  friend Four operator+(Four a, Four b) { return a.v + b.v; }
  friend Four operator-(Four a, Four b) { return a.v - b.v; }
  friend Four operator*(Four a, Four b) { return a.v * b.v; }
  friend Four mulAdd(Four a, Four b, Four c) { return _mm256_fmadd_pd(a.v, b.v, c.v); }
};

/// Both numbers of each pair become its first, or its second.
Four firsts(Four a) {
  return _mm256_movedup_pd(a.v);
}
Four seconds(Four a) {
  return _mm256_permute_pd(a.v, 0b1111);
}
/// The numbers of each pair change places.
Four turned(Four a) {
  return _mm256_permute_pd(a.v, 0b0101);
}
/// The pairs change places.
Four exchanged(Four a) {
  return _mm256_permute2f128_pd(a.v, a.v, 1);
}
/// The first numbers of all pairs.
Four heads(Four a, Four b) {
  return _mm256_permute4x64_pd(_mm256_unpacklo_pd(a.v, b.v), 0b11011000);
}

#else

struct Four {
  typedef double Pair __attribute__((vector_size(16)));
  Pair first, second;

  Four() : first{}, second{} {}
  Four(Pair first_, Pair second_) : first(first_), second(second_) {}
  explicit Four(double x) : Four(x, x) {}
  /// Both numbers of a pair are the same.
  Four(double first_, double second_) : first{first_, first_}, second{second_, second_} {}
  Four(Vec2d first_, Vec2d second_) : first{first_.x, first_.y}, second{second_.x, second_.y} {}

  static Four load(const double* from) { return {Pair{from[0], from[1]}, Pair{from[2], from[3]}}; }
  void store(double* to) const {
    std::memcpy(to, &first, sizeof first);
    std::memcpy(to + 2, &second, sizeof second);
  }

  friend Four operator+(Four a, Four b) { return {a.first + b.first, a.second + b.second}; }
  friend Four operator-(Four a, Four b) { return {a.first - b.first, a.second - b.second}; }
  friend Four operator*(Four a, Four b) { return {a.first * b.first, a.second * b.second}; }
  friend Four mulAdd(Four a, Four b, Four c) { return a * b + c; }
};

/// Both numbers of each pair become its first, or its second.
Four firsts(Four a) {
  return {a.first[0], a.second[0]};
}
Four seconds(Four a) {
  return {a.first[1], a.second[1]};
}
/// The numbers of each pair change places.
Four turned(Four a) {
  return {Four::Pair{a.first[1], a.first[0]}, Four::Pair{a.second[1], a.second[0]}};
}
/// The pairs change places.
Four exchanged(Four a) {
  return {a.second, a.first};
}
/// The first numbers of all pairs.
Four heads(Four a, Four b) {
  return {Four::Pair{a.first[0], a.second[0]}, Four::Pair{b.first[0], b.second[0]}};
}

#endif

}  // namespace
}  // namespace planar_chain::simd
