#include "simd/elementary.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

namespace planar_chain::simd {

namespace {

/// A sum with it is whole, and ends in the bits of the whole number.
constexpr double shift = 6755399441055744;  // 1.5·2⁵²

template <class To, class From>
To bitsOf(From from) {
  To to;
  std::memcpy(&to, &from, sizeof to);
  return to;
}

}  // namespace

/// x = 2^k m, √½ ≤ m < √2; ln m = 2 artanh s, s = (m − 1)/(m + 1).
double log2(double x) {
  constexpr std::int64_t rootOfHalf = 0x3fe6'a09e'667f'3bcd;
  const auto bits = bitsOf<std::int64_t>(std::max(x, 1e-300));
  const std::int64_t k = (bits - rootOfHalf) >> 52;
  const auto m = bitsOf<double>(bits - k * (std::int64_t{1} << 52));
  const double s = (m - 1) / (m + 1), z = s * s;
  const double series = 1 + z * (1. / 3 + z * (1. / 5 + z * (1. / 7 + z * (1. / 9))));
  return static_cast<double>(k) + 2.8853900817779268 * s * series;
}

/// x = k + f, |f| ≤ ½; 2^f by the series of exp(f ln 2).
double exp2(double x) {
  if (!(x < 1000)) return std::numeric_limits<double>::infinity();
  if (!(x > -1000)) return 0;
  const double shifted = x + shift, f = 0.69314718055994531 * (x - (shifted - shift));
  const double high = 1. / 24 + f * (1. / 120 + f * (1. / 720 + f * (1. / 5040)));
  const double power = 1 + f * (1 + f * (1. / 2 + f * (1. / 6 + f * high)));
  return bitsOf<double>(bitsOf<std::uint64_t>(power) + (bitsOf<std::uint64_t>(shifted) << 52));
}

/// x = 2^k (1 + m), 0 ≤ m < 1: log2 x ≈ k + m, which the bits of x hold, too small by at most 0.0861. The
/// power of 2 as in exp2(), in four terms of least error.
double roughPower(double x, double y) {
  constexpr std::int64_t one = 0x3ff0'0000'0000'0000;  // the bits of 1
  const double log = 0x1p-52 * static_cast<double>(bitsOf<std::int64_t>(x) - one);
  const double shifted = y * log + shift, f = y * log - (shifted - shift);
  const double power = 1 + 0.69328 * f + f * f * (0.24221 + 0.05501 * f);
  return bitsOf<double>(bitsOf<std::uint64_t>(power) + (bitsOf<std::uint64_t>(shifted) << 52));
}

/// x = k ln 2 + f, |f| ≤ ½ ln 2; e^f by its series. ln 2 is a sum of two numbers, of which k times the first
/// is exact.
double exp(double x) {
  if (!(x < 708)) return std::numeric_limits<double>::infinity();
  if (!(x > -708)) return 0;
  constexpr double high = 0.693147180369123816490, low = 1.90821492927058770002e-10;
  const double shifted = x * 1.4426950408889634 + shift, k = shifted - shift;
  const double f = (x - k * high) - k * low;
  double series = 1;
  for (int i = 14; i > 0; --i) series = 1 + f / i * series;
  return bitsOf<double>(bitsOf<std::uint64_t>(series) + (bitsOf<std::uint64_t>(shifted) << 52));
}

}  // namespace planar_chain::simd
