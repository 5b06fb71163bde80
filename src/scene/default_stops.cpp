#include "scene/default_stops.h"

namespace planar_chain {

void setDefaultStops(const std::vector<Link>& links, const std::set<std::size_t>& withDamping,
                     std::vector<Joint>& joints) {
  constexpr double tau = 0.005, zeta = 0.4;  // s, 1
  double M = 0, S = 0, J = 0;
  for (std::size_t i = links.size(); i-- > 0;) {
    const Link& link = links[i];
    const double p = length(link.pin), r = length(link.com);
    J += 2 * p * S + p * p * M + link.mass * r * r + link.inertia;
    S += p * M + link.mass * r;
    M += link.mass;
    Joint& joint = joints[i];
    if (!joint.isLimited() || joint.stopStiffness > 0) continue;
    const double inertia = joint.isPrismatic ? M : J;
    joint.stopStiffness = inertia > 0 ? inertia / (tau * tau) : 1;
    if (withDamping.count(i) == 0) joint.stopDamping = 2 * zeta * inertia / tau;
  }
}

}  // namespace planar_chain
