#include <mujoco/mujoco.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "peer.h"

/// The parts of mj_forward that a chain in the air needs, which is faster than mj_forward with everything
/// switched off.

namespace planar_chain::benchmarks {

namespace {

constexpr int linksPerFile = 50;  // its reader of XML takes no more than 100 nested elements

std::string fileName(int k) {
  return std::to_string(k) + ".xml";
}

/// Links from `first` on, each within the one before; what does not fit is included.
std::string bodiesOf(const Chain& chain, int first) {
  const int end = std::min(chain.size(), first + linksPerFile);
  std::ostringstream xml;
  xml.precision(17);
  for (int i = first; i < end; ++i) {
    const Link& link = chain.links()[static_cast<std::size_t>(i)];
    const Vec2d at = i > 0 ? chain.links()[static_cast<std::size_t>(i - 1)].pin : Vec2d{};
    xml << "<body pos='" << at.x << ' ' << at.y << " 0'><joint type='hinge' axis='0 0 1'/><inertial pos='"
        << link.com.x << ' ' << link.com.y << " 0' mass='" << link.mass << "' diaginertia='" << link.inertia
        << ' ' << link.inertia << ' ' << link.inertia << "'/>";
  }
  if (end < chain.size()) xml << "<include file='" << fileName(end / linksPerFile) << "'/>";
  for (int i = first; i < end; ++i) xml << "</body>";
  return xml.str();
}

void write(mjVFS& files, const std::string& name, const std::string& text) {
  mj_makeEmptyFileVFS(&files, name.c_str(), static_cast<int>(text.size()));
  text.copy(static_cast<char*>(files.filedata[mj_findFileVFS(&files, name.c_str())]), text.size());
}

mjModel* modelOf(const Chain& chain) {
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  std::ostringstream root;
  root.precision(17);
  root << "<mujoco><option gravity='" << chain.gravity().x << ' ' << chain.gravity().y << " 0'/><worldbody>"
       << bodiesOf(chain, 0) << "</worldbody></mujoco>";
  write(*files, fileName(0), root.str());
  for (int i = linksPerFile; i < chain.size(); i += linksPerFile) {
    write(*files, fileName(i / linksPerFile), "<mujoco>" + bodiesOf(chain, i) + "</mujoco>");
  }
  char error[500] = "";
  mjModel* model = mj_loadXML(fileName(0).c_str(), files.get(), error, sizeof error);
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(error);
  return model;
}

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
