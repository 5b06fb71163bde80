#pragma once

/// The interface of all effects. An effect acts on a chain besides pins, gravity and inertia: springs and
/// dampers, stops, friction, rotors, drives, loads, commands.
///
/// Effect is what every effect is: moments N about the inner pins, forces F, powers, their exact derivatives
/// and Taylor coefficients. What only some effects are has an interface of its own, which the effect returns:
///
///     events()      not smooth in every state          Events
///     jointConstraint()  couples accelerations, or moves the base  JointConstraint
///     forces()      acts with forces on bodies          Forces
///     inLanes()     computes moments in the order of long chains          InLanes
///
/// An effect is one class in one pair of files. Its kind (effect_kind.h) has its keys in the scene, its
/// stored energy and its words in the log. src/README.md shows how to write one, and the order of all calls.
///
/// Unless a function says otherwise, it takes states in chain order and allocates nothing. Pointers in
/// arguments are valid during the call. Units are SI. Vectors have ground components.

#include <cmath>
#include <cstddef>
#include <limits>

#include "effects/joint_constraint.h"
#include "lanes/lane_order.h"
#include "ode/events.h"
#include "planar_chain/chain.h"
#include "planar_chain/planar.h"
#include "recursion/force_tangent.h"
#include "recursion/load_kind.h"
#include "simd/snapshot.h"

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
  // Set if forces act, otherwise nullptr. Against the ground.
  const Rotation<double>* e = nullptr;  ///< exp(i θ_j)
  const Vec2d* pinVelocity = nullptr;   ///< of the first reach() inner pins, m/s
  double baseRate = 0;                  ///< of the base's angle, rad/s: ω + baseRate is against the ground
  const Vec2d* pin = nullptr;  ///< the positions of these pins, m; nullptr if no effect asks for positions
};

/// The moments μ in the joints by their couplings, N m, and ÿ of the angles, rad/s², at a state y in chain
/// order.
struct JointAnswer {
  const double *moments, *accelerations;
};
class Mechanics {
 public:
  /// Returns the answer at this state, valid until the next call. The next evaluation of f at the same state
  /// is free.
  virtual JointAnswer answer(double t, const double* y) = 0;
  /// Call it after a joint changes the direction in which it slips; with `holds` after joints stick or break
  /// loose.
  virtual void forget(bool holds) = 0;
  /// Sets prescribed joints to their motion at t, exactly, and moves the others to satisfy the constraint of
  /// the tip. If that changes a component by more than `most`, of 1 + |y|, it changes nothing. Without a held
  /// tip it moves the prescribed joints alone, however far.
  virtual void snapPrescribed(double t, double* y, double most) = 0;
  /// True if prescribed joints and a held tip leave the motion undetermined, to rounding.
  virtual bool isStretched(double t, const double* y) = 0;

 protected:
  ~Mechanics() = default;
};

/// The sums to which an effect adds its moments and forces, n each.
struct Actions {
  /// A revolute joint has the moment about the own point of its body and of those that turn with it, N m (a
  /// moment on body j belongs to Coordinates::turner(j)). A prismatic joint has the force along its axis, N.
  double* N = nullptr;
  Vec2d* F = nullptr;  ///< forces at the own points of the bodies, N; nullptr if no effect has any
};

/// A change of a state: of the angles and rates, the velocities of the first reach() pins, and the base's
/// angle and rate. So θ_j against the ground changes by u_j + turn, ω_j by v_j + speed.
struct StateChange {
  const double *u, *v;
  const Vec2d* pinVelocity;
  const Vec2d* pin = nullptr;  ///< of the positions of these pins, if states have them
  double turn = 0, speed = 0;
};

/// The Taylor coefficients of a motion around t that are known so far.
struct Series {
  double t;
  int n;
  const double* c;            ///< row j of 2n numbers: order j of θ, then of ω
  const Rotation<double>* e;  ///< row j of n: order j of exp(i θ)

  const double* theta(int j) const { return c + std::ptrdiff_t{2} * n * j; }
  const double* omega(int j) const { return theta(j) + n; }
  const Rotation<double>* rotation(int j) const { return e + std::ptrdiff_t{n} * j; }
};

/// |x_i| + |x_{i−1}|, or |x_i|: what the rounding of a coordinate counts by.
inline double sumOfSizes(const double* x, const Coordinate& q) {
  return std::abs(x[q.joint]) + (q.inner >= 0 ? std::abs(x[q.inner]) : 0);
}

/// The events of an effect (ode/events.h), and what to do when one happens.
class Events {
 public:
  virtual ~Events() = default;
  /// Its event functions, which live as long as this object. The list never changes.
  virtual void addEvents(ode::EventList& to) const = 0;
  /// Chooses what acts at the state y = [θ ω …] at t, whatever acted before. Linear models call it, too: they
  /// forget what a latch remembers.
  virtual void enterState(double t, const double* y) = 0;
  /// Chooses what acts as the same effect in a scene with other numbers did.
  virtual void takeFrom(const Events& /*other*/) {}
  /// Fires every event that has happened at t and y. Also called when none of this effect has, and after
  /// enter(). located: the event that ends the step, of any effect. May hold joints.
  virtual void fire(double t, double* y, const ode::LocatedEvent& located) = 0;
};

