#pragma once

/// The constants of a chain: its bodies, and the kernel of its recursion, which is chosen once by the length
/// and the processor. All computations with the chain share them.

#include <optional>
#include <variant>

#include "lanes/general_chain.h"
#include "lanes/lane_order.h"
#include "lanes/segments.h"
#include "lanes/short_chain.h"
#include "planar_chain/scene.h"
#include "recursion/pose.h"

namespace planar_chain {

/// The recursion for q̈ of a bare chain, with its room: written out for short chains, in segments for long
/// ones.
using Recursion = std::variant<ShortChain, Segments>;

class Mechanism {
 public:
  /// The scene must outlive this object. inOrder: a long chain is kept in chain order too.
  Mechanism(const Scene& scene, bool inOrder);

  const Chain& chain() const { return chain_; }
  int size() const { return n_; }  ///< n
  const Coordinates& coordinates() const { return chain_.coordinates(); }
  /// The order of a long chain's bodies, in which its states are kept; nullptr: chain order.
  const LaneOrder* lanes() const { return lanes_ ? &*lanes_ : nullptr; }
  /// The numbers that one quantity of all bodies takes in that order: n, or more.
  int paddedSize() const { return paddedSize_; }
  /// The kernels of all that computes with this chain, and the one for its length.
  simd::KernelChoice kernelChoice() const { return kernelChoice_; }
  const simd::Kernel& kernel() const { return kernel_; }
  Recursion makeRecursion() const;
  GeneralChain makeGeneralRecursion(bool basePays) const;
  /// As rotations() of lanes/segments.h.
  void rotate(const double* theta, Rotation<double>* e, int n) const { rotations_(theta, &e->c, n); }
  /// Writes the rotations of all n bodies in chain order, from their coordinates, on a base that is turned by
  /// `angle`. Allocates nothing.
  void rotate(const double* x, double angle, Rotation<double>* e) const;
  /// Writes the angles of all bodies from their coordinates, on a base with this angle; and likewise rates.
  void toBodies(const double* x, double ofBase, double* angles) const;

  /// [θ ω] from chain order to lane order and back; not in place. Allocate nothing.
  void toLaneOrder(const double* inOrder, double* inLanes) const;
  void toChainOrder(const double* inLanes, double* inOrder) const;
  /// One number of each body.
  const double* quantityInLanes(const double* values, double* room) const;
  /// [θ ω] in chain order: copied to `room`, or as it stands where that is the order already.
  const double* stateInOrder(const double* y, double* room) const;

  /// Writes the velocities of the first `count` inner pins of a bare chain, m/s, from e = exp(i θ_j) and the
  /// rates ω_j in chain order. Allocates nothing.
  void findPinVelocities(const Rotation<double>* e, const double* omega, int count, Vec2d* velocities) const;

 private:
  const Chain& chain_;
  int n_;
  simd::KernelChoice kernelChoice_;
  const simd::Kernel& kernel_;
  std::optional<LaneOrder> lanes_;
  int paddedSize_;
  void (*rotations_)(const double* theta, double* e, int n);
};

}  // namespace planar_chain
