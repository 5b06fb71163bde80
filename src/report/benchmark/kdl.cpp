#include <kdl/chain.hpp>
#include <kdl/chainfdsolver_recursive_newton_euler.hpp>
#include <kdl/chainhdsolver_vereshchagin.hpp>

#include "report/benchmark/peer.h"

/// ChainFdSolver_RNE, which is O(n³), for short chains, and ChainHdSolver_Vereshchagin without constraints,
/// which is O(n), for the others.

namespace planar_chain::benchmarks {

namespace {

KDL::Chain segmentsOf(const Chain& chain) {
  KDL::Chain segments;
  for (const Link& link : chain.links()) {
    // Inertia is given at the outer pin, in its axes.
    const KDL::Vector pin(link.pin.x, link.pin.y, 0), com(link.com.x, link.com.y, 0);
    const KDL::RotationalInertia inertia(link.inertia, link.inertia, link.inertia);
    segments.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ), KDL::Frame(pin),
                                     KDL::RigidBodyInertia(link.mass, com - pin, inertia)));
  }
  return segments;
}

constexpr int longestByMatrix = 5;

class Kdl : public Peer {
 public:
  explicit Kdl(const Chain& chain)
      : segments_(segmentsOf(chain)),
        gravity_(chain.gravity().x, chain.gravity().y, 0),
        byMatrix_(segments_, gravity_),
        byRecursion_(segments_, KDL::Twist(-gravity_, KDL::Vector::Zero()), 0),
        noForces_(segments_.getNrOfSegments(), KDL::Wrench::Zero()),
        q_(segments_.getNrOfJoints()),
        qd_(q_.rows()),
        qdd_(q_.rows()),
        noTorques_(q_.rows()),
        constraintTorques_(q_.rows()) {}

  void place(const Posture& posture) override {
    for (unsigned i = 0; i < q_.rows(); ++i) {
      q_(i) = posture.q[i];
      qd_(i) = posture.qd[i];
    }
  }
  void evaluate() override {
    if (q_.rows() <= longestByMatrix) {
      byMatrix_.CartToJnt(q_, qd_, noTorques_, noForces_, qdd_);
    } else {
      byRecursion_.CartToJnt(q_, qd_, qdd_, noConstraints_, noSetpoints_, noForces_, noTorques_,
                             constraintTorques_);
    }
  }
  void read(double* qdd) const override { std::copy(qdd_.data.begin(), qdd_.data.end(), qdd); }

 private:
  KDL::Chain segments_;  // the solvers keep references
  KDL::Vector gravity_;
  KDL::ChainFdSolver_RNE byMatrix_;
  KDL::ChainHdSolver_Vereshchagin byRecursion_;
  KDL::Jacobian noConstraints_{0};
  KDL::JntArray noSetpoints_{0};
  std::vector<KDL::Wrench> noForces_;
  KDL::JntArray q_, qd_, qdd_, noTorques_, constraintTorques_;
};

}  // namespace

PeerKind kdl() {
  return {"KDL", KDL_VERSION_TEXT,
          1,     10000,
          1e-6,  [](const Chain& chain) -> std::unique_ptr<Peer> { return std::make_unique<Kdl>(chain); }};
}

}  // namespace planar_chain::benchmarks
