#include "sensors/random.h"

#include <cmath>

#include "simd/elementary.h"

namespace planar_chain {

RandomBits philox(RandomBits counter, RandomKey key) {
  constexpr int rounds = 10;
  constexpr std::uint64_t multiplier0 = 0xD2511F53, multiplier1 = 0xCD9E8D57;
  constexpr std::uint32_t weyl0 = 0x9E3779B9, weyl1 = 0xBB67AE85;
  for (int round = 0; round < rounds; ++round) {
    const std::uint64_t product0 = multiplier0 * counter[0], product1 = multiplier1 * counter[2];
    const auto high = [](std::uint64_t product) { return static_cast<std::uint32_t>(product >> 32); };
    const auto low = [](std::uint64_t product) { return static_cast<std::uint32_t>(product & 0xFFFFFFFFU); };
    counter = {high(product1) ^ counter[1] ^ key[0], low(product1), high(product0) ^ counter[3] ^ key[1],
               low(product0)};
    key[0] += weyl0;
    key[1] += weyl1;
  }
  return counter;
}

/// The name by FNV-1a, then both by the finalizer of splitmix64.
RandomKey keyOf(long long seed, const std::string& name) {
  std::uint64_t hash = 0xCBF29CE484222325;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3;
  hash ^= static_cast<std::uint64_t>(seed) * 0x9E3779B97F4A7C15;
  hash = (hash ^ (hash >> 30)) * 0xBF58476D1CE4E5B9;
  hash = (hash ^ (hash >> 27)) * 0x94D049BB133111EB;
  hash ^= hash >> 31;
  return {static_cast<std::uint32_t>(hash & 0xFFFFFFFFU), static_cast<std::uint32_t>(hash >> 32)};
}

namespace {

/// (Σ n_i r^i)/(Σ d_i r^i)
using Coefficients = std::array<double, 8>;
double ratio(const Coefficients& n, const Coefficients& d, double r) {
  double above = n.back(), below = d.back();
  for (std::size_t i = n.size() - 1; i-- > 0;) {
    above = above * r + n[i];
    below = below * r + d[i];
  }
  return above / below;
}

constexpr Coefficients middleAbove{
    3.3871328727963666080e0,  1.3314166789178437745e+2, 1.9715909503065514427e+3, 1.3731693765509461125e+4,
    4.5921953931549871457e+4, 6.7265770927008700853e+4, 3.3430575583588128105e+4, 2.5090809287301226727e+3};
constexpr Coefficients middleBelow{1,
                                   4.2313330701600911252e+1,
                                   6.8718700749205790830e+2,
                                   5.3941960214247511077e+3,
                                   2.1213794301586595867e+4,
                                   3.9307895800092710610e+4,
                                   2.8729085735721942674e+4,
                                   5.2264952788528545610e+3};
constexpr Coefficients tailAbove{1.42343711074968357734e0,  4.63033784615654529590e0,
                                 5.76949722146069140550e0,  3.64784832476320460504e0,
                                 1.27045825245236838258e0,  2.41780725177450611770e-1,
                                 2.27238449892691845833e-2, 7.74545014278341407640e-4};
constexpr Coefficients tailBelow{1,
                                 2.05319162663775882187e0,
                                 1.67638483018380384940e0,
                                 6.89767334985100004550e-1,
                                 1.48103976427480074590e-1,
                                 1.51986665636164571966e-2,
                                 5.47593808499534494600e-4,
                                 1.05075007164441684324e-9};
constexpr Coefficients farAbove{6.65790464350110377720e0,  5.46378491116411436990e0,
                                1.78482653991729133580e0,  2.96560571828504891230e-1,
                                2.65321895265761230930e-2, 1.24266094738807843860e-3,
                                2.71155556874348757815e-5, 2.01033439929228813265e-7};
constexpr Coefficients farBelow{1,
                                5.99832206555887937690e-1,
                                1.36929880922735805310e-1,
                                1.48753612908506148525e-2,
                                7.86869131145613259100e-4,
                                1.84631831751005468180e-5,
                                1.42151175831644588870e-7,
                                2.04426310338993978564e-15};

}  // namespace

double normalAt(double p) {
  constexpr double log2 = 0.69314718055994531;
  const double q = p - 0.5;
  if (std::abs(q) <= 0.425) return q * ratio(middleAbove, middleBelow, 0.180625 - q * q);
  const double r = std::sqrt(-log2 * simd::log2(q < 0 ? p : 1 - p));
  const double x = r <= 5 ? ratio(tailAbove, tailBelow, r - 1.6) : ratio(farAbove, farBelow, r - 5);
  return q < 0 ? -x : x;
}

double normal(RandomKey key, long long k, std::uint32_t component, std::uint32_t use) {
  const auto index = static_cast<std::uint64_t>(k);
  const RandomBits bits = philox({static_cast<std::uint32_t>(index & 0xFFFFFFFFU),
                                  static_cast<std::uint32_t>(index >> 32), component, use},
                                 key);
  // (m + ½)/2⁵² is a double, and so is its difference to 1.
  const std::uint64_t m = (std::uint64_t{bits[0]} << 32 | bits[1]) >> 12;
  return normalAt((static_cast<double>(m) + 0.5) * 0x1p-52);
}

}  // namespace planar_chain
