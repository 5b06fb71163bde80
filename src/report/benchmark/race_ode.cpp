#include <ode/ode.h>

#include <deque>

#include "report/benchmark/race.h"

/// Open Dynamics Engine: bodies in space, hinges as constraints, dWorldStep, which solves them exactly;
/// Euler.

namespace planar_chain::benchmarks {

namespace {

class OdeRun : public NativeRun {
 public:
  OdeRun(const Contest& contest, double setting) : NativeRun(contest, setting, 1) {
    dInitODE2(0);
    world_ = dWorldCreate();
    const Chain& chain = contest.scene.chain;
    dWorldSetGravity(world_, chain.gravity().x, chain.gravity().y, 0);
    double theta = 0, omega = 0;
    Vec2d pin, pinVelocity;
    for (int i = 0; i < chain.size(); ++i) {
      const Link& link = chain.links()[static_cast<std::size_t>(i)];
      theta += contest.scene.q[static_cast<std::size_t>(i)];
      omega += contest.scene.qd[static_cast<std::size_t>(i)];
      const auto e = Rotation<double>::of(theta);
      const Vec2d arm = e * link.com, outer = e * link.pin;
      const dBodyID body = dBodyCreate(world_);
      dMass mass;
      dMassSetParameters(&mass, link.mass, 0, 0, 0, link.inertia, link.inertia, link.inertia, 0, 0, 0);
      dBodySetMass(body, &mass);
      dMatrix3 rotation;
      dRFromAxisAndAngle(rotation, 0, 0, 1, theta);
      dBodySetRotation(body, rotation);
      dBodySetPosition(body, pin.x + arm.x, pin.y + arm.y, 0);
      dBodySetLinearVel(body, pinVelocity.x - omega * arm.y, pinVelocity.y + omega * arm.x, 0);
      dBodySetAngularVel(body, 0, 0, omega);
      const dJointID hinge = dJointCreateHinge(world_, nullptr);
      dJointAttach(hinge, body, bodies_.empty() ? nullptr : bodies_.back());
      dJointSetHingeAnchor(hinge, pin.x, pin.y, 0);
      dJointSetHingeAxis(hinge, 0, 0, 1);
      bodies_.push_back(body);
      hinges_.push_back(hinge);
      pin += outer;
      pinVelocity += omega * Vec2d{-outer.y, outer.x};
      starts_.push_back(contest.scene.q[static_cast<std::size_t>(i)]);
      turns_.push_back(0);
      lastAngles_.push_back(0);
    }
  }
  ~OdeRun() override {
    dWorldDestroy(world_);
    dCloseODE();
  }

 protected:
  bool stepBy(double h) override {
    dWorldStep(world_, h);
    // A hinge counts from −π to π.
    for (std::size_t i = 0; i < hinges_.size(); ++i) {
      const double angle = dJointGetHingeAngle(hinges_[i]);
      turns_[i] -= std::round((angle - lastAngles_[i]) / turn);
      lastAngles_[i] = angle;
    }
    return true;
  }
  double q(int i) const override {
    const auto k = static_cast<std::size_t>(i);
    return starts_[k] + lastAngles_[k] + turn * turns_[k];
  }
  double qd(int i) const override { return dJointGetHingeAngleRate(hinges_[static_cast<std::size_t>(i)]); }

 private:
  static constexpr double turn = 2 * 3.14159265358979323846;

  dWorldID world_;
  std::vector<dBodyID> bodies_;
  std::vector<dJointID> hinges_;
  std::vector<double> starts_, turns_, lastAngles_;
};

bool takes(const Scene& scene) {
  return isPinned(scene) && scene.loads.empty() && !hasSprings(scene) && scene.chain.size() <= 20 &&
         !hasPoints(scene);
}

}  // namespace

Team odeTeam() {
  return {"ODE", "dWorldStep, hinges as constraints", {contestant<OdeRun>("ODE", "Euler", true, takes)}};
}

}  // namespace planar_chain::benchmarks
