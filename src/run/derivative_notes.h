#pragma once

/// What a user of a motion's derivatives should know.

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "effects/joint_constraint.h"
#include "planar_chain/chain.h"

namespace planar_chain {

/// Notes what the product of two transitions leaves out: commands on their way and, unless `hasLags`, torques
/// in the lags of motors.
void noteProducts(const Chain& chain, bool hasLags, std::vector<std::string>& notes);

/// Notes the joints at rest in which friction acts otherwise if the rate changes: those that start to slip,
/// and those that only the breakaway torque holds. y: the state at t; momentOf: the moment in a stuck joint,
/// N m.
void noteRest(const Chain& chain, double t, const Eigen::VectorXd& y, const Couplings& couplings,
              const std::function<double(int)>& momentOf, std::vector<std::string>& notes);

}  // namespace planar_chain
