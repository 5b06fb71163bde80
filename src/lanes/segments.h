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
struct NystromSums;
}  // namespace simd

/// What the recursions need of the links, m, I, r and p, row by row, for a chain cut into segments; those
/// beyond the end are without mass and length, with I = 1.
CacheLines linksArranged(const Chain& chain, const Arrangement& arrangement);
/// The same for neighbours side by side: lane s of step i is body i·lanes + s.
CacheLines linksInBlocks(const Chain& chain, int lanes);

/// e_j = exp(i θ_j) for n angles, to 1 ulp or so for any finite angle. Allocates nothing.
void rotations(const double* theta, Rotation<double>* e, int n);

class Segments {
 public:
  /// The best kernel of this CPU for so many links, or the one given.
  explicit Segments(const Chain& chain, const simd::Kernel* kernel = nullptr);

  /// True where this is faster than the recursion link by link: on this CPU, for n links.
  static bool areWorthwhile(int n);

  /// In words, as "in 8 segments side by side (avx512)".
  std::string name() const;

  /// The order of what comes and goes.
  const Arrangement& arrangement() const { return arrangement_; }

  /// As Articulated::accelerations, of all places: those beyond the end with e = 1 and nothing else.
  /// Allocates nothing. ahead: a row of ode/nystrom.h whose last term is alpha, and which is run on the way
  /// out.
  void accelerations(const Rotation<double>* e, const double* omega, const double* N, const Vec2d* F,
                     Vec2d ground, double* alpha, const simd::NystromSums* ahead = nullptr);

 private:
  const simd::Kernel& kernel_;
  Arrangement arrangement_;
  CacheLines links_, handles_;
};

}  // namespace planar_chain
