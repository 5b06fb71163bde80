#include "simd/elementary.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planar_chain::simd {

/// x = 2^k m, √½ ≤ m < √2; ln m = 2 artanh s, s = (m − 1)/(m + 1).
double log2(double x) {
  int k;
  double m = std::frexp(std::max(x, 1e-300), &k);
  if (m < 0.70710678118654752) {
    m *= 2;
    --k;
  }
  const double s = (m - 1) / (m + 1), z = s * s;
  const double series = 1 + z * (1. / 3 + z * (1. / 5 + z * (1. / 7 + z * (1. / 9))));
  return k + 2.8853900817779268 * s * series;
}

/// x = k + f, |f| ≤ ½; 2^f by the series of exp(f ln 2).
double exp2(double x) {
  if (!(x < 1000)) return std::numeric_limits<double>::infinity();
  if (!(x > -1000)) return 0;
  const double k = std::floor(x + 0.5), f = 0.69314718055994531 * (x - k);
  const double series =
      1 + f * (1 + f * (1. / 2 + f * (1. / 6 + f * (1. / 24 + f * (1. / 120 + f * (1. / 720 + f / 5040))))));
  return std::ldexp(series, static_cast<int>(k));
}

}  // namespace planar_chain::simd
