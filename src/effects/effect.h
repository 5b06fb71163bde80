#pragma once

/// What acts on a chain besides pins, gravity and inertia: springs and dampers, stops, loads, commands.
///
/// An effect is one class in one pair of files. It adds moments N about the inner pins and forces F, supplies
/// or takes power, and gives the exact derivative of all this, its Taylor coefficients, and the states and
/// times at which it is not smooth. Its kind (effect_kind.h) has its keys in the scene, its stored energy and
/// its words. src/README.md shows how to write one.
///
/// Every effect must write mostActing(), acting(), apply() and addTorques(). The other functions belong to
/// what only some effects have; by default they say that this one has it not. Unless a function says
/// otherwise, it takes states in chain order and allocates nothing. Units are SI; vectors have ground
/// components.

#include <cstddef>
#include <limits>

#include "ode/switches.h"
#include "planar_chain/planar.h"
#include "recursion/acting.h"

namespace planar_chain {

/// W: what an effect gives to the chain, and what it takes from it.
struct Powers {
  double supplied = 0, dissipated = 0;

  Powers& operator+=(const Powers& other) {
    supplied += other.supplied;
    dissipated += other.dissipated;
    return *this;
  }
};

/// A state, n numbers each: absolute angles θ and rates ω.
struct ChainState {
  double t;
  const double *theta, *omega;
  // Only where forces act; otherwise nullptr.
  const Rotation<double>* e = nullptr;  ///< exp(i θ_j)
  const Vec2d* pinVelocity = nullptr;   ///< of the inner pins, m/s, the first reach() of them
};

/// Where an effect adds what it gives, n numbers each.
struct Actions {
  double* N;  ///< moments about the inner pins, N m
  Vec2d* F;   ///< forces, N; nullptr where no effect has any
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

/// The states at which an effect switches, and how it does.
class Switching : public ode::Switches {
 public:
  /// Chooses for the state y = [θ ω …], whatever was chosen before.
  virtual void enterState(const double* y) = 0;
  /// Makes every switch that is due at y.
  virtual void change(const double* y) = 0;
};

/// +τ on body i, −τ on the body before.
inline void addJointTorque(double tau, int i, double* N) {
  N[i] += tau;
  if (i > 0) N[i - 1] -= tau;
}

class Effect {
 public:
  virtual ~Effect() = default;

  // ---- What acts ------------------------------------------------------------------------------------

  /// The most that this effect ever adds: moments, or forces too.
  virtual Acting mostActing() const = 0;
  /// What it adds at present. apply() is called only if this is not `nothing`.
  virtual Acting acting() const = 0;
  /// True if it ever supplies or takes power.
  virtual bool hasPower() const { return true; }
  /// How many inner pins, from the ground, it needs the velocity of: 0 without forces.
  virtual int reach() const { return 0; }
  /// Adds moments and forces at a state. Returns the powers.
  virtual Powers apply(const ChainState& at, const Actions& to) = 0;
  /// Adds the torque in each joint, N m, + on the joint's own link.
  virtual void addTorques(const ChainState& at, double* tau) = 0;

  /// Long chains have their states in lane order (lanes/arrangement.h); in short ones it is chain order. An
  /// effect that works in it saves reordering, and has this in place of apply() wherever f is evaluated.
  virtual bool worksInLanes() const { return false; }
  virtual Powers applyInLanes(const double* /*theta*/, const double* /*omega*/, double* /*N*/) { return {}; }

  // ---- Its exact derivative, for the stiff methods --------------------------------------------------

  /// Adds k_i and d_i of each joint, N m/rad and N m s/rad, of a torque that changes by −k δq − d δq̇. Only
  /// what is constant between two switches.
  virtual void addStiffness(double* /*k*/, double* /*d*/) const {}
  /// The same for k and d that depend on the state. True if there are any.
  virtual bool isNonlinear() const { return false; }
  virtual void addTangents(const ChainState& /*at*/, double* /*k*/, double* /*d*/) const {}
  /// Adds Σ X·F of each body: how much less the moments of its forces get when it turns by 1 rad.
  virtual void addForceStiffness(const ChainState& /*at*/, double* /*XF*/) {}
  /// How the powers change along a change of the state; not for an effect that works in lane order.
  virtual Powers powersAlong(const ChainState& /*at*/, const StateChange& /*along*/) { return {}; }
  /// The same for one that does.
  virtual Powers powersAlongInLanes(const double* /*omega*/, const double* /*v*/) { return {}; }

  // ---- Time -------------------------------------------------------------------------------------------

  /// Chooses what acts in [t, until()); the integrator lands on until(), s, and enters again.
  virtual void enter(double /*t*/) {}
  virtual double until() const { return std::numeric_limits<double>::infinity(); }
  /// The longest step that resolves what changes with time, s.
  virtual double longestStep() const { return std::numeric_limits<double>::infinity(); }
  /// True if what acts changes with time alone; applyRates() then adds ∂N/∂t, ∂F/∂t and returns ∂power/∂t.
  virtual bool variesWithTime() const { return false; }
  virtual Powers applyRates(const ChainState& /*at*/, const Actions& /*to*/) { return {}; }

  // ---- Its Taylor series --------------------------------------------------------------------------------

  /// Makes room for so many orders. Allocates.
  virtual void reserveSeries(int /*orders*/) {}
  /// Adds the coefficients of order k > 0 of N and F, beside those of addStiffness(), after all lower orders.
  virtual void addOrder(int /*k*/, const Series& /*known*/, const Actions& /*to*/) {}

  // ---- Switches -----------------------------------------------------------------------------------------

  /// nullptr for an effect that is smooth in every state.
  virtual Switching* switching() { return nullptr; }
};

}  // namespace planar_chain
