/// Any text at all is a scene or is refused, with faults that can be shown. What is accepted can be set in
/// motion, and its equations can be asked for.

#include <Eigen/Core>
#include <cstdint>
#include <cstdlib>

#include "planar_chain/fault.h"
#include "planar_chain/kane.h"
#include "planar_chain/linear_model.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"

namespace planar_chain {
namespace {

constexpr int fewLinks = 8;  // that do not take all the time

void require(bool holds) {
  if (!holds) std::abort();
}

bool isOneLine(const std::string& text) {
  return !text.empty() && text.size() < 10000 && text.find('\n') == std::string::npos;
}

void setInMotion(Scene scene) {
  if (scene.chain.size() > fewLinks) return;
  scene.integrator.method = "rk4";
  scene.integrator.step = 1e-9;
  Simulation simulation(scene, 1);
  simulation.advanceTo(3e-9);  // a scene may well ask for billions of steps a second
  const auto vector = [](const std::vector<double>& v) -> Eigen::VectorXd {
    return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
  };
  const Eigen::VectorXd q = vector(simulation.q()), qd = vector(simulation.qd());
  require(q.allFinite() && qd.allFinite());
  kane(scene.chain, q, qd, activeForces(scene, 0, q, qd));
  linearModel(scene, 0, q, qd);
}

}  // namespace
}  // namespace planar_chain

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planar_chain;
  try {
    setInMotion(readSceneText(std::string(data, data + size)));
  } catch (const Refused& refused) {
    require(!refused.faults().empty());
    for (const Fault& fault : refused.faults()) require(isOneLine(toString(fault)));
  }
  return 0;
}
