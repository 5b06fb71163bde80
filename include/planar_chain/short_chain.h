#pragma once

/// The recursion of articulated.h for short chains: link by link, as it stands there, with sines, cosines and
/// all else that does not depend on the neighbours computed for several links at a time; for up to eight
/// links written out without loops.
///
/// Scene-made: there is one function for each length and for each kind of what acts, which computes no more
/// than that takes.

#include <array>

#include "planar_chain/acting.h"
#include "planar_chain/cache_lines.h"
#include "planar_chain/chain.h"
#include "planar_chain/planar.h"

namespace planar_chain {

namespace simd {
struct Kernel;
struct ShortChains;
}  // namespace simd

class ShortChain {
 public:
  /// For n links up to this; longer ones: segments.h.
  static const int most;
  /// How many pairs e has room for in derivative().
  static int roomFor(int n);

  /// The best kernel of this CPU, or the one given.
  explicit ShortChain(const Chain& chain, const simd::Kernel* kernel = nullptr);

  /// y = [θ ω], dydt = [ω α], n numbers each. e: exp(i θ), written, but read when forces act. N, F and ground
  /// as in Articulated::accelerations, the first two read when they act. Allocates nothing.
  void derivative(Acting acting, const double* y, Rotation<double>* e, const double* N, const Vec2d* F,
                  Vec2d ground, double* dydt) {
    runs_[static_cast<std::size_t>(acting)](n_, links_.data(), y, &e->c, N, F ? &F->x : nullptr, &ground.x,
                                            dydt);
  }

 private:
  int n_;
  CacheLines links_;
  std::array<void (*)(int n, const double* links, const double* y, double* e, const double* N,
                      const double* F, const double* ground, double* dydt),
             3>
      runs_;
};

}  // namespace planar_chain
