#pragma once

/// The stiffness matrix of the groups of an equilibrium (equilibrium.h): diag(κ), springs between
/// neighbouring groups of bodies, and what couples a displacement with the body that turns its axis.
/// Displacements come first. So it is factored by Thomas' algorithm, without fill.
///
/// A force that depends on the position of its body couples all groups that move the body, by w a aᵀ. Then
/// the matrix is full, and factored as L D Lᵀ in O(n³).

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

namespace planar_chain {

struct GroupMatrix {
  /// w a aᵀ
  struct Term {
    double w;
    Eigen::VectorXd a;
  };

  Eigen::VectorXd kappa, spring, pivot;  ///< spring: inside of each group
  Eigen::Index apart = 0;                ///< the number of first groups: displacements, which no springs join
  Eigen::VectorXd across, coupling;      ///< what couples each of these with a group of bodies; as factored
  std::vector<Eigen::Index> turner;      ///< which group; −1: none
  std::vector<Term> terms;
  /// In place of a smaller κ'; at first of the weight's moments. At 0 links that carry nothing have a
  /// singular matrix; much larger, steps of soft chains are far too short.
  double floor = 1e-6;

  /// The spring between group g and the one before.
  double between(Eigen::Index g) const { return g > apart && g < spring.size() ? spring[g] : 0; }

  /// Factors diag(κ') + springs + terms, κ' = κ + share (|κ| − κ), and w likewise, with 1 − share of what
  /// couples displacements. So share 1 has positive pivots. Returns the number of groups, or the first one
  /// whose pivot is not above `least`.
  Eigen::Index factor(double share, double least) {
    const Eigen::Index groups = kappa.size();
    pivot.resize(groups);
    coupling = (1 - share) * across;
    const auto raise = [share](double value) { return value + share * (std::abs(value) - value); };
    for (Eigen::Index g = 0; g < groups; ++g) {
      const double raised = raise(kappa[g]);
      // A displacement without a spring is held by the tip alone, or by terms.
      const bool isRaised = share > 0 || g < apart;
      pivot[g] = (isRaised ? std::max(raised, floor) : raised) + spring[g] + between(g + 1);
      if (!terms.empty()) continue;
      if (g > 0) pivot[g] -= between(g) * between(g) / pivot[g - 1];
      for (Eigen::Index r = 0; r < apart && g >= apart; ++r) {
        if (turnerOf(r) == g) pivot[g] -= coupling[r] * coupling[r] / pivot[r];
      }
      if (!(pivot[g] > least)) return g;
    }
    if (terms.empty()) return groups;
    L.setZero(groups, groups);
    L.diagonal() = pivot;
    for (Eigen::Index g = apart + 1; g < groups; ++g) L(g, g - 1) = -between(g);
    for (Eigen::Index r = 0; r < apart; ++r) {
      if (turnerOf(r) >= 0) L(turnerOf(r), r) = coupling[r];
    }
    for (const Term& term : terms) L += raise(term.w) * term.a * term.a.transpose();
    return factorFull(least);
  }

  /// Factors the matrix with the first share that gives pivots above `least`. Returns false if none does.
  bool factorBy(const std::vector<double>& shares, double least) {
    return std::any_of(shares.begin(), shares.end(),
                       [&](double share) { return factor(share, least) == kappa.size(); });
  }

  /// Solves with the factors.
  Eigen::VectorXd solved(Eigen::VectorXd x) const {
    if (!terms.empty()) {
      L.triangularView<Eigen::UnitLower>().solveInPlace(x);
      x.array() /= pivot.array();
      L.transpose().triangularView<Eigen::UnitUpper>().solveInPlace(x);
      return x;
    }
    for (Eigen::Index r = 0; r < apart; ++r) {
      if (turnerOf(r) >= 0) x[turnerOf(r)] -= coupling[r] / pivot[r] * x[r];
    }
    for (Eigen::Index g = 1; g < x.size(); ++g) x[g] += between(g) / pivot[g - 1] * x[g - 1];
    for (Eigen::Index g = x.size(); g-- > 0;) {
      if (g + 1 < x.size()) x[g] += between(g + 1) * x[g + 1];
      if (g < apart && turnerOf(g) >= 0) x[g] -= coupling[g] * x[turnerOf(g)];
      x[g] /= pivot[g];
    }
    return x;
  }

  /// The x with x_bad = 1, and 0 behind it, for which xᵀ H x is the pivot of that group.
  Eigen::VectorXd alongPivot(Eigen::Index bad) const {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(kappa.size());
    x[bad] = 1;
    if (!terms.empty()) {
      x.head(bad) = -L.row(bad).head(bad).transpose();
      L.topLeftCorner(bad, bad).transpose().triangularView<Eigen::UnitUpper>().solveInPlace(x.head(bad));
      return x;
    }
    for (Eigen::Index g = bad; g-- > 0;) {
      x[g] = between(g + 1) * x[g + 1] / pivot[g];
      if (g < apart && turnerOf(g) >= 0 && turnerOf(g) <= bad)
        x[g] = -coupling[g] * x[turnerOf(g)] / pivot[g];
    }
    return x;
  }

 private:
  /// From the lower half of the matrix in L, row by row.
  Eigen::Index factorFull(double least) {
    for (Eigen::Index g = 0; g < pivot.size(); ++g) {
      Eigen::VectorXd row = L.row(g).head(g).transpose();
      L.topLeftCorner(g, g).triangularView<Eigen::UnitLower>().solveInPlace(row);
      L.row(g).head(g) = row.cwiseQuotient(pivot.head(g)).transpose();
      pivot[g] = L(g, g) - row.dot(L.row(g).head(g));
      if (!(pivot[g] > least)) return g;
    }
    return pivot.size();
  }

  Eigen::MatrixXd L;  ///< unit lower; above, the matrix
  Eigen::Index turnerOf(Eigen::Index r) const { return turner[static_cast<std::size_t>(r)]; }
};

}  // namespace planar_chain
