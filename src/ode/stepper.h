#pragma once

/// One step of a one-step method for one system: the interface between the methods and the step size control.

#include <Eigen/Core>

#include "ode/system.h"

namespace planar_chain::ode {

/// Only constructors allocate. No function throws.
class Stepper {
 public:
  virtual ~Stepper() = default;

  virtual const char* name() const = 0;
  virtual int order() const = 0;
  /// Order of the embedded solution. 0: the method has no error estimate.
  virtual int errorOrder() const = 0;

  /// The cost of one attempt, in evaluations of f. It is the same on every machine, so choices that use it
  /// are too.
  virtual double cost() const = 0;
  /// Largest h × frequency at which an undamped oscillation does not grow. Infinite for L-stable methods.
  virtual double stabilityLimit() const = 0;
  /// True if error() includes the stiff modes that the step damps.
  virtual bool errorSeesStiffModes() const { return false; }
  virtual System& system() = 0;
  /// Returns f(t, y). Evaluates f unless the last accepted step already did.
  virtual const Vector& derivative(double t, const Vector& y) = 0;
  /// Returns true, and sets error(), if the method can estimate the error of a step without attempting it.
  virtual bool foresees(double /*t*/, double /*h*/, const Vector& /*y*/) { return false; }
  /// Attempts a step from (t, y). Sets increment() ≈ y(t + h) − y and, with an estimate, error().
  virtual void step(double t, double h, const Vector& y) = 0;
  /// As step(), but again from the start of the last accepted step. Discards the f known at its end.
  virtual void stepAgain(double t, double h, const Vector& y) {
    forget();
    step(t, h, y);
    forget();
  }
  /// The results of the last attempt, arranged. Each call returns the same object.
  virtual const Vector& increment() const = 0;
  virtual const Vector& error() const = 0;

  /// Call this when the attempted step is accepted.
  virtual void accept() = 0;
  /// Call this when f has jumped or the state was set. Discards all stored values of f.
  virtual void forget() = 0;
};

}  // namespace planar_chain::ode
