#pragma once

/// The stiffness matrix of the groups of an equilibrium (equilibrium.h): diag(κ) and springs between
/// neighbouring groups. It is factored by Thomas' algorithm.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

namespace planar_chain {

struct GroupMatrix {
  Eigen::VectorXd kappa, spring, pivot;  ///< spring: inside of each group
  Eigen::Index apart = 0;                ///< the number of first groups that no springs join: slides
  /// In place of a smaller κ'; at first of the weight's moments. At 0 links that carry nothing have a
  /// singular matrix; much larger, steps of soft chains are far too short.
  double floor = 1e-6;

  /// The spring between group g and the one before.
  double between(Eigen::Index g) const { return g > apart && g < spring.size() ? spring[g] : 0; }

  /// Factors diag(κ') + springs, κ' = κ + share (|κ| − κ). Returns the number of groups, or the first one
  /// whose pivot is not above `least`.
  Eigen::Index factor(double share, double least) {
    const Eigen::Index groups = kappa.size();
    pivot.resize(groups);
    for (Eigen::Index g = 0; g < groups; ++g) {
      const double raised = kappa[g] + share * (std::abs(kappa[g]) - kappa[g]);
      // A slide without a spring is held by the tip alone.
      const bool isRaised = share > 0 || g < apart;
      pivot[g] = (isRaised ? std::max(raised, floor) : raised) + spring[g] + between(g + 1);
      if (g > 0) pivot[g] -= between(g) * between(g) / pivot[g - 1];
      if (!(pivot[g] > least)) return g;
    }
    return groups;
  }

  /// The same with the first share that gives pivots above `least`. Returns false if none does.
  bool factorBy(const std::vector<double>& shares, double least) {
    return std::any_of(shares.begin(), shares.end(),
                       [&](double share) { return factor(share, least) == kappa.size(); });
  }

  /// Solves with the factors.
  Eigen::VectorXd solved(Eigen::VectorXd x) const {
    for (Eigen::Index g = 1; g < x.size(); ++g) x[g] += between(g) / pivot[g - 1] * x[g - 1];
    for (Eigen::Index g = x.size(); g-- > 0;) {
      if (g + 1 < x.size()) x[g] += between(g + 1) * x[g + 1];
      x[g] /= pivot[g];
    }
    return x;
  }
};

}  // namespace planar_chain
