#pragma once

/// What acts in time: the scene's loads and the user's commands.
///
/// Between two instants at which something starts, stops or has a corner, what acts is a fixed list of
/// smooth terms. enter(t) makes that list for [t, until()); the integrator lands on until() and enters
/// again, so no stage ever asks whether a load is on and every impulse ∫F dt is exact.

#include <limits>
#include <vector>

#include "planar_chain/planar.h"
#include "planar_chain/scene.h"
#include "recursion/acting.h"

namespace planar_chain {

class Loads {
 public:
  /// commandCapacity: how many commands may be timed or wait for their start; 0: no commands at all.
  /// @throws std::invalid_argument when a load names a link or joint that the chain does not have.
  Loads(const Scene& scene, int commandCapacity);

  /// True when nothing acts, now or ever: no loads and no commands.
  bool empty() const { return loads_.empty() && !takesCommands(); }
  bool takesCommands() const { return !torques_.held.empty(); }

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
  /// Room for applyCoefficients() below this order. Allocates.
  void reserveSeries(int orders) { factorSeries_.resize(static_cast<std::size_t>(orders) * mostFactors()); }
  /// The same for Taylor coefficients of order k > 0 around t, after all of lower order. e: of exp(i θ_j), so
  /// many numbers an order.
  void applyCoefficients(int k, double t, const Rotation<double>* e, std::ptrdiff_t perOrder, double* N,
                         Vec2d* F);
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

  /// In force in [start, stop).
  struct Window {
    double start = 0;
    double stop = -std::numeric_limits<double>::infinity();
  };

  // Commands; see simulation.h. What starts after `now` shortens until() and changes nothing else; what has
  // started is in force from the next enter(t) on.
  /// @returns false, and nothing changes, when there is no room for one more that waits or is timed.
  bool holdTorque(int joint, double torque, Window window, double now);
  bool holdForce(int link, Vec2d point, Vec2d force, double moment, Window window, double now);
  bool addTorque(int joint, double torque, Window window, double now);
  bool addForce(int link, Vec2d point, Vec2d force, double moment, Window window, double now);
  void clearCommands();
  /// Those that are in force at t, as loads of a scene would say it.
  std::vector<Load> commands(double t) const;

 private:
  struct TorqueCommand {
    int index = 0;  ///< of the joint
    double torque = 0;
    Window window;
  };
  struct ForceCommand {
    int index = 0;  ///< of the link
    Vec2d point, force;
    double moment = 0;
    Window window;
  };
  /// Held: one each joint or link. Waiting: in order of their starts, to be held from then on.
  template <class Command>
  struct Commands {
    std::vector<Command> held, waiting, timed;
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

  template <class Command>
  void reserve(Commands<Command>& commands, std::size_t held);
  template <class Command>
  bool hold(Commands<Command>& commands, const Command& command, double now);
  template <class Command>
  bool add(Commands<Command>& commands, const Command& command, double now);
  template <class Command>
  void bringForward(Commands<Command>& commands, double t);
  bool hasRoom() const;

  std::size_t mostFactors() const { return 1 + loads_.size(); }
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
  Commands<TorqueCommand> torques_;
  Commands<ForceCommand> forces_;
  std::size_t capacity_ = 0;

  double until_ = std::numeric_limits<double>::infinity();
  double longestStep_ = std::numeric_limits<double>::infinity();
  int reach_ = 0;
  std::vector<double> factors_, factorSeries_;
  std::vector<SineFactor> sines_;
  std::vector<LineFactor> lines_;
  std::vector<JointTerm> jointTerms_;
  std::vector<BodyTerm> bodyTerms_;
};

}  // namespace planar_chain
