#pragma once

/// The recursion of articulated.h for long chains, which are cut into segments. SIMD lanes compute the
/// segments side by side.
///
/// In the recursion each link needs the result of the previous one, so a core spends most of its time
/// waiting. The next segment exerts a force −f on the outer pin of a segment. This force is still unknown.
/// The force on the inner pin and the acceleration of the outer pin are linear in f and in the acceleration a
/// of the inner pin:
///
///     F_in = A a + b + G f          a_out = Gᵀ a − C f + c
///
/// A and b are those of articulated.h with f = 0. G, C and c start at the outermost body, where C = 0 and
/// c = 0. From there inwards
///
///     g = Gᵀ iP        C ← C + g gᵀ/D        c ← c + g u/D − ω² Gᵀ P        G ← G − U gᵀ/D
///
/// f, C and c have components along the outer pin's own axes: d, along the segment's last link, and i d. So G
/// starts as (d, i d). The reason: a taut segment yields across its length (C ≈ 1/m) and hardly at all along
/// it. In its own axes the small part is computed from a small g. In ground axes it would be lost in the
/// rounding of the large part, and a heavy tip would multiply that error by its mass.
///
/// Neighbours are joined two by two, and then the pairs, until one is left. A', b', C', c' and G' belong to
/// the outer one, with A', b' and G' turned into the axes of the pin between. With K = (1 + A'C)⁻¹ the two
/// together have
///
///     A + G K A' Gᵀ        b + G k        G K G'        C' + G'ᵀ C K G'        c' + G'ᵀ (c − C k)
///
/// where k = K (A' c + b'). Then the sweep goes outwards, from a of the ground pin and f' = 0 at the tip. At
/// the pin between two neighbours f = K A' Gᵀ a + k + K G' f'. The outer one has a = Gᵀ a − C f + c, turned
/// back into ground axes. Within each segment
///
///     α = u/D − (g/D)·f − (U/D)·a        a ← a + iα P − ω² P
///
/// The result is as exact as that of the recursion. The kernel is chosen once, by the CPU and the length of
/// the chain.

#include <string>

#include "lanes/lane_order.h"
#include "planar_chain/chain.h"
#include "planar_chain/planar.h"
#include "simd/cache_lines.h"

namespace planar_chain {

namespace simd {
struct Kernel;
}  // namespace simd

/// m, I, r and p of the links in rows of lanes: lane s of step i is link s·apart + i·next. Numbers beyond the
/// end of the chain have no mass, no length, and I = 1. Allocates.
CacheLines linksInLanes(const Chain& chain, int lanes, int steps, int apart, int next);
/// linksInLanes() for a chain that is cut into segments.
inline CacheLines linksInLaneOrder(const Chain& chain, const LaneOrder& laneOrder) {
  return linksInLanes(chain, laneOrder.lanes(), laneOrder.steps(), laneOrder.steps(), 1);
}

/// e_j = exp(i θ_j) for n angles, rad, to about 1 ulp for any finite angle. Allocates nothing.
void rotations(const double* theta, Rotation<double>* e, int n);
/// rotations() with the same digits on every x86-64 CPU, up to 1.6e6 rad.
void plainRotations(const double* theta, Rotation<double>* e, int n);
Rotation<double> plainRotation(double theta);

class Segments {
 public:
  /// Allocates.
  Segments(const Chain& chain, const simd::Kernel& kernel);

  /// A description such as "in 8 segments side by side (avx512)".
  std::string name() const;

  /// The order of all arguments of accelerations().
  const LaneOrder& laneOrder() const { return laneOrder_; }

  /// As the recursion of articulated.h, link by link, with paddedSize() numbers per quantity. Numbers beyond
  /// the end have e = 1 and zeros. Allocates nothing.
  void accelerations(const Rotation<double>* e, const double* omega, const double* N, const Vec2d* F,
                     Vec2d ground, double* alpha);

 private:
  const simd::Kernel& kernel_;
  LaneOrder laneOrder_;
  CacheLines links_, factors_;
};

}  // namespace planar_chain
