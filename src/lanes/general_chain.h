#pragma once

/// The recursion of general.h, by the kernel of this CPU. Short chains run link by link: what does not depend
/// on the neighbours is computed for several links at a time, and each joint pays for its own kind alone.
/// Long chains are cut into segments that lie side by side in lanes; prismatic joints before the first
/// revolute one then stay outside.
///
/// A segment ends between two bodies. The force and the moment φ = (f, μ) that the next segment needs at its
/// inner pin are still unknown. With x = (a, α_p) inside of the segment and y = (a, α) of its outer end, as
/// in segments.h
///
///     (F_in, μ_in) = K x + (b, c) + G φ          y = Gᵀ x − C φ + c_y          K = [A H; Hᵀ Q]
///
/// A, H, Q, b and c are those of general.h with φ = 0. G starts as 1, C and c_y as 0; from there inwards they
/// follow the rules of general.h for the tip, with three columns in place of two, and φ = −λ. Neighbours are
/// joined as in linearized_segments.h.

#include <string>
#include <vector>

#include "lanes/kernel.h"
#include "lanes/lane_order.h"
#include "planar_chain/chain.h"
#include "recursion/general_recursion.h"
#include "recursion/load_kind.h"
#include "simd/cache_lines.h"

namespace planar_chain {

class GeneralChain {
 public:
  /// In segments, or link by link. basePays: the base moves, so its wrench is asked for. Allocates.
  GeneralChain(const Chain& chain, const simd::Kernel& kernel, bool inSegments, bool basePays = true);

  /// A description.
  std::string name() const;

  /// Takes the laws of all joints from now on.
  void take(const JointLaw<double>* laws);
  /// As GeneralRecursion::accelerations(), with the moments, forces and base of `external` and the laws of
  /// take(). Writes external.e, with room for ShortChain::roomFor(n) rotations; or reads it if theta, the
  /// angles of the bodies, is nullptr. Writes the wrench of the base to `ends` only if basePays or the tip is
  /// held, the force on the tip only then. Allocates nothing.
  void accelerations(const Loads& external, const double* theta, const double* omega,
                     const Displacement<double>* displaced, double turning, const Tip<double>& tip,
                     double* xdd, double* moments, EndForces<double>& ends);

 private:
  bool isCut() const { return laneOrder_.lanes() > 1; }
  void toLaneOrder(const Loads& external, const double* omega, const Displacement<double>* displaced);
  void run(simd::GeneralRun simd::GeneralKernel::*kind, const Loads& external, const double* theta,
           const double* omega, const Displacement<double>* displaced, double turning,
           const simd::GeneralResults& to);

  const simd::Kernel& kernel_;
  bool basePays_;
  int leading_;   ///< joints outside of the segments
  bool isMixed_;  ///< there are prismatic joints in segments
  std::vector<JointLaw<double>> laws_;
  std::vector<Body<double>> bodies_;  ///< of leading joints
  std::vector<bool> isPrismatic_;
  LaneOrder laneOrder_;  ///< of one lane: link by link
  CacheLines links_, joints_, terms_, pairs_, displaced_;
  std::vector<simd::JointKind> kinds_;
  // In lane order.
  AlignedArray<Rotation<double>> e_;
  AlignedArray<Vec2d> F_;
  CacheLines omega_, N_, xdd_, moments_;
};

}  // namespace planar_chain
