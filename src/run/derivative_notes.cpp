#include "run/derivative_notes.h"

#include <algorithm>
#include <cmath>

#include "effects/motors.h"
#include "planar_chain/fault.h"
#include "reading/names.h"

namespace planar_chain {

void noteProducts(const Chain& chain, bool hasLags, std::vector<std::string>& notes) {
  const std::string words = "products of (Phi, Gamma) over intervals leave out ";
  std::vector<std::string> lags, delays;
  for (const Joint& joint : chain.joints()) {
    if (joint.other(timeConstant) > 0) lags.push_back(joint.name);
    if (const double delay = joint.other("command_delay"); delay > 0)
      delays.push_back(joint.name + " (command_delay " + toText(delay) + " s)");
  }
  if (!lags.empty() && !hasLags)
    notes.push_back(words + "the lagged torques of " + listed(lags) + ": with motors=True they are states");
  if (!delays.empty()) notes.push_back(words + "the commands on their way to " + listed(delays));
}

void noteRest(const Chain& chain, double t, const Eigen::VectorXd& y, const Couplings& couplings,
              const std::function<double(int)>& momentOf, std::vector<std::string>& notes) {
  constexpr double rest = 1e-12;  // rad/s, m/s: the rounding of a closed chain
  for (int i = 0; i < chain.size(); ++i) {
    const Joint& joint = chain.joints()[index(i)];
    const double friction = joint.other("friction"), breakaway = joint.other("breakaway");
    if (!(std::max(friction, breakaway) > 0)) continue;
    if (std::abs(chain.coordinates().relative(y.data() + chain.size(), i)) > rest) continue;
    const std::string at = " at t = " + toText(t) + " s";
    if (!couplings.joints[index(i)].isPrescribed) {
      if (friction > 0)
        notes.push_back(joint.name + " starts to slip" + at +
                        ": the derivatives by its rate there hold in the direction of the slip alone");
    } else if (breakaway > friction && std::abs(momentOf(i)) > friction) {
      notes.push_back(
          joint.name + " sticks" + at +
          " by its breakaway torque alone: any rate may start it, and the derivatives by its rate "
          "take it as stuck");
    }
  }
}

}  // namespace planar_chain
