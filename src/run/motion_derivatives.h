#pragma once

/// The derivatives of a simulation's motion (planar_chain/derivatives.h). They follow the motion piece by
/// piece: along its Taylor steps (column_steps.h); or where that is not possible, they integrate the motion
/// again from a state of the simulation to a later one, together with their columns
/// (dynamics/varied_motion.h), with the tolerance of the scene. So they change no bit of the motion.

#include <memory>
#include <string>
#include <vector>

#include "dynamics/varied_motion.h"
#include "effects/commands.h"
#include "ode/integrator.h"
#include "planar_chain/derivatives.h"
#include "planar_chain/scene.h"
#include "run/column_steps.h"

namespace planar_chain {

/// All states are those of the dynamics, in chain order. Allocates.
class MotionDerivatives {
 public:
  /// Begins at the state y at t. fromStart: it is the scene's own, which numbers may move. The scene and the
  /// effects must outlive this object. commands: among the effects, or nullptr. motors: torques in their lags
  /// are states, too.
  MotionDerivatives(const Scene& scene, const Effects& effects, const CommandEffect* commands,
                    const std::vector<VariedNumber>& numbers, bool fromStart, bool motors, double t,
                    const Eigen::VectorXd& y);

  /// Follows the motion from one state to another. What acts is the same on the way. series: one that the
  /// motion may have taken, in one step.
  void follow(double t, const Eigen::VectorXd& y, double end, const Eigen::VectorXd& yEnd,
              const MotionInSeries& series);
  /// Call it if the motion has leapt over a change point (ode/leaping_steps.h): there
  /// the equations of the derivatives lose a rank, too.
  void passChangePoint(double t) { fail(t, "the chain to its held tip gets straight or folded"); }
  /// Call these before and after the events that have happened at a state are fired.
  void meet(double t, const Eigen::VectorXd& y, const ode::LocatedEvent& located);
  void pass(double t, const Eigen::VectorXd& y);
  /// Call it when what acts has changed at a time that is given.
  void enter() {
    hasChanged_ = true;
    isEntered_ = false;
  }
  /// Keeps the present columns; goes back to those.
  void keep() {
    kept_ = columns_;
    keptFault_ = fault_;
  }
  void goBack() {
    columns_ = kept_;
    fault_ = keptFault_;
    enter();
  }

  /// Why there are none; empty: there are.
  const std::string& fault() const { return fault_; }
  /// Between the start and the state y at t, where it has been followed to.
  Derivatives derivatives(double t, const Eigen::VectorXd& y) const;

 private:
  /// The motion and its columns as one initial value problem.
  struct General {
    explicit General(MotionDerivatives& of);
    VariedMotion motion;
    std::unique_ptr<ode::Integrator> steps;
    ode::State state;
  };
  /// Made at the state where it is first needed.
  VariedMotion& motion(double t, const Eigen::VectorXd& y);
  void followGenerally(double t, const Eigen::VectorXd& y, double end);
  Couplings couplingsAt(double t) const;
  void beginColumns(bool fromStart, const Eigen::VectorXd& y);
  void close(const Eigen::VectorXd& y);
  void stopHeldJoints(double t, const Eigen::VectorXd& y);
  void scaleColumns();
  bool enterNumbers(double t);
  double nextShare(double t) const;
  double slopeOf(const EventPlace& event, double t, const Eigen::VectorXd& y, const double* along,
                 double ofTime) const;
  void fail(double t, const std::string& why);

  const Scene& scene_;
  const Effects& effects_;
  const CommandEffect* commands_;
  const int n_;
  const double since_;           ///< s
  const std::vector<int> lags_;  ///< joints whose motors' lags have columns
  std::vector<std::unique_ptr<NearScenes>> numbers_;
  std::vector<std::string> paths_;
  std::vector<double> sizes_;
  ColumnSteps alongSeries_;
  std::unique_ptr<General> general_;
  Eigen::MatrixXd columns_, kept_;  ///< of (θ, ω), not scaled
  Eigen::VectorXd slopes_;          ///< before the switch
  Eigen::VectorXd delays_;          ///< of the switch, one a column
  Eigen::VectorXd moments_;         ///< in the joints, before the switch
  Eigen::MatrixXd torqueMoments_;   ///< how they change with each torque that is held or lags
  std::vector<bool> wereHeld_;
  double eventSlope_ = 0;
  double pieceBegan_ = 0;   ///< s
  bool hasChanged_ = true;  ///< since the last steps of general_
  bool isEntered_ = false, hasSeries_ = false;
  std::string fault_, keptFault_;
  std::vector<std::string> notes_;
};

}  // namespace planar_chain
