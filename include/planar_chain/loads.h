#pragma once

/// What acts in time: the scene's loads and the user's commands.
///
/// Between two instants at which something starts, stops or has a corner, what acts is a fixed list of
/// smooth terms. enter(t) makes that list for [t, until()); the integrator lands on until() and enters
/// again, so no stage ever asks whether a load is on and every impulse ∫F dt is exact.

#include <limits>
#include <vector>

#include "planar_chain/acting.h"
#include "planar_chain/planar.h"
#include "planar_chain/scene.h"

namespace planar_chain {

class Loads {
 public:
  /// commandCapacity: how many timed commands may be in force at once; 0: no commands, and no room for them.
  /// @throws std::invalid_argument when a load names a link or joint that the chain does not have.
  Loads(const Scene& scene, int commandCapacity);

  /// True when nothing acts, now or ever: no loads and no commands.
  bool empty() const { return loads_.empty() && heldTorques_.empty(); }
  bool takesCommands() const { return !heldTorques_.empty(); }

  /// Chooses what acts in [t, until()). Allocates nothing.
  void enter(double t);
  double until() const { return until_; }
  /// A step should not be longer than a quarter of the shortest period in force, s.
  double longestStep() const { return longestStep_; }

  /// What of it acts now.
  Acting acting() const {
    if (!bodyTerms_.empty()) return Acting::forces;
    return jointTerms_.empty() ? Acting::nothing : Acting::moments;
  }
  /// How many bodies, from the ground, must have their inner pins' velocities known: 0 without forces.
  int reach() const { return reach_; }
  /// Adds to N (moments about the inner pins, n) and F (forces, n; not touched without forces) what acts at
  /// time t, and returns its power, W. pinVelocity: of the first reach() inner pins. Allocates nothing.
  double apply(double t, const Rotation<double>* e, const double* omega, const Vec2d* pinVelocity, double* N,
               Vec2d* F);
  /// The same for the rates of change with time alone, bodies and velocities held: ∂N/∂t, ∂F/∂t and the
  /// returned ∂power/∂t.
  double applyRates(double t, const Rotation<double>* e, const double* omega, const Vec2d* pinVelocity,
                    double* N, Vec2d* F);
  /// True when what acts changes with time.
  bool varies() const { return !sines_.empty() || !lines_.empty(); }
  /// Adds Σ X·F of each body to XF (n): how the moments of the forces change when bodies turn.
  void addStiffness(double t, const Rotation<double>* e, double* XF);
  /// The power's derivative along (u, v), changes of the angles and rates; du of the first reach() inner
  /// pins' velocities.
  double powerAlong(double t, const Rotation<double>* e, const double* omega, const double* u,
                    const double* v, const Vec2d* pinVelocityChange);
  /// Adds to tau (n) the torques of loads and commands in the joints.
  void addJointTorques(double t, double* tau);

  // Commands; see simulation.h. In force from the next enter(t) on.
  void holdTorque(int joint, double torque, double until);
  void holdForce(int link, Vec2d point, Vec2d force, double moment, double until);
  bool addTorque(int joint, double torque, double start, double stop);
  bool addForce(int link, Vec2d point, Vec2d force, double moment, double start, double stop);
  void clearCommands();
  /// Those that last beyond t, as loads of a scene would say it.
  std::vector<Load> commands(double t) const;

 private:
  /// One pair of time law and effect, in force in [start, stop).
  struct Window {
    double start = 0;
    double stop = -std::numeric_limits<double>::infinity();
  };
  struct TorqueCommand {
    int joint = 0;
    double torque = 0;
    Window window;
  };
  struct ForceCommand {
    int link = 0;
    Vec2d point, force;
    double moment = 0;
    Window window;
  };

  // What acts now. The factor of term k is factors_[term.factor]; factors_[0] is 1.
  struct SineFactor {
    double pulsation, phase;
    int factor;
  };
  struct LineFactor {
    double t0, value, slope;
    int factor;
  };
  struct JointTerm {
    int joint;
    double torque;
    int factor;
  };
  struct BodyTerm {
    int body;
    Vec2d force, point;
    double moment;
    int factor;
  };

  bool acts(const Window& window, double t);
  int factorOf(const TimeLaw& law, double t);
  void evaluateFactors(double t);
  void evaluateRates(double t);
  double applyFactors(const Rotation<double>* e, const double* omega, const Vec2d* pinVelocity, double* N,
                      Vec2d* F) const;
  double times(int factor, double value) const { return factors_[static_cast<std::size_t>(factor)] * value; }
  void addBodyTerm(const BodyTerm& term);

  int size_;
  std::vector<Load> loads_;
  std::vector<TorqueCommand> heldTorques_, timedTorques_;
  std::vector<ForceCommand> heldForces_, timedForces_;
  std::size_t capacity_ = 0;

  double until_ = std::numeric_limits<double>::infinity();
  double longestStep_ = std::numeric_limits<double>::infinity();
  int reach_ = 0;
  std::vector<double> factors_;
  std::vector<SineFactor> sines_;
  std::vector<LineFactor> lines_;
  std::vector<JointTerm> jointTerms_;
  std::vector<BodyTerm> bodyTerms_;
};

}  // namespace planar_chain
