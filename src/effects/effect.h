#pragma once

/// The interface of all effects. An effect acts on a chain besides pins, gravity and inertia: springs and
/// dampers, stops, loads, commands.
///
/// An effect adds moments N about the inner pins and forces F. It may supply or take power. It also computes
/// the exact derivatives and Taylor coefficients of N, F and power, and the states and times at which they
/// are not smooth. An effect is one class in one pair of files. Its kind (effect_kind.h) has its keys in the
/// scene, its stored energy and its words in the log. src/README.md shows how to write one.
///
/// Every effect must implement mostActing(), acting(), apply() and addTorques(). The other functions are
/// optional; their defaults suit an effect without that feature. Unless a function says otherwise, it takes
/// states in chain order and allocates nothing. Units are SI. Vectors have ground components.

#include <cstddef>
#include <limits>
#include <vector>

#include "ode/switches.h"
#include "planar_chain/motion_law.h"
#include "planar_chain/planar.h"
#include "recursion/coupled.h"
#include "recursion/load_kind.h"

namespace planar_chain {

/// The power of an effect, W: supplied to the chain, and taken from it.
struct Powers {
  double supplied = 0, dissipated = 0;

  Powers& operator+=(const Powers& other) {
    supplied += other.supplied;
    dissipated += other.dissipated;
    return *this;
  }
};

/// A state, n numbers each: absolute angles θ and rates ω. If the base turns, both are measured from it.
struct ChainState {
  double t;
  const double *theta, *omega;
  // Set if forces act, otherwise nullptr.
  const Rotation<double>* e = nullptr;  ///< exp(i θ_j)
  const Vec2d* pinVelocity = nullptr;   ///< of the first reach() inner pins, m/s
  double baseRate = 0;                  ///< of the base's angle, rad/s
};

/// What couples the accelerations of the bodies at one time: of each joint, and the motion of the base.
struct Couplings {
  std::vector<Coupling<double>> joints;
  std::vector<GivenMotion> held;  ///< the motion of each held joint
  GivenMotion x, y, angle;        ///< of the base
};

/// The moments μ in the joints by their couplings, N m, and ÿ of the angles, rad/s², at a state y in chain
/// order.
struct JointAnswer {
  const double *moments, *accelerations;
};
class Mechanics {
 public:
  /// Valid until the next one. The next evaluation of f at the same state is free.
  virtual JointAnswer answer(double t, const double* y) = 0;
  /// Call it when a joint slides otherwise from now on. holds: or when joints stick or break loose.
  virtual void forget(bool holds) = 0;
  /// Puts held joints where they are at t, exactly.
  virtual bool hold(double t, double* y) = 0;

 protected:
  ~Mechanics() = default;
};

/// The sums to which an effect adds its moments and forces, n each.
struct Actions {
  double* N = nullptr;  ///< moments about the inner pins, N m
  Vec2d* F = nullptr;   ///< forces, N; nullptr if no effect has any
};

/// A change of a state: of the angles, the rates, and the first reach() pin velocities.
struct StateChange {
  const double *u, *v;
  const Vec2d* pinVelocity;
};

/// The Taylor coefficients of a motion around t that are known so far.
struct Series {
  double t;
  int n;
  const double* c;            ///< row j of 2n numbers: order j of θ, then of ω
  const Rotation<double>* e;  ///< row j of `perOrder`: order j of exp(i θ)
  std::ptrdiff_t perOrder;

  const double* theta(int j) const { return c + std::ptrdiff_t{2} * n * j; }
  const double* omega(int j) const { return theta(j) + n; }
};

/// The switches of an effect: at which states they are due, and how they are made.
class Switching : public ode::Switches {
 public:
  /// Sets every switch for the state y = [θ ω …] at t, whatever its position before.
  virtual void enterState(double t, const double* y) = 0;
  /// Makes every switch that is due at t and y. found: what crossing() returned for the step that ends here,
  /// or nothing of it. May hold joints.
  virtual void change(double t, double* y, const ode::Crossing& found) = 0;
};

/// +τ on body i, −τ on the body before.
inline void addJointTorque(double tau, int i, double* N) {
  N[i] += tau;
  if (i > 0) N[i - 1] -= tau;
}

class Effect {
 public:
  Effect() = default;
  Effect(const Effect&) = delete;  // effects hold pointers into themselves
  Effect& operator=(const Effect&) = delete;
  virtual ~Effect() = default;

  // ---- What acts ------------------------------------------------------------------------------------

