#pragma once

/// The recursion of articulated.h for long chains: cut into segments that run side by side in SIMD lanes.
///
/// The recursion waits for its own results, link by link, so one at a time leaves a core idle. A segment on
/// whose outer pin the next one exerts a still unknown force −f shows two handles, its inner and outer pin:
///
///     F_in = A a + b + G f          a_out = Gᵀ a − C f + c
///
/// A and b as in articulated.h, with f = 0; and from the outermost body, where C = 0, c = 0, inwards
///
///     g = Gᵀ iP        C ← C + g gᵀ/D        c ← c + g u/D − ω² Gᵀ P        G ← G − U gᵀ/D
///
/// The outer pin has axes of its own, d along the segment's last link and i d: there G = (d, i d), and f, C
/// and c stand in them. So what a taut segment gives way along itself is small because g is, and does not
/// come out as rounding of what it gives way across; a heavy tip would meet that with all its mass.
///
/// Neighbours are joined two by two, and then the pairs, until one is left. With A', b', C', c' and G' of the
/// outer one, its inner handle turned into the axes of the pin between, and K = (1 + A'C)⁻¹, both together
/// show
///
///     A + G K A' Gᵀ        b + G k        G K G'        C' + G'ᵀ C K G'        c' + G'ᵀ (c − C k)
///
/// where k = K (A' c + b'). And outwards, from the ground's a and f' = 0: at the pin between
/// f = K A' Gᵀ a + k + K G' f' and the outer one's a = Gᵀ a − C f + c, turned back into ground axes; then
/// within each segment
///
///     α = u/D − (g/D)·f − (U/D)·a        a ← a + iα P − ω² P
///
/// As exact as the recursion itself. What runs is chosen once, by the CPU and the length of the chain.

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "lanes/arrangement.h"
#include "planar_chain/chain.h"
#include "planar_chain/planar.h"
#include "simd/cache_lines.h"

namespace planar_chain {

namespace simd {
struct Kernel;
}  // namespace simd

/// m, I, r and p of the links, in rows of lanes, for a chain cut into segments. Links beyond the end have no
/// mass and no length, and I = 1. Allocates.
CacheLines linksArranged(const Chain& chain, const Arrangement& arrangement);
/// The same with neighbours side by side: lane s of step i is body i·lanes + s.
CacheLines linksInBlocks(const Chain& chain, int lanes);

/// e_j = exp(i θ_j) for n angles, rad, to about 1 ulp for any finite angle. Allocates nothing.
void rotations(const double* theta, Rotation<double>* e, int n);

class Segments {
 public:
  /// Uses the given kernel, or else the best of this CPU for so many links. Allocates.
  explicit Segments(const Chain& chain, const simd::Kernel* kernel = nullptr);

  /// True if this is faster than the recursion link by link, for n links on this CPU.
  static bool areWorthwhile(int n);

  /// A description such as "in 8 segments side by side (avx512)".
  std::string name() const;

  /// The order of all arguments of accelerations().
  const Arrangement& arrangement() const { return arrangement_; }

  /// As Articulated::accelerations, with places() numbers a quantity. Places beyond the end have e = 1 and
  /// zeros. Allocates nothing.
  void accelerations(const Rotation<double>* e, const double* omega, const double* N, const Vec2d* F,
                     Vec2d ground, double* alpha);

 private:
  const simd::Kernel& kernel_;
  Arrangement arrangement_;
  CacheLines links_, handles_;
};

}  // namespace planar_chain
