#include <algorithm>

#include "report/benchmark/peer.h"
#include "report/benchmark/pinocchio_chain.h"

/// The articulated-body algorithm in the world frame, header-only, for this processor.

namespace planar_chain::benchmarks {

namespace {

class Pinocchio : public Peer {
 public:
  explicit Pinocchio(const Chain& chain) : n_(chain.size()), chain_(pinocchioChain(chain)) {}
  void place(const Posture& posture) override { chain_->place(posture.q.data(), posture.qd.data()); }
  void evaluate() override { qdd_ = chain_->accelerations(); }
  void read(double* qdd) const override { std::copy_n(qdd_, n_, qdd); }

 private:
  int n_;
  std::unique_ptr<PinocchioChain> chain_;
  const double* qdd_ = nullptr;
};

}  // namespace

PeerKind pinocchio() {
  return {"Pinocchio",
          pinocchioVersion(),
          1,
          100,
          1e-6,
          [](const Chain& chain) -> std::unique_ptr<Peer> { return std::make_unique<Pinocchio>(chain); }};
}

}  // namespace planar_chain::benchmarks