/// The forces of an effect on bodies.
class Forces {
 public:
  virtual ~Forces() = default;
  /// The number of inner pins, from the ground outwards, whose velocity it needs now: up to the last body
  /// with a force.
  virtual int reach() const = 0;
  /// Adds Σ X·F of each body, N m: the decrease of the forces' moments per rad that the body turns. Only of
  /// forces whose components do not depend on the state.
  virtual void addForceStiffness(const ChainState& /*at*/, double* /*XF*/) {}
  /// True if forces depend on the positions or velocities of their points. The answer never changes.
  virtual bool dependOnMotion() const { return false; }
  /// True if they depend on positions, so that states have `pin`. The answer never changes.
  virtual bool dependOnPosition() const { return false; }
  /// Adds K and D of each body: the change of its forces with its motion (recursion/force_tangent.h). Only if
  /// dependOnMotion().
  virtual void addForceTangents(const ChainState& /*at*/, ForceTangent* /*to*/) {}
  /// Called once. The laws of the base, which outlive the effect; nullptr: it stands still.
  virtual void takeBase(const BaseLaws* /*laws*/) {}
};

/// An effect that takes states in lane order, so that long chains need not reorder them
/// (lanes/lane_order.h). It has moments alone, which do not depend on t explicitly. In short chains both
/// orders are the same.
class InLanes {
 public:
  virtual ~InLanes() = default;
  /// Takes the order from now on; nullptr: chain order. Called before all others, in long chains twice.
  /// Allocates.
  virtual void takeLaneOrder(const LaneOrder* lanes) = 0;
  /// As Effect::apply() and Effect::powersAlong(), which then need not be there for chains that do not
  /// couple.
  virtual Powers applyInLanes(const double* theta, const double* omega, double* N) = 0;
  virtual Powers powersAlongInLanes(const double* omega, const double* v) = 0;
};

class Effect {
 public:
  Effect() = default;
  Effect(const Effect&) = delete;  // effects hold pointers into themselves
  Effect& operator=(const Effect&) = delete;
  virtual ~Effect() = default;

  // ---- What it is; the answers never change ---------------------------------------------------------

  /// The most that this effect can ever add: moments, or forces too.
  virtual LoadKind mostActing() const = 0;
  /// True if it ever supplies or takes power. An effect that only stores energy returns false.
  virtual bool hasPower() const { return true; }
  /// True if parts of k and d depend on the state, beyond its events. If it is false, addTangents() is not
  /// called.
  virtual bool isNonlinear() const { return false; }
  virtual Events* events() { return nullptr; }
  virtual JointConstraint* jointConstraint() { return nullptr; }
  virtual Forces* forces() { return nullptr; }
  virtual InLanes* inLanes() { return nullptr; }

  // ---- What acts ------------------------------------------------------------------------------------

  /// The most that it adds at present. apply() is called only if this is not `nothing`.
  virtual LoadKind acting() const { return mostActing(); }
  /// True if its moments are the same in every state, until an event or enter(), and it has no forces.
  /// apply() with N = nullptr then returns the powers alone.
  virtual bool hasConstantMoments() const { return false; }
  /// Adds the moments and forces at a state. Returns the powers.
  virtual Powers apply(const ChainState& at, const Actions& to) = 0;
  /// Adds the torque in each joint, N m, + on the joint's own link.
  virtual void addTorques(const ChainState& at, double* tau) = 0;

  // ---- The exact derivative, for the stiff methods --------------------------------------------------

  /// Adds k_i and d_i of each joint, N m/rad and N m s/rad: its torque changes by −k δq − d δq̇. Adds only the
  /// parts that are constant between two events.
  virtual void addStiffness(double* /*k*/, double* /*d*/) const {}
  /// Adds the other parts, if isNonlinear().
  virtual void addTangents(const ChainState& /*at*/, double* /*k*/, double* /*d*/) const {}
  /// The change of the powers with a change of the state. Needed by every effect with power.
  virtual Powers powersAlong(const ChainState& /*at*/, const StateChange& /*along*/) { return {}; }

  // ---- Time -------------------------------------------------------------------------------------------

  /// Chooses what acts in [t, until()), s. A step ends at the least until() of all effects, and enter() of
  /// all is called again. An effect that needs the state at its own until() has events(): fire() is called
  /// next.
  virtual void enter(double /*t*/) {}
  virtual double until() const { return std::numeric_limits<double>::infinity(); }
  /// The longest step that resolves the changes with time, s.
  virtual double longestStep() const { return std::numeric_limits<double>::infinity(); }
  /// True if N, F, the power or what it couples depends on t explicitly, from enter() on.
  virtual bool variesWithTime() const { return false; }
  /// Adds ∂N/∂t and ∂F/∂t. Returns ∂power/∂t.
  virtual Powers applyRates(const ChainState& /*at*/, const Actions& /*to*/) { return {}; }

  /// Remembers what does not follow from time, state and commands alone: what sticks, what lags. recall()
  /// restores it, and enter() is called next.
  virtual void remember() {}
  virtual void recall() {}
  /// Saves or restores all that changes along a motion: what acts since the last enter(), switches, what
  /// sticks or lags. Neither enter() nor enterState() is called after it.
  virtual void saveOrRestore(Snapshot& /*snapshot*/) {}

  // ---- Its Taylor series --------------------------------------------------------------------------------

  /// False if it has no series: method taylor is then refused, and auto does without it.
  virtual bool hasSeries() const { return true; }
  /// Reserves memory for orders 0 … orders − 1. Allocates.
  virtual void reserveSeries(int /*orders*/) {}
  /// Adds the coefficients of order k > 0 of N and F, except the part that addStiffness() covers. apply()
  /// gave order 0, and orders 1 … k − 1 have been added, one by one. Orders 0 … k of θ, ω and e are known.
  virtual void addOrder(int /*k*/, const Series& /*known*/, const Actions& /*to*/) {}
};

}  // namespace planar_chain
