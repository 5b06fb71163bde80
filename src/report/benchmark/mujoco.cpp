#include <algorithm>

#include "report/benchmark/mujoco_model.h"
#include "report/benchmark/peer.h"

/// The parts of mj_forward that a chain in the air needs, which is faster than mj_forward with everything
/// switched off.

namespace planar_chain::benchmarks {

namespace {

class Mujoco : public Peer {
 public:
  explicit Mujoco(const Chain& chain)
      : model_(modelOf(chain), mj_deleteModel), data_(mj_makeData(model_.get()), mj_deleteData) {}

  void place(const Posture& posture) override {
    std::copy(posture.q.begin(), posture.q.end(), data_->qpos);
    std::copy(posture.qd.begin(), posture.qd.end(), data_->qvel);
  }

  void evaluate() override {
    const mjModel* m = model_.get();
    mjData* d = data_.get();
    mj_kinematics(m, d);
    mj_comPos(m, d);
    mj_crb(m, d);
    mj_factorM(m, d);
    mj_comVel(m, d);
    mj_rne(m, d, 0, d->qfrc_bias);
    for (int i = 0; i < m->nv; ++i) d->qacc[i] = -d->qfrc_bias[i];
    mj_solveM(m, d, d->qacc, d->qacc, 1);
  }

  void read(double* qdd) const override { std::copy(data_->qacc, data_->qacc + model_->nv, qdd); }

 private:
  std::unique_ptr<mjModel, void (*)(mjModel*)> model_;
  std::unique_ptr<mjData, void (*)(mjData*)> data_;
};

}  // namespace

PeerKind mujoco() {
  // It factors M_q in relative angles, whose condition grows like n⁴.
  return {
      "MuJoCo", mj_versionString(),
      1,        1000,
      1e-4,     [](const Chain& chain) -> std::unique_ptr<Peer> { return std::make_unique<Mujoco>(chain); }};
}

}  // namespace planar_chain::benchmarks
