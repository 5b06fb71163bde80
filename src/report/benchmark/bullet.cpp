#include "report/benchmark/bullet_body.h"
#include "report/benchmark/peer.h"

/// btMultiBody: articulated bodies in space, in double precision.

namespace planar_chain::benchmarks {

namespace {

class Bullet : public Peer {
 public:
  explicit Bullet(const Chain& chain) : n_(chain.size()), body_(bodyOf(chain)) {
    for (int i = 0; i < n_; ++i) {
      const Vec2d weight = chain.links()[static_cast<std::size_t>(i)].mass * chain.gravity();
      body_->addLinkForce(i, btVector3(weight.x, weight.y, 0));
    }
  }

  void place(const Posture& posture) override { posture_ = posture; }

  void evaluate() override {
    for (int i = 0; i < n_; ++i) {
      body_->setJointPos(i, posture_.q[static_cast<std::size_t>(i)]);
      body_->setJointVel(i, posture_.qd[static_cast<std::size_t>(i)]);
    }
    body_->computeAccelerationsArticulatedBodyAlgorithmMultiDof(0, numbers_, vectors_, matrices_, false,
                                                                false, false);
  }

  void read(double* qdd) const override {
    // n scratch numbers, then the base's six accelerations.
    for (int i = 0; i < n_; ++i) qdd[i] = numbers_[n_ + 6 + i];
  }

 private:
  int n_;
  std::unique_ptr<btMultiBody> body_;
  Posture posture_;
  btAlignedObjectArray<btScalar> numbers_;
  btAlignedObjectArray<btVector3> vectors_;
  btAlignedObjectArray<btMatrix3x3> matrices_;
};

}  // namespace

PeerKind bullet() {
  const int version = btGetVersion();
  return {
      "Bullet", std::to_string(version / 100) + "." + std::to_string(version % 100),
      1,        10000,
      1e-6,     [](const Chain& chain) -> std::unique_ptr<Peer> { return std::make_unique<Bullet>(chain); }};
}

}  // namespace planar_chain::benchmarks
