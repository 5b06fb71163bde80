#include "planar_chain/linear_model.h"

#include <stdexcept>

#include "dynamics/entered.h"
#include "dynamics/general_motion.h"
#include "dynamics/motion_change.h"

namespace planar_chain {

LinearModel linearModel(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd) {
  const int n = scene.chain.size();
  if (q.size() != n || qd.size() != n) {
    throw std::invalid_argument("q and qd must have one value a joint");
  }
  Entered entered(scene, t, q, qd);
  const Evaluation& at = entered.evaluation();
  EffectTangents tangents(n, entered.effects);
  tangents.takeConstant(entered.effects);
  tangents.takeJoints(entered.effects, at.state());
  tangents.takeForces(entered.effects, at.state());
  const Couplings& couplings = entered.motion.couplings(t);
  const bool hasForces = entered.effects.acting() == LoadKind::forces;

  // δq̈ while joint j, with all that turns with it, turns or slides by `turn`, speeds up by `speed`, and has
  // `torque` more.
  MotionChange change(entered.mechanism);
  const Coordinates& coordinates = scene.chain.coordinates();
  const auto along = [&](int j, double turn, double speed, double torque) {
    for (int i = 0; i < n; ++i) {
      const double hangs =
          i == j || (i > j && !coordinates.isPrismatic(i) && !coordinates.isPrismatic(j)) ? 1 : 0;
      change.turn[index(i)] = hangs * turn;
      change.speed[index(i)] = hangs * speed;
    }
    std::fill(change.N.begin(), change.N.end(), 0.0);
    coordinates.addTorque(torque, j, change.N.data());
    change.find(at, hasForces, couplings, tangents);
    Eigen::VectorXd result(n);
    coordinates.toRelative(change.xdd.data(), result.data());
    return result;
  };

  LinearModel model{Eigen::MatrixXd::Zero(2 * n, 2 * n), Eigen::MatrixXd::Zero(2 * n, n)};
  model.A.topRightCorner(n, n).setIdentity();
  for (int j = 0; j < n; ++j) {
    model.A.col(j).tail(n) = along(j, 1, 0, -tangents.k[index(j)]);
    model.A.col(n + j).tail(n) = along(j, 0, 1, -tangents.d[index(j)]);
    model.B.col(j).tail(n) = along(j, 0, 0, 1);
  }
  return model;
}

}  // namespace planar_chain
