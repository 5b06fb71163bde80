#include <dart/config.hpp>

#include "report/benchmark/dart_skeleton.h"
#include "report/benchmark/peer.h"

/// Skeleton::computeForwardDynamics: articulated bodies.

namespace planar_chain::benchmarks {

namespace {

class Dart : public Peer {
 public:
  explicit Dart(const Chain& chain) : skeleton_(skeletonOf(chain)) {}

  void place(const Posture& posture) override {
    q_ = Eigen::Map<const Eigen::VectorXd>(posture.q.data(), static_cast<Eigen::Index>(posture.q.size()));
    qd_ = Eigen::Map<const Eigen::VectorXd>(posture.qd.data(), q_.size());
  }

  void evaluate() override {
    skeleton_->setPositions(q_);
    skeleton_->setVelocities(qd_);
    skeleton_->computeForwardDynamics();
  }

  void read(double* qdd) const override {
    Eigen::Map<Eigen::VectorXd>(qdd, q_.size()) = skeleton_->getAccelerations();
  }

 private:
  dart::dynamics::SkeletonPtr skeleton_;
  Eigen::VectorXd q_, qd_;
};

}  // namespace

PeerKind dart() {
  return {"DART", DART_VERSION,
          1,      1000,
          1e-6,   [](const Chain& chain) -> std::unique_ptr<Peer> { return std::make_unique<Dart>(chain); }};
}

}  // namespace planar_chain::benchmarks
