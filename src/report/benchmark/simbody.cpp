#include "report/benchmark/peer.h"
#include "report/benchmark/simbody_pins.h"

/// calcAccelerationIgnoringConstraints: articulated bodies. Gravity is a force that never changes.

namespace planar_chain::benchmarks {

namespace {

class Simbody : public Peer {
 public:
  explicit Simbody(const Chain& chain) : matter_(system_) {
    noTorques_.resize(chain.size());
    noTorques_ = 0;
    weights_.resize(chain.size() + 1);
    weights_ = SimTK::SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0));
    SimbodyPins pins(matter_);
    for (int i = 0; i < chain.size(); ++i) {
      const Link& link = chain.links()[static_cast<std::size_t>(i)];
      const Vec2d weight = link.mass * chain.gravity();
      const SimTK::MobilizedBody body = pins.add(link, chain.joints()[static_cast<std::size_t>(i)]);
      weights_[body.getMobilizedBodyIndex()][1] = SimTK::Vec3(weight.x, weight.y, 0);
    }
    state_ = system_.realizeTopology();
    system_.realizeModel(state_);
  }

  void place(const Posture& posture) override { posture_ = posture; }

  void evaluate() override {
    std::copy(posture_.q.begin(), posture_.q.end(), state_.updQ().updContiguousScalarData());
    std::copy(posture_.qd.begin(), posture_.qd.end(), state_.updU().updContiguousScalarData());
    system_.realize(state_, SimTK::Stage::Dynamics);
    matter_.calcAccelerationIgnoringConstraints(state_, noTorques_, weights_, qdd_, bodies_);
  }

  void read(double* qdd) const override {
    for (int i = 0; i < qdd_.size(); ++i) qdd[i] = qdd_[i];
  }

 private:
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::State state_;
  Posture posture_;
  SimTK::Vector noTorques_, qdd_;
  SimTK::Vector_<SimTK::SpatialVec> weights_, bodies_;
};

}  // namespace

PeerKind simbody() {
  int major, minor, build;
  SimTK_version_simbody(&major, &minor, &build);
  return {"Simbody",
          std::to_string(major) + "." + std::to_string(minor),
          1,
          10000,
          1e-6,
          [](const Chain& chain) -> std::unique_ptr<Peer> { return std::make_unique<Simbody>(chain); }};
}

}  // namespace planar_chain::benchmarks
