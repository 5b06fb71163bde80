#pragma once

/// Random numbers by counter: each is a function of a key and a counter, and nothing is kept between calls.
///
/// Philox4x32-10: J. Salmon, M. Moraes, R. Dror, D. Shaw, Parallel random numbers: as easy as 1, 2, 3, SC
/// 2011. The normal numbers are the percentage points of M. Wichura, Algorithm AS 241, Applied Statistics 37
/// (1988), at uniform numbers of 52 bits. They use + − × ÷, the square root and simd::log2 alone, all of
/// which IEEE 754 determines. So they are the same on every machine.

#include <array>
#include <cstdint>
#include <string>

namespace planar_chain {

using RandomKey = std::array<std::uint32_t, 2>;
using RandomBits = std::array<std::uint32_t, 4>;

RandomBits philox(RandomBits counter, RandomKey key);

/// The key of a named stream: a hash of both.
RandomKey keyOf(long long seed, const std::string& name);

/// The normal number x with P(X < x) = p, 0 < p < 1, to about 1e-9.
double normalAt(double p);

/// A normal number of mean 0 and deviation 1.
/// k ≥ 0; component: of the measurement; use: keeps numbers for different purposes apart
double normal(RandomKey key, long long k, std::uint32_t component, std::uint32_t use);

}  // namespace planar_chain
