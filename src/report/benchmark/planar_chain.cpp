#include "report/benchmark/moving_rods.h"
#include "report/benchmark/peer.h"

/// This program: Dynamics::rates, which every method calls, of a state in lane order.

namespace planar_chain::benchmarks {

namespace {

class PlanarChain : public Peer {
 public:
  explicit PlanarChain(int n) : n_(n) {}
  void place(const Posture& posture) override { rods_ = std::make_unique<MovingRods>(n_, posture); }
  void evaluate() override { rods_->evaluate(); }
  void read(double* qdd) const override {
    rods_->dynamics.toChainOrder(rods_->laneOrderedRates.data(), rods_->dydt.data());
    makeRelative(rods_->dydt.data() + n_, n_, qdd);
  }

 private:
  int n_;
  std::unique_ptr<MovingRods> rods_;
};

}  // namespace

PeerKind planarChain() {
  return {"planar_chain", "", 1, 10000, 1e-6, [](const Chain& chain) -> std::unique_ptr<Peer> {
            return std::make_unique<PlanarChain>(chain.size());
          }};
}

}  // namespace planar_chain::benchmarks
