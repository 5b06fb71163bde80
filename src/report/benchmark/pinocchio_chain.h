#pragma once

/// A chain in Pinocchio, springs and dampers included. It is compiled for this processor, in a library of its
/// own: Eigen's alignment depends on the instructions that may be used.

#include <memory>

#include "planar_chain/chain.h"

namespace planar_chain::benchmarks {

class PinocchioChain {
 public:
  virtual ~PinocchioChain() = default;
  /// Relative coordinates and rates, n values each.
  virtual void place(const double* q, const double* qd) = 0;
  /// q̈ of what was placed.
  virtual const double* accelerations() = 0;
};

/// At most 100 links: the memory of Pinocchio's data grows like n³.
__attribute__((visibility("default"))) std::unique_ptr<PinocchioChain> pinocchioChain(const Chain& chain);
__attribute__((visibility("default"))) const char* pinocchioVersion();

}  // namespace planar_chain::benchmarks
