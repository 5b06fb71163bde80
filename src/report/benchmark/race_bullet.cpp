#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Featherstone/btMultiBodyPoint2Point.h>
#include <btBulletCollisionCommon.h>

#include "report/benchmark/bullet_body.h"
#include "report/benchmark/race.h"

/// btMultiBodyDynamicsWorld::stepSimulation with nothing to collide, in double precision. A held tip is a
/// btMultiBodyPoint2Point.

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
    btAlignedObjectArray<btVector3> positions;
    body_->forwardKinematics(turns, positions);
    world_.addMultiBody(body_.get());
    if (contest.scene.tip) hold(contest.scene);
  }
  ~BulletRun() override {
    if (tip_) {
      world_.removeMultiBodyConstraint(tip_.get());
      world_.removeCollisionObject(collider_.get());
    }
    world_.removeMultiBody(body_.get());
  }

 protected:
  bool stepBy(double h) override {
    world_.stepSimulation(h, 0);
    return true;
  }
  double q(int i) const override { return body_->getJointPos(i); }
  double qd(int i) const override { return body_->getJointVel(i); }

 private:
  void hold(const Scene& scene) {
    const Vec2d position = tipPosition(scene);
    const Link& last = scene.chain.links().back();
    // Constraints of links without a collider are not solved. This one collides with nothing.
    collider_ = std::make_unique<btMultiBodyLinkCollider>(body_.get(), scene.chain.size() - 1);
    collider_->setCollisionShape(&noShape_);
    world_.addCollisionObject(collider_.get(), 0, 0);
    body_->getLink(scene.chain.size() - 1).m_collider = collider_.get();
    tip_ = std::make_unique<btMultiBodyPoint2Point>(
        body_.get(), scene.chain.size() - 1, &ground_,
        btVector3(last.pin.x - last.com.x, last.pin.y - last.com.y, 0), btVector3(position.x, position.y, 0));
    tip_->setMaxAppliedImpulse(1e100);
    world_.addMultiBodyConstraint(tip_.get());
    world_.getSolverInfo().m_numIterations = 1000;
    world_.getSolverInfo().m_leastSquaresResidualThreshold = 1e-24;
    world_.getSolverInfo().m_erp = 1;
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_;
  std::unique_ptr<btMultiBody> body_;
  btRigidBody ground_{0, nullptr, nullptr};
  btEmptyShape noShape_;
  std::unique_ptr<btMultiBodyLinkCollider> collider_;
  std::unique_ptr<btMultiBodyPoint2Point> tip_;  ///< nullptr: free
};

bool takes(const Scene& scene) {
  return hasFixedTip(scene) && scene.loads.empty() && !hasSprings(scene) && scene.chain.size() <= 1000;
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
