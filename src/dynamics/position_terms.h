#pragma once

/// What forces that depend on position add to the stiffness matrix of an equilibrium: Jᵀ K J. The rows of J
/// are how the own point of their body, over the chain's reach, and its angle move with the groups; K as in
/// recursion/force_tangent.h.

#include <Eigen/Eigenvalues>
#include <vector>

#include "dynamics/body_groups.h"
#include "dynamics/group_matrix.h"
#include "recursion/force_tangent.h"

namespace planar_chain {

/// A chain where its bodies are.
struct GroupedPose {
  const Chain& chain;
  const BodyGroups& groups;
  double reach;  ///< m
  const Rotation<double>* e;
  const double* x;  ///< the coordinates

  /// J of a body, or with a point at X in place of its own.
  Eigen::MatrixXd motionOf(int body, Vec2d X = {}) const {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, groups.size());
    const auto move = [&](int group, Vec2d by) {
      if (group >= 0) J.col(group).head<2>() += Eigen::Vector2d(by.x, by.y) / reach;
    };
    if (groups.turner(body) >= 0) J(2, groups.turner(body)) = 1;
    for (int i = body; i >= 0; --i) {
      move(groups.turner(i), perp(i < body ? e[i] * chain.links()[index(i)].pin : X));
      const Joint& joint = chain.joints()[index(i)];
      if (!joint.isPrismatic) continue;
      const Vec2d d = e[i] * joint.axis;
      move(groups.turner(i), perp(x[i] * d));
      move(groups.of(i), reach * d);
    }
    return J;
  }
  /// How far the tip moves along a direction with each group, m.
  Eigen::VectorXd tipAlong(Vec2d direction) const {
    const int last = chain.size() - 1;
    const Eigen::MatrixXd J = motionOf(last, e[last] * chain.links()[index(last)].pin);
    return reach * (direction.x * J.row(0) + direction.y * J.row(1)).transpose();
  }
};

/// Adds the terms of the forces on a body.
inline void addPositionTerms(const GroupedPose& pose, const PlaneTangent& K, int body,
                             std::vector<GroupMatrix::Term>& to) {
  Eigen::Matrix3d scaled;
  scaled << K.forceShift.xx, K.forceShift.xy, K.forceTurn.x, K.forceShift.yx, K.forceShift.yy, K.forceTurn.y,
      K.momentShift.x, K.momentShift.y, K.momentTurn;
  scaled.topRows<2>() *= pose.reach;
  scaled.leftCols<2>() *= pose.reach;
  if (scaled.isZero(0)) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> own(scaled);
  const Eigen::MatrixXd J = pose.motionOf(body);
  for (Eigen::Index k = 0; k < 3; ++k)
    to.push_back({own.eigenvalues()[k], J.transpose() * own.eigenvectors().col(k)});
}

}  // namespace planar_chain
