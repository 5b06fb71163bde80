#pragma once

/// A scene at one state: its effects are chosen, its joints stick or slip. For single computations.

#include <Eigen/Core>

#include "dynamics/general_motion.h"
#include "planar_chain/scene.h"

namespace planar_chain {

struct SceneSnapshot {
  /// q, qd: relative angles (rad) and rates (rad/s), one a joint. The scene must outlive this object.
  SceneSnapshot(const Scene& scene, double time, const Eigen::VectorXd& q, const Eigen::VectorXd& qd)
      : effects(scene), mechanism(scene, true), motion(mechanism, effects), t(time), y(2 * q.size()) {
    mechanism.coordinates().toAbsolute(q.data(), y.data());
    mechanism.coordinates().toAbsolute(qd.data(), y.data() + q.size());
    effects.enter(t);
    effects.enterState(t, y.data());
    motion.forget();
  }

  const Evaluation& evaluation() { return motion.query(t, y.data()); }

  Effects effects;
  Mechanism mechanism;
  GeneralMotion motion;
  double t;
  Eigen::VectorXd y;
};

}  // namespace planar_chain
