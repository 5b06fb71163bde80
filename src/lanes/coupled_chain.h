#pragma once

/// The recursion of coupled.h, by the kernel of this CPU. Short chains run link by link: what does not depend
/// on the neighbours is computed for several links at a time, and only links beside a coupling take part in
/// it. Long chains are cut into segments that lie side by side in lanes.
///
/// A segment ends between two bodies. The force and the moment φ = (f, μ) that the next segment needs at its
/// inner pin are still unknown. With x = (a, α_p) inside of the segment and y = (a, α) of its outer end, as
/// in segments.h
///
///     (F_in, μ_in) = K x + (b, c) + G φ          y = Gᵀ x − C φ + c_y          K = [A H; Hᵀ Q]
///
/// A, H, Q, b and c are those of coupled.h with φ = 0. G starts as 1, C and c_y as 0, and from there inwards,
/// with the rows G_f and G_μ of G,
///
///     g = G_fᵀ iP + G_μ           C ← C + g gᵀ/D         c_y ← c_y + g (ε/D + q̈) − ω² G_fᵀ P
///     G_f ← G_f − U gᵀ/D          G_μ ← κ g
///
/// Neighbours are joined as in linearized_segments.h. Outwards ε − g·φ takes the place of ε. All segments
/// together show the ends of the chain what these need (recursion/ended.h), with φ = −λ at the tip.

#include <string>
#include <vector>

#include "lanes/arrangement.h"
#include "lanes/kernel.h"
#include "planar_chain/chain.h"
#include "recursion/ended.h"
#include "recursion/load_kind.h"
#include "simd/cache_lines.h"

namespace planar_chain {

class CoupledChain {
 public:
  /// Uses the best kernel of this CPU for so many links. Allocates.
  explicit CoupledChain(const Chain& chain);
  CoupledChain(const Chain& chain, const simd::Kernel& kernel, bool inSegments);

  /// A description.
  std::string name() const;

  /// Takes the couplings of all joints from now on.
  void couple(const Coupling<double>* joints);
  /// Writes α, rad/s², and μ of each joint, N m. omega, turning: as Ended<double>::accelerations. Writes
  /// outside.e, with room for ShortChain::roomFor(n) rotations, or reads it if theta is nullptr. outside.F
  /// may be nullptr. Returns F_pin of the first body, N. Allocates nothing.
  Vec2d accelerations(const Outside& outside, const double* theta, const double* omega, double turning,
                      double* alpha, double* moments);
  /// The same of a chain with ends (recursion/ended.h), on a base of acceleration outside.ground.
  void accelerations(const Outside& outside, const double* theta, const double* omega, double turning,
                     const InnerEnd<double>& inner, const Tip<double>& tip, double* alpha, double* moments,
                     EndsMotion<double>& motion);

 private:
  void run(simd::CoupledRun simd::CoupledKernel::*kind, const Outside& outside, const double* theta,
           const double* omega, double turning, const simd::CoupledResults& to);
  bool isCut() const { return arrangement_.lanes() > 1; }

  const simd::Kernel& kernel_;
  Arrangement arrangement_;  ///< of one lane: link by link
  CacheLines links_, joints_, handles_, pairs_;
  std::vector<char> couples_;
  // In lane order.
  AlignedArray<Rotation<double>> e_;
  AlignedArray<Vec2d> F_;
  CacheLines omega_, N_, alpha_, moments_;
};

}  // namespace planar_chain
