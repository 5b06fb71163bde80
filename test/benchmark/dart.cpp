#include <dart/config.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>

#include "peer.h"

/// Skeleton::computeForwardDynamics: articulated bodies.

namespace planar_chain::benchmarks {

namespace {

class Dart : public Peer {
 public:
  explicit Dart(const Chain& chain) : skeleton_(dart::dynamics::Skeleton::create("chain")) {
    skeleton_->setGravity({chain.gravity().x, chain.gravity().y, 0});
    dart::dynamics::BodyNode* before = nullptr;
    Vec2d pinBefore;
    for (const Link& link : chain.links()) {
      dart::dynamics::RevoluteJoint::Properties joint;
      joint.mName = link.name + "_joint";
      joint.mAxis = Eigen::Vector3d::UnitZ();
      joint.mT_ParentBodyToJoint.translation() << pinBefore.x, pinBefore.y, 0;
      dart::dynamics::BodyNode::Properties body;
      body.mName = link.name;
      const Eigen::Vector3d com(link.com.x, link.com.y, 0);
      const Eigen::Matrix3d inertia = link.inertia * Eigen::Matrix3d::Identity();
      body.mInertia = dart::dynamics::Inertia(link.mass, com, inertia);
      before = skeleton_
                   ->createJointAndBodyNodePair<dart::dynamics::RevoluteJoint, dart::dynamics::BodyNode>(
                       before, joint, body)
                   .second;
      pinBefore = link.pin;
    }
  }

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
