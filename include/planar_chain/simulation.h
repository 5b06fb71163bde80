#pragma once

/// A scene in motion: advance it to a time, read its state, apply forces and torques.
///
/// A simulation uses no clock, no ROS and no files. It is deterministic: the same calls give the same bits.
/// It allocates in the constructor, in reset(), in the first rescue by another method, where it
/// fails, and if it measures.
///
/// Every few steps a guard checks the energy balance (run/energy_guard.h). If the balance does not close, or
/// the method fails, the simulation returns to the last good state and repeats the steps: first with an
/// eighth of the step or a hundredth of the tolerance, then with rodas5p. If both fail, it stops with a
/// fault. rodas5p also replaces a method, except auto and radau13, that would make more than 1e8 steps per
/// simulated second (ros34pw2: 1e10). After some time without a rescue the simulation returns to the scene's
/// own method. This time doubles with each new rescue, up to a limit.

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_chain/derivatives.h"
#include "planar_chain/energy.h"
#include "planar_chain/events.h"
#include "planar_chain/kinematics.h"
#include "planar_chain/linear_model.h"
#include "planar_chain/motion.h"
#include "planar_chain/scene.h"

namespace planar_chain {

class Snapshot;

/// Steps and evaluations include those for measurements.
struct Statistics {
  long long steps = 0;        ///< accepted steps since construction or reset()
  long long rejected = 0;     ///< steps repeated with a smaller size
  long long evaluations = 0;  ///< of q̈
  long long rescues = 0;      ///< returns to the last good state
  double localError = 0;      ///< of the last step, in units of the tolerance; 0 for fixed steps
};

/// The energy balance since the start, or since the state was last set; all in J.
struct EnergyBalance {
  Energy now;
  double supplied = 0;    ///< work of loads and commands on the chain
  double dissipated = 0;  ///< work of dampers and stops, taken from the chain
  /// T + V − (T + V at the start) − supplied + dissipated: the error of integration. Negative where the
  /// method has damped vibrations below the tolerance.
  double residual = 0;
};

/// Force (N, base frame) and torque (N m) of the chain on its base, at the ground pin.
struct BaseWrench {
  Vec2d force;
  double torque = 0;
};

/// The state of a simulation: all that decides what it does next. Simulation::save() makes one. It is a
/// value.
class SavedState {
 public:
  SavedState() = default;
  /// From bytes(), of this process or another one. restore() checks them.
  explicit SavedState(std::string bytes) : bytes_(std::move(bytes)) {}
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class Simulation {
 public:
  /// Starts at scene.q, scene.qd at time 0. commandCapacity: the largest number of commands that are timed or
  /// wait for their start; 0: no commands are accepted. measures: the scene's sensors measure; otherwise they
  /// cost nothing.
  /// @throws std::invalid_argument when q or qd is not of size n, or a load names no body of the chain
  explicit Simulation(const Scene& scene, int commandCapacity = 0, bool measures = false);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// Integrates to time t (s, ≥ time()). Steps end exactly at t, and at every start, stop and corner of a
  /// load on the way. keepGoing, if given, is called every few steps.
  /// @returns false when the integration failed. Then time() and the state are those of the last good step,
  /// fault() says why, and further calls return false until reset() or setState(). Also returns false, with
  /// no fault, when keepGoing() does.
  /// @throws std::invalid_argument for a t before time() or not finite
  bool advanceTo(double t, const std::function<bool()>& keepGoing = nullptr);

  /// Advances as above, finds the events on the way, and ends at the first terminal one. An event is between
  /// the steps, too, and where a function passes 0 twice within one. Its time and state are exact to
  /// rounding: a step of the method from where the step around it starts. Others leave the motion as it is.
  /// One that is 0 where the way starts, as at a terminal one, happens when it is next 0. Appends to `found`;
  /// with that of the last call and the same events, the way goes on: the numbers of terminal events count
  /// from its start. Allocates.
  /// @returns true also at a terminal event
  /// @throws std::invalid_argument also for an event that is not finite. What a function throws is thrown
  /// again, at the end of a step
  bool advanceTo(double t, const std::vector<MotionEvent>& events, FoundEvents& found,
                 const std::function<bool()>& keepGoing = nullptr);

  /// Advances to t as advanceTo(), and returns how the state there changes with the present one and with
  /// torques that are held meanwhile (derivatives.h): through motors as commanded torques. motors: the
  /// torques in their lags are states, too. In a closed chain a change of the state counts as far as the tip
  /// allows it. Columns of driven joints are 0. The error is that of the tolerance. Allocates.
  /// @throws std::domain_error, after the way to t, if the motion has no derivatives, with the reason; or if
  /// it fails on the way
  Derivatives transition(double t, bool motors = false);
  /// Follows the derivatives from here on, until stopDerivatives() or until the state or a motor's torque is
  /// set, with those by numbers of the scene (variedNumber()) as well. At the first state of a simulation
  /// they include what the numbers do to this state. Allocates, also in advanceTo().
  /// @throws std::invalid_argument for numbers in a simulation that accepts commands
  void followDerivatives(const std::vector<VariedNumber>& numbers = {}, bool motors = false);
  /// @throws std::domain_error if the motion has none, with the reason; std::logic_error if they are not
  /// followed
  Derivatives derivatives() const;
  void stopDerivatives();

  double time() const;                    ///< s
  const std::vector<double>& q() const;   ///< relative angles, rad, not wrapped
  const std::vector<double>& qd() const;  ///< rad/s
  const std::string& fault() const;       ///< empty: none
  std::string method() const;             ///< in use, such as "dopri5"
  double tolerance() const;               ///< in force; 0 for methods of fixed step
  /// The recursion for q̈ that this chain uses on this CPU, such as "closed form for two",
  /// "link by link, written out for 5", "in 4 segments side by side (avx2)".
  std::string recursion() const;
  const Scene& scene() const;
  Statistics statistics() const;

  /// Sets the tolerance from the next step on, until reset(). A rate tolerance changes in proportion.
  /// Allocates.
  /// @throws std::invalid_argument for a tolerance outside 1e-15 … 1
  void setTolerance(double tolerance);

  // At the present state, computed when called.
  Energy energy() const;
  EnergyBalance energyBalance() const;
  // These evaluate the dynamics, in memory of their own: no call changes a bit of the motion.
  /// Writes q̈, n values, rad/s².
  void accelerations(double* qdd);
  /// Writes the whole torque in each joint, of springs, dampers, stops, friction, drives, loads and commands:
  /// n values, N m. In a joint with a rotor this includes the torque that accelerates the rotor.
  void jointTorques(double* tau);
  /// Writes the motion of each link, n values.
  void linkMotions(LinkMotion* motions);
  /// Returns the motion of a frame (frameNamed() finds it). Allocates.
  FrameMotion motion(const Frame& frame);
  /// Allocates.
  BaseWrench baseWrench();
  /// Returns the force on the tip that holds it, N, base frame; 0 if the tip is free.
  Vec2d tipForce();
  /// Returns the distance of a held tip from its place, m; 0 if the tip is free.
  double closureError();
  /// Returns how far the chain is from a pose that is stretched or folded between its ends: the smallest over
  /// the largest acceleration that a force on the tip gives it, 1 if the tip is free. On a line it is the
  /// acceleration across the line over the largest. Adaptive methods step over a pose in which it is 0, along
  /// the smooth motion. Where the chain comes to rest in it, the motion stops with a fault.
  double closureMargin();

  /// Returns the measurements that the sensors (sensors.h) delivered up to time(), each once: in the order of
  /// delivery, then of the sensors. Until this call the newest million values of each sensor, 8 MB, are
  /// kept. A measurement at the time of a command, or of setState(), is of the motion before. reset()
  /// discards them and begins again. Empty unless this simulation measures. Allocates.
  std::vector<Measurement> measure();
  /// How many measurements were lost since the start or reset(), because nobody took them in time.
  long long lostMeasurements() const;

  /// Returns A and B near the present state, with the commands in force. motors: the torques δτ are
  /// commanded, and the torques that lag are states behind (δq, δq̇). Allocates.
  LinearModel linearize(bool motors = false) const;

  // Commands. A command acts from `start` (s of time()), where a step ends, or from time() if that is later.
  // In a joint with a command_delay it acts, and ends, that much later. A held command lasts until the next
  // one of the same joint or link starts, or until `until`. A timed command lasts until start + duration, and
  // adds to the others.
  // @returns false, and changes nothing, when commandCapacity commands are already timed or waiting
  // @throws std::invalid_argument for an index out of range, a number that is not finite or above 1e100 in
  // size, and a command that ends by time()
  static constexpr double now = -std::numeric_limits<double>::infinity();
  bool holdTorque(int joint, double torque, double until, double start = now);
  bool holdForce(int link, Vec2d point, Vec2d force, double moment, double until, double start = now);
  bool addTorque(int joint, double torque, double duration, double start = now);
  bool addForce(int link, Vec2d point, Vec2d force, double moment, double duration, double start = now);
  void clearCommands();
  /// Returns the commands in force at time(), as loads of a scene: of motors, the torques that they give.
  std::vector<Load> commands() const;
  /// Returns the torque in the lag of each joint's motor at time(), n values, N m: what the motor gives,
  /// unless its torque-speed line bounds it. Without a lag, the commanded torque that acts, cut off at the
  /// limit.
  std::vector<double> motorTorques() const;
  /// Sets them, without a lag to what they are: such a torque is commanded. They approach the commanded
  /// torques from there.
  /// @throws std::invalid_argument for another number of them, or if this simulation accepts no commands;
  /// Refused for torques that are not finite or beyond the effort limit, and for others in joints without a
  /// lag
  void setMotorTorques(const std::vector<double>& torques);
  /// Returns how often the commanded torques of each joint began to exceed its effort limit, since
  /// construction or reset(). Empty if this simulation accepts no commands.
  const std::vector<long long>& cutOffs() const;
  /// Returns how often the rate of each joint began to exceed its velocity_limit, checked at the ends of
  /// advanceTo(), since construction or reset().
  const std::vector<long long>& velocityExcesses() const;

  /// Drives a joint by this law from time() on, until reset(). scene() then contains the law. Allocates.
  /// @throws std::invalid_argument if the joint is not driven, or the law is not finite, or is more than 1e-6
  /// (rad, rad/s) away from the present angle or rate
  void follow(int joint, MotionLaw law);
  /// Drives the base by these laws. They must agree with its present position, angle and rates.
  /// @throws std::invalid_argument also if the scene has no `base`
  void followBase(BaseLaws laws);

  /// Sets the state at the present time. The balance starts anew, and a fault is cleared. Commands stay, and
  /// so do the torques in the lags of motors (setMotorTorques()).
  /// @throws std::invalid_argument for wrong sizes, numbers that are not finite, or infinite energy
  void setState(const std::vector<double>& q, const std::vector<double>& qd);
  /// Puts the chain at rest in the static equilibrium that is reached from the present angles by always
  /// lowering the energy, with the loads and commands of the present time. Friction is ignored. Driven joints
  /// continue their motion. Motors give the commanded torques. keepGoing as in advanceTo(). Allocates.
  /// @throws std::domain_error, with the reason and the state unchanged, if there is none or keepGoing()
  /// returns false
  void settle(const std::function<bool()>& keepGoing = nullptr);
  /// Returns how often the state was set: by the constructor, setState(), settle(), restore() or reset().
  long long timesSet() const { return timesSet_; }
  /// Returns the present state: time, angles and rates; the method, its step and what it has found out;
  /// commands that act or wait; torques that lag; what sticks; measurements that were not taken; the laws and
  /// the tolerance in force; works, counts and a fault. It changes nothing. Allocates.
  SavedState save();
  /// Goes back to a state of a simulation that was made with the same arguments: this one or another one.
  /// From there on, equal calls give equal bits. Counts as setting the state. Invalidates the
  /// references returned before, except that of scene(). Allocates.
  /// @throws Refused, and changes nothing, for a state of another scene, of other arguments, of another
  /// version of this program, or of a CPU with another recursion()
  void restore(const SavedState& saved);
  /// Returns a simulation of this scene in a state that one of the same scene saved, made with the same
  /// arguments. Allocates.
  /// @throws Refused as restore()
  static std::unique_ptr<Simulation> in(const SavedState& saved, const Scene& scene);
  /// Returns a simulation in the same state, which goes on by itself. Allocates.
  std::unique_ptr<Simulation> copy();

  /// Restores the state after construction, time 0 included: the same calls give the same bits again.
  /// Invalidates the references returned before, except that of scene().
  void reset();

 private:
  struct Parts;
  Scene sceneOfTheStart() const;
  void saveOrRestore(Snapshot& snapshot);
  const std::string& kind();

  Scene scene_;                      ///< with the laws that drive at present, and the tolerance
  const std::vector<Drive> drives_;  ///< those of the start
  const std::optional<BaseLaws> base_;
  const IntegratorSettings integrator_;
  const int commandCapacity_;
  const bool measures_;
  long long timesSet_ = 0;
  std::string kind_;  ///< of the states that it saves; empty: not computed yet
  std::unique_ptr<Parts> parts_;
};

}  // namespace planar_chain
