#include "report/benchmark/peer.h"

namespace planar_chain::benchmarks {

const std::vector<PeerKind>& peers() {
  static const std::vector<PeerKind> peers{
      planarChain(), closedForm(), denseCholesky(),
#ifdef WITH_BULLET
      bullet(),
#endif
#ifdef WITH_DART
      dart(),
#endif
#ifdef WITH_KDL
      kdl(),
#endif
#ifdef WITH_MUJOCO
      mujoco(),
#endif
#ifdef WITH_PINOCCHIO
      pinocchio(),
#endif
#ifdef WITH_SIMBODY
      simbody(),
#endif
  };
  return peers;
}

}  // namespace planar_chain::benchmarks
