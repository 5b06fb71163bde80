#pragma once

/// The recursion of articulated.h for short chains: link by link, as it stands there, with sines, cosines and
/// all else that does not depend on the neighbours computed for several links at a time; for up to twelve
/// links written out without loops, and two in closed form.
///
/// Scene-made: there is one function for each length and for each kind of what acts, which computes no more
/// than that takes.

#include <array>
#include <string>

#include "planar_chain/chain.h"
#include "planar_chain/planar.h"
#include "recursion/acting.h"
#include "simd/cache_lines.h"

namespace planar_chain {

namespace simd {
struct Kernel;
struct ShortChains;
}  // namespace simd

class ShortChain {
 public:
  /// For n links up to this; longer ones: segments.h.
  static const int most;
  /// How many rotations outside.e must have room for in derivative().
  static int roomFor(int n);

  /// The best kernel of this CPU, or the one given.
  explicit ShortChain(const Chain& chain, const simd::Kernel* kernel = nullptr);

  /// In words, as "link by link, written out for 5".
  std::string name() const;

  /// y = [θ ω], dydt = [ω α], n numbers each. outside.e is written, but read when forces act; N and F are
  /// read when they act. Allocates nothing.
  void derivative(Acting acting, const Outside& outside, const double* y, double* dydt) {
    runs_[static_cast<std::size_t>(acting)](n_, links_.data(), outside, y, dydt);
  }

 private:
  int n_;
  CacheLines links_;
  std::array<void (*)(int n, const double* links, const Outside& outside, const double* y, double* dydt), 3>
      runs_;
};

}  // namespace planar_chain
