#pragma once

/// The exact solve of linearized.h for long chains, in segments that run side by side in SIMD lanes, as those
/// of segments.h do.
///
/// A joint transmits X = (δa, u'), the acceleration of its pin and the turning of its inner body, and Y =
/// (force, moment) from the inner body. A segment whose outer joint transmits a still unknown Y' has
///
///     Y = K X + y + G Y'          X' = H X − C Y' + c
///
/// with K = (B h; p q) and y = (b, r) of linearized.h for Y' = 0; and from the outermost body, where G = 1,
/// H = 1 = (H_a, H_u), C = 0, inwards
///
///     t = −(iP·G_f + G_m)         η = H_a zP + H_u             G_f, G_m: rows of force and moment
///     G_f ← G_f + U_R t/D         G_m ← −k̂ t/D
///     H_a ← H_a − η U_Lᵀ/D        H_u ← η k̂/D                  C ← C − η t/D
///
/// c, what X' comes to from X = 0 with Y' = 0, is found by going through the segment once more: that takes
/// less time than to keep H of every body. X', Y' and c stand in axes along the segment's last link, for the
/// reason given in segments.h. Neighbours are joined two by two, and then the pairs, until one is left. With
/// K', y', G', H', C' and c' of the outer one, in the axes of the joint between, and S = (1 + K'C)⁻¹, both
/// show
///
///     K + G S K' H        G S G'        H' (1 − C S K') H        C' + H' C S G'
///     y + G k             c' + H' (c − C k)                      k = S (K' c + y')
///
/// And outwards, from X = 0 at the ground and Y = 0 at the tip: S K' H X + k + S G' Y in the joint between,
/// and the outer one's X = H X − C Y' + c; then within each segment ε + t·Y' stands for ε.

#include <complex>
#include <memory>

#include "lanes/kernel.h"
#include "lanes/lane_order.h"
#include "planar_chain/chain.h"
#include "planar_chain/planar.h"
#include "simd/cache_lines.h"

namespace planar_chain {

/// The factors of each body that are stored for the way in of a solve: all that it reads, or no more than the
/// way out needs. The rest is then computed again. Both give the same bits. Long chains wait for memory,
/// and `least` is faster; short ones are faster with `all` (src/README.md has the figures). whatFits chooses
/// by the size of a cache.
enum class Kept { whatFits, all, least };

/// All factorizations at one state share this.
struct SegmentsState {
  CacheLines links, bodies, masses;
};

template <class Scalar = double>
class LinearizedSegments {
 public:
  /// In segments, or link by link, which is faster for short chains: one segment in one lane. `chain` must
  /// outlive this object. Constructors allocate; the other functions do not.
  LinearizedSegments(const Chain& chain, bool inSegments, const simd::Kernel& kernel,
                     Kept kept = Kept::whatFits);
  LinearizedSegments(LinearizedSegments&&) = default;

  /// Another factorization at the state of `other`: that one is linearized for both.
  template <class Other>
  explicit LinearizedSegments(const LinearizedSegments<Other>& other, Kept kept = Kept::whatFits)
      : LinearizedSegments(other.chain_, other.kernels_, other.laneOrder_, other.state_, kept) {}

  /// The order of all arrays below, paddedSize() numbers a quantity. Numbers beyond the end have e = 1 and
  /// zeros.
  const LaneOrder& laneOrder() const { return laneOrder_; }

  /// k (N m/rad), d (N m s/rad) of each joint, with whatever acts like a spring or damper there; 0 before.
  void setJoints(const double* k, const double* d);
  /// The state to linearize at: e = exp(i θ_j), ω (rad/s), α (rad/s²), and what acts: F (N) outer forces
  /// without gravity and XF = Σ X·F (N m) of each body, both nullptr where there are none.
  void linearize(const Rotation<double>* e, const double* omega, const double* alpha, const Vec2d* F,
                 const double* XF);
  /// Factors s·1 − J at the state of the last linearize().
  void factor(Scalar s);
  /// [u; v] = (s·1 − J)⁻¹ [ρ_q; ρ_v]. The results may stand in the same place.
  void solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v);

 private:
  template <class Other>
  friend class LinearizedSegments;

  LinearizedSegments(const Chain& chain, const simd::LinearKernels& kernels, const LaneOrder& laneOrder,
                     std::shared_ptr<SegmentsState> state, Kept kept);

  const Chain& chain_;
  const simd::LinearKernels& kernels_;
  LaneOrder laneOrder_;
  const simd::LinearKernel* solver_;
  Scalar s_{};
  std::shared_ptr<SegmentsState> state_;
  CacheLines inward_, factors_, outward_, sweeps_, pairs_;
  simd::LinearArrays arrays_;  ///< all of these
};

}  // namespace planar_chain
