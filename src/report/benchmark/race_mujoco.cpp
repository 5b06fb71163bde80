#include "report/benchmark/mujoco_model.h"
#include "report/benchmark/race.h"

/// mj_step, contacts and, of open chains, all constraints switched off. A held tip is a connect. Constraints
/// are soft here: this one is as stiff as a step allows.

namespace planar_chain::benchmarks {

namespace {

class MujocoRun : public NativeRun {
 public:
  MujocoRun(const Contest& contest, double setting, int integrator)
      : NativeRun(contest, setting, integrator == mjINT_RK4 ? 4 : 1),
        model_(modelOf(contest.scene.chain, contest.scene.tip.has_value()), mj_deleteModel),
        data_(nullptr, mj_deleteData) {
    model_->opt.timestep = h();
    model_->opt.integrator = integrator;
    model_->opt.disableflags |= mjDSBL_CONTACT | mjDSBL_LIMIT | mjDSBL_FRICTIONLOSS;
    if (contest.scene.tip) {
      connect(tipPosition(contest.scene));
    } else {
      model_->opt.disableflags |= mjDSBL_CONSTRAINT | mjDSBL_EQUALITY;
    }
    data_.reset(mj_makeData(model_.get()));
    std::copy(contest.scene.q.begin(), contest.scene.q.end(), data_->qpos);
    std::copy(contest.scene.qd.begin(), contest.scene.qd.end(), data_->qvel);
  }

 protected:
  bool stepBy(double) override {
    mj_step(model_.get(), data_.get());
    // It starts anew, from its own first state, where numbers get too large.
    for (const int kind : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC}) {
      if (data_->warning[kind].number > 0) return false;
    }
    return true;
  }
  double q(int i) const override { return data_->qpos[i]; }
  double qd(int i) const override { return data_->qvel[i]; }

 private:
  void connect(Vec2d position) {
    constexpr double hardest = 0.9999;  // mjMAXIMP
    model_->eq_data[3] = position.x;
    model_->eq_data[4] = position.y;
    model_->eq_solimp[0] = model_->eq_solimp[1] = hardest;
    model_->eq_solref[0] = -1 / (h() * h());  // stiffness and damping: half or twice as much is worse
    model_->eq_solref[1] = -2 / h();
  }

  std::unique_ptr<mjModel, void (*)(mjModel*)> model_;
  std::unique_ptr<mjData, void (*)(mjData*)> data_;
};

/// It refuses bodies without inertia.
bool takes(const Scene& scene) {
  return hasFixedTip(scene) && scene.loads.empty() && scene.chain.size() <= 100 && !hasPoints(scene);
}

}  // namespace

Team mujocoTeam() {
  mju_user_warning = [](const char*) {};
  const auto with = [](const char* method, int integrator) {
    return contestant<MujocoRun>("MuJoCo", method, true, takes, integrator);
  };
  return {"MuJoCo",
          std::string(mj_versionString()) + " (contacts off; constraints off, but of held tips)",
          {
              with("Euler", mjINT_EULER),
              with("implicit", mjINT_IMPLICIT),
              with("RK4", mjINT_RK4),
#if mjVERSION_HEADER >= 4000000
              with("implicitfast", mjINT_IMPLICITFAST),
              with("discrete", mjINT_DISCRETE),
#endif
          }};
}

}  // namespace planar_chain::benchmarks