  /// The most that this effect can ever add: moments, or forces too.
  virtual LoadKind mostActing() const = 0;
  /// The most that it adds at present. apply() is called only if this is not `nothing`.
  virtual LoadKind acting() const = 0;
  /// True if it ever supplies or takes power. An effect that only stores energy returns false.
  virtual bool hasPower() const { return true; }
  /// The number of inner pins, from the ground outwards, whose velocity it needs. 0 without forces.
  virtual int reach() const { return 0; }
  /// Adds the moments and forces at a state. Returns the powers.
  virtual Powers apply(const ChainState& at, const Actions& to) = 0;
  /// True if its moments are the same in every state, until a switch or enter(), and it has no forces.
  /// apply() with N = nullptr then returns the powers alone.
  virtual bool hasConstantMoments() const { return false; }
  /// Adds the torque in each joint, N m, + on the joint's own link.
  virtual void addTorques(const ChainState& at, double* tau) = 0;

  /// True if the effect has applyInLanes(), which f then calls in place of apply(). Long chains store their
  /// states in lane order (lanes/arrangement.h), so this saves reordering. In short chains both orders are
  /// the same.
  virtual bool worksInLanes() const { return false; }
  virtual Powers applyInLanes(const double* /*theta*/, const double* /*omega*/, double* /*N*/) { return {}; }

  // ---- Its exact derivative, for the stiff methods --------------------------------------------------

  /// Adds k_i and d_i of each joint, N m/rad and N m s/rad: its torque changes by −k δq − d δq̇. Adds only the
  /// parts that are constant between two switches.
  virtual void addStiffness(double* /*k*/, double* /*d*/) const {}
  /// True if parts of k and d depend on the state. If it is false, the stiff methods do not call
  /// addTangents().
  virtual bool isNonlinear() const { return false; }
  /// Adds these parts.
  virtual void addTangents(const ChainState& /*at*/, double* /*k*/, double* /*d*/) const {}
  /// Adds Σ X·F of each body: the decrease of its forces' moments per rad that it turns.
  virtual void addForceStiffness(const ChainState& /*at*/, double* /*XF*/) {}
  /// The change of the powers with a change of the state. Not called if worksInLanes().
  virtual Powers powersAlong(const ChainState& /*at*/, const StateChange& /*along*/) { return {}; }
  /// The same for an effect that works in lane order.
  virtual Powers powersAlongInLanes(const double* /*omega*/, const double* /*v*/) { return {}; }

  // ---- Time -------------------------------------------------------------------------------------------

  /// Chooses what acts in [t, until()), s. A step ends at until(), and enter() is called again.
  virtual void enter(double /*t*/) {}
  virtual double until() const { return std::numeric_limits<double>::infinity(); }
  /// The longest step that resolves the changes with time, s.
  virtual double longestStep() const { return std::numeric_limits<double>::infinity(); }
  /// True if N, F or the power depend on t explicitly.
  virtual bool variesWithTime() const { return false; }
  /// Adds ∂N/∂t and ∂F/∂t. Returns ∂power/∂t.
  virtual Powers applyRates(const ChainState& /*at*/, const Actions& /*to*/) { return {}; }

  // ---- Coupled joints and the base --------------------------------------------------------------------

  /// True if it couples accelerations: rotors, held joints, a moving base.
  virtual bool couples() const { return false; }
  /// Writes order k of the Taylor series around t of what it couples. Order 0 is what it couples at t.
  virtual void couple(double /*t*/, int /*k*/, Couplings& /*to*/) const {}
  /// Replaces the law of a joint that it drives.
  virtual void follow(int /*joint*/, const MotionLaw& /*law*/) {}
  /// Replaces the motion of the base that it gives.
  virtual void followBase(const BaseLaws& /*laws*/) {}
  /// Gives access to the moments in the joints. `mechanics` outlives the effect.
  virtual void attach(Mechanics& /*mechanics*/) {}

  // ---- Its Taylor series --------------------------------------------------------------------------------

  /// Reserves memory for orders 0 … orders − 1. Allocates.
  virtual void reserveSeries(int /*orders*/) {}
  /// Adds the coefficients of order k > 0 of N and F, except the part that addStiffness() covers. apply()
  /// gave order 0, and all lower orders have been added. Orders 0 … k of θ and ω are known.
  virtual void addOrder(int /*k*/, const Series& /*known*/, const Actions& /*to*/) {}

  // ---- Switches -----------------------------------------------------------------------------------------

  /// Returns the switches, or nullptr if the effect is smooth in every state.
  virtual Switching* switching() { return nullptr; }
};

}  // namespace planar_chain
