#pragma once

/// The derivatives of a motion along its Taylor steps (lanes/column_series.h): a step of the motion is one of
/// its derivatives, too, or a few.

#include <memory>
#include <optional>
#include <vector>

#include "dynamics/dynamics.h"
#include "dynamics/near_scenes.h"
#include "effects/commands.h"
#include "lanes/column_series.h"
#include "planar_chain/scene.h"

namespace planar_chain {

class ColumnSteps {
 public:
  using Numbers = std::vector<std::unique_ptr<NearScenes>>;

  /// Columns by the state, by torques, by torques in the lags of these joints, by numbers. All of these must
  /// outlive this object. Allocates.
  ColumnSteps(const Scene& scene, const Effects& effects, const CommandEffect* commands,
              const std::vector<int>& lags, const Numbers& numbers);

  using State = Eigen::Ref<const Eigen::VectorXd>;
  /// True if this series begins at the first state and reaches the other one, but for an error of `most`, of
  /// 1 + |y|.
  static bool isAlong(const MotionInSeries& motion, double t, const State& y, double end, const State& yEnd,
                      double most);
  /// Takes what acts at the state y at t and in the series of the next steps. Returns false if there are no
  /// series of the columns then. Allocates.
  bool enter(double t, const Eigen::VectorXd& y, const MotionInSeries& motion);
  /// Follows the columns, of (θ, ω), along h of a step. Returns false if that needs too many steps of their
  /// own; then it changes nothing.
  bool follow(const MotionInSeries& motion, double h, Eigen::MatrixXd& columns);

 private:
  bool takeTorques();
  bool takeNumbers(double t, const Eigen::VectorXd& y);
  void write(const Eigen::MatrixXd& columns);
  void read(Eigen::MatrixXd& columns) const;

  const Scene& scene_;
  const Effects& effects_;
  const CommandEffect* commands_;
  const std::vector<int>& lags_;
  const Numbers& numbers_;
  const int n_;
  const bool mayBe_;  ///< ever
  Couplings couplings_;
  std::optional<ColumnSeries> series_;
  std::vector<double> shifted_;  ///< the motion from within a step
};

}  // namespace planar_chain
