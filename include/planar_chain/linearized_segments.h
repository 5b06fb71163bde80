#pragma once

/// The exact solve of linearized.h for long chains, in segments that run side by side in SIMD lanes, as those
/// of segments.h do.
///
/// What passes a joint: X = (δa, u'), how its pin accelerates and its inner body turns, and Y = (force,
/// moment), what the inner body gives. A segment whose outer joint bears a still unknown Y' shows
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
/// reason given in segments.h. The segments are joined from the tip, with (K', y') of all that lies outside a
/// segment:
///
///     S = (1 + K'C)⁻¹        K' ← K + G S K' H        y' ← y + G S (K' c + y')
///
/// and gone through from the ground: Y' = S (K' (H X + c) + y'), the next X = H X − C Y' + c, and within each
/// ε + t·Y' stands for ε.

#include <Eigen/Core>
#include <complex>
#include <memory>
#include <vector>

#include "planar_chain/cache_lines.h"
#include "planar_chain/chain.h"
#include "planar_chain/planar.h"

namespace planar_chain {

namespace simd {
struct Kernel;
struct LinearKernel;
struct LinearArrays;
}  // namespace simd

/// What all factorizations at one state share.
struct SegmentsState {
  CacheLines links, joints, bodies;
  std::vector<Rotation<double>> frames;  ///< axes of each segment's outer pin
};

template <class Scalar = double>
class LinearizedSegments {
 public:
  /// The best kernel of this CPU for so many links, or the one given.
  explicit LinearizedSegments(const Chain& chain, const simd::Kernel* kernel = nullptr);

  /// Another factorization at the state of `other`, whenever that is linearized.
  template <class Other>
  explicit LinearizedSegments(const LinearizedSegments<Other>& other);

  /// True where this is faster than the solve link by link: on this CPU, for n links.
  static bool areWorthwhile(int n);

  /// As those of Linearized. They allocate nothing.
  void setJoints(const double* k, const double* d);
  void linearize(const Rotation<double>* e, const double* omega, const double* alpha, const Vec2d* F,
                 const double* XF);
  void factor(Scalar s);
  void solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v);

 private:
  template <class Other>
  friend class LinearizedSegments;

  using Matrix = Eigen::Matrix<Scalar, 3, 3, Eigen::DontAlign>;
  using Vector = Eigen::Matrix<Scalar, 3, 1, Eigen::DontAlign>;

  /// A segment, and what is joined to it.
  struct Joined {
    Matrix G, H, C, S, SK, frame;
    Vector c, y;  ///< y: S (K' c + y')
  };
  void reserve();
  simd::LinearArrays arrays();

  const Chain& chain_;
  const simd::Kernel& kernel_;
  const simd::LinearKernel& solver_;
  int n_, steps_;
  Scalar s_{};
  std::shared_ptr<SegmentsState> state_;
  CacheLines inward_, handles_, outward_, sweeps_;
  std::vector<Joined> joined_;
};

}  // namespace planar_chain
