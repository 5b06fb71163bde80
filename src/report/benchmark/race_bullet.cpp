#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletCollisionCommon.h>

#include "report/benchmark/bullet_body.h"
#include "report/benchmark/race.h"

/// btMultiBodyDynamicsWorld::stepSimulation with nothing to collide, in double precision.

namespace planar_chain::benchmarks {

namespace {

class BulletRun : public NativeRun {
 public:
  BulletRun(const Contest& contest, double setting, bool rk4)
      : NativeRun(contest, setting, rk4 ? 4 : 1),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_),
        body_(bodyOf(contest.scene.chain)) {
    const Vec2d gravity = contest.scene.chain.gravity();
    world_.setGravity(btVector3(gravity.x, gravity.y, 0));
    body_->setMaxCoordinateVelocity(1e100);
    body_->useRK4Integration(rk4);
    for (int i = 0; i < contest.scene.chain.size(); ++i) {
      body_->setJointPos(i, contest.scene.q[static_cast<std::size_t>(i)]);
      body_->setJointVel(i, contest.scene.qd[static_cast<std::size_t>(i)]);
    }
    btAlignedObjectArray<btQuaternion> turns;
    btAlignedObjectArray<btVector3> places;
    body_->forwardKinematics(turns, places);
    world_.addMultiBody(body_.get());
  }
  ~BulletRun() override { world_.removeMultiBody(body_.get()); }

 protected:
  bool stepBy(double h) override {
    world_.stepSimulation(h, 0);
    return true;
  }
  double q(int i) const override { return body_->getJointPos(i); }
  double qd(int i) const override { return body_->getJointVel(i); }

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_;
  std::unique_ptr<btMultiBody> body_;
};

bool takes(const Scene& scene) {
  return scene.loads.empty() && !hasSprings(scene) && scene.chain.size() <= 1000;
}

}  // namespace

Team bulletTeam() {
  const int version = btGetVersion();
  return {"Bullet",
          std::to_string(version / 100) + "." + std::to_string(version % 100) + " (double precision)",
          {contestant<BulletRun>("Bullet", "Euler", true, takes, false),
           contestant<BulletRun>("Bullet", "RK4", true, takes, true)}};
}

}  // namespace planar_chain::benchmarks
