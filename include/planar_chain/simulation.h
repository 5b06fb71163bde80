#pragma once

/// A scene in motion: advance it to a time, read its state, push it.
///
/// Knows no clock, no ROS and no files. Deterministic: the same calls give the same bits. Allocates
/// in its constructor and in reset(), and when the energy guard calls in another method for the first time;
/// nowhere else.
///
/// The guard (energy_guard.h) looks every few steps. On trouble (the balance does not close, or the method
/// can go no further) the simulation goes back to the last good state and climbs a ladder: the scene's method
/// with smaller steps (an eighth, or a hundredth of the tolerance), then rodas5p, then failure. It climbs
/// down again once a stretch has gone well, which must be longer each time.

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "planar_chain/energy.h"
#include "planar_chain/motion.h"
#include "planar_chain/scene.h"

namespace planar_chain {

struct Statistics {
  long long steps = 0;        ///< accepted steps since construction or reset()
  long long rejected = 0;     ///< steps tried again with a smaller size
  long long evaluations = 0;  ///< of q̈
  long long rescues = 0;      ///< times that the guard went back to the last good state; see Simulation
  double localError = 0;      ///< estimate of the last step, in units of the tolerance; 0 for fixed steps
};

/// Where the energy went since the start, or since the state was last set. All in J.
struct EnergyBalance {
  Energy now;
  double supplied = 0;    ///< work of loads and commands on the chain
  double dissipated = 0;  ///< taken by dampers and stops
  /// T + V − (T + V at the start) − supplied + dissipated: zero but for the error of integration.
  double residual = 0;
};

class Simulation {
 public:
  /// commandCapacity: how many commands may be timed or wait for their start; 0: this simulation takes no
  /// commands. The chain stands at scene.q, scene.qd at time 0.
  /// @throws std::invalid_argument when q or qd is not of size n or a load names no body of the
  /// chain.
  explicit Simulation(const Scene& scene, int commandCapacity = 0);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// Integrates to time t (s, ≥ time()) and lands on it, and on every start and stop of a load on
  /// the way.
  /// @returns false when the integration failed: time() and the state are then those of the last
  /// good step,
  ///   fault() says why, and every further call returns false until reset() or setState(). And when
  ///   keepGoing, asked every few steps, says false: without a fault, somewhere on the way.
  /// @throws std::invalid_argument for a t before time() or not finite.
  bool advanceTo(double t, bool (*keepGoing)() = nullptr);

  double time() const;                    ///< s
  const std::vector<double>& q() const;   ///< relative angles, rad, not wrapped
  const std::vector<double>& qd() const;  ///< rad/s
  const std::string& fault() const;       ///< empty: none
  std::string method() const;             ///< in use, such as "dopri5"
  /// How q̈ is found for this chain on this CPU, in words: "closed form for two", "link by link", "link by
  /// link, written out for 5", "in 4 segments side by side (avx2)".
  std::string recursion() const;
  const Scene& scene() const;
  Statistics statistics() const;

  // What acts and what follows from it at the present state; computed when asked for.
  Energy energy() const;
  EnergyBalance energyBalance() const;
  /// q̈ at the present state, n values.
  void accelerations(double* qdd) const;
  /// Whole torque acting in each joint: spring, damper, stops, loads and commands. n values, N m.
  void jointTorques(double* tau) const;
  /// n values.
  void linkMotions(LinkMotion* motions) const;

  // Commands, in force from `start` on (s of time(); the integrator lands there), or from time() on if that
  // is later. Held ones last until the next one of the same joint or link starts, or until `until`; timed
  // ones add to them and to each other until start + duration. What starts later changes nothing before.
  // @returns false, and nothing changes, when commandCapacity commands are timed or wait already.
  // @throws std::invalid_argument for an index out of range, a number that is not finite, and a command that
  //   is over by time().
  static constexpr double now = -std::numeric_limits<double>::infinity();
  bool holdTorque(int joint, double torque, double until, double start = now);
  bool holdForce(int link, Vec2d point, Vec2d force, double moment, double until, double start = now);
  bool addTorque(int joint, double torque, double duration, double start = now);
  bool addForce(int link, Vec2d point, Vec2d force, double moment, double duration, double start = now);
  void clearCommands();
  /// Those in force at time(), as loads: the scene with these added says what acts.
  std::vector<Load> commands() const;

  /// A new state at the present time; the balance starts anew, a fault is forgiven. Commands stay.
  /// @throws std::invalid_argument for wrong sizes or numbers that are not finite.
  void setState(const std::vector<double>& q, const std::vector<double>& qd);
  /// All as it was when constructed, time 0 included: the same calls give the same bits again. Only a
  /// reference to scene() stays good.
  void reset();

 private:
  struct Parts;
  const Scene scene_;
  const int commandCapacity_;
  std::unique_ptr<Parts> parts_;
};

}  // namespace planar_chain
