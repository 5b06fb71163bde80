#pragma once

/// Whoever computes q̈ of a chain without springs, dampers and loads: this program, what an expert would write
/// by hand, and other programs, each by its shortest way.

#include <memory>
#include <string>
#include <vector>

#include "planar_chain/chain.h"
#include "report/benchmark/chains.h"

namespace planar_chain::benchmarks {

class Peer {
 public:
  virtual ~Peer() = default;
  /// Takes a state, in the peer's own coordinates. Not timed.
  virtual void place(const Posture& posture) = 0;
  /// From the angles and rates placed to accelerations; everything that depends on them is computed anew.
  /// This is what is timed.
  virtual void evaluate() = 0;
  /// q̈ of the last evaluate(), n values. Not timed.
  virtual void read(double* qdd) const = 0;
};

struct PeerKind {
  std::string name, version;
  int shortest, longest;  ///< chains that are measured; longer ones take minutes or many gigabytes
  double agreement;       ///< how far its q̈ may be off, in units of the largest q̈
  std::unique_ptr<Peer> (*make)(const Chain&);
};

/// Returns the programs that this benchmark is built with; this program first.
const std::vector<PeerKind>& peers();

/// q̈_i = α_i − α_{i−1}
inline void makeRelative(const double* alpha, int n, double* qdd) {
  for (int i = 0; i < n; ++i) qdd[i] = relative(alpha, i);
}

// Each in a file of its own.
PeerKind planarChain();
PeerKind closedForm();
PeerKind denseCholesky();
PeerKind bullet();
PeerKind dart();
PeerKind kdl();
PeerKind mujoco();
PeerKind pinocchio();
PeerKind simbody();

}  // namespace planar_chain::benchmarks
