#pragma once

/// The recursion of articulated.h for short chains, link by link. Sines, cosines and all that does not depend
/// on the neighbours are computed for several links at a time. Two links use a closed form.
///
/// There is a function for each length and for each kind of load. The functions have no loops:
/// src/README.md says what that gains.

#include <array>
#include <string>

#include "planar_chain/chain.h"
#include "planar_chain/planar.h"
#include "recursion/load_kind.h"
#include "simd/cache_lines.h"

namespace planar_chain {

namespace simd {
struct Kernel;
struct ShortChains;
}  // namespace simd

class ShortChain {
 public:
  /// The most links. Longer chains use segments.h.
  static const int most;
  /// The length of external.e that derivative() needs, for CPUs of up to eight lanes.
  static int roomFor(int n) { return n + 8; }

  /// Allocates.
  ShortChain(const Chain& chain, const simd::Kernel& kernel);

  /// A description such as "link by link, written out for 5".
  std::string name() const;

  /// y = [θ ω], dydt = [ω α], n numbers each. Writes external.e, but reads it if forces act. Reads N and F if
  /// they act. Allocates nothing.
  void derivative(LoadKind acting, const Loads& external, const double* y, double* dydt) {
    runs_[static_cast<std::size_t>(acting)](links_.data(), external, y, dydt);
  }

 private:
  int n_;
  CacheLines links_;
  std::array<void (*)(const double* links, const Loads& external, const double* y, double* dydt), 3> runs_;
};

}  // namespace planar_chain
