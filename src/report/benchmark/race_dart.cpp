#include <dart/config.hpp>
#include <dart/simulation/World.hpp>

#include "report/benchmark/dart_skeleton.h"
#include "report/benchmark/race.h"

/// World::step, semi-implicit Euler, which is all it has.

namespace planar_chain::benchmarks {

namespace {

class DartRun : public NativeRun {
 public:
  DartRun(const Contest& contest, double setting)
      : NativeRun(contest, setting, 1),
        world_(dart::simulation::World::create()),
        skeleton_(skeletonOf(contest.scene.chain)) {
    world_->setGravity({contest.scene.chain.gravity().x, contest.scene.chain.gravity().y, 0});
    world_->setTimeStep(h());
    world_->addSkeleton(skeleton_);
    const auto n = static_cast<Eigen::Index>(contest.scene.q.size());
    skeleton_->setPositions(Eigen::Map<const Eigen::VectorXd>(contest.scene.q.data(), n));
    skeleton_->setVelocities(Eigen::Map<const Eigen::VectorXd>(contest.scene.qd.data(), n));
  }

 protected:
  bool stepBy(double) override {
    world_->step();
    return true;
  }
  double q(int i) const override { return skeleton_->getPosition(static_cast<std::size_t>(i)); }
  double qd(int i) const override { return skeleton_->getVelocity(static_cast<std::size_t>(i)); }

 private:
  dart::simulation::WorldPtr world_;
  dart::dynamics::SkeletonPtr skeleton_;
};

bool takes(const Scene& scene) {
  return isPinned(scene) && scene.loads.empty() && scene.chain.size() <= 100;
}

}  // namespace

Team dartTeam() {
  return {"DART", DART_VERSION, {contestant<DartRun>("DART", "Euler", true, takes)}};
}

}  // namespace planar_chain::benchmarks
