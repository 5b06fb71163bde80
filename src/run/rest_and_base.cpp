#include "dynamics/equilibrium.h"
#include "effects/effect_kind.h"
#include "planar_chain/simulation.h"

namespace planar_chain {

void Simulation::settle() {
  Scene present = scene_;
  for (Load& command : commands()) present.loads.push_back(std::move(command));
  const std::vector<double> rest = equilibriumOf(present, time(), q());
  std::vector<double> still(rest.size(), 0.0);
  for (const Drive& drive : scene_.drives) still[index(drive.joint)] = qd()[index(drive.joint)];
  setState(rest, still);
}

BaseWrench Simulation::baseWrench() {
  const auto n = static_cast<std::size_t>(scene_.chain.size());
  std::vector<LinkMotion> motions(n);
  std::vector<double> tau(n), qdd(n, 0.0);
  linkMotions(motions.data());
  jointTorques(tau.data());
  const double rotor = inertiaIn(scene_.chain.joints().front());
  if (rotor > 0) accelerations(qdd.data());
  return {-1.0 * motions.front().pinForce, rotor * qdd.front() - tau.front()};
}

}  // namespace planar_chain
