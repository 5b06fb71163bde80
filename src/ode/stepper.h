#pragma once

/// One step of a one-step method for one system: what every family of methods shows to those that choose the
/// step size.

#include <Eigen/Core>

#include "ode/system.h"

namespace planar_chain::ode {

class Stepper {
 public:
  virtual ~Stepper() = default;

  virtual const char* name() const = 0;
  virtual int order() const = 0;
  /// Order of the embedded solution; 0: the method has no error estimate.
  virtual int errorOrder() const = 0;

  /// Of one try of a step, in evaluations of f: the same on every machine, so that choices by it are too.
  virtual double cost() const = 0;
  /// Largest h × frequency at which an undamped oscillation does not grow; infinite for L-stable methods.
  virtual double stabilityLimit() const = 0;
  /// Whether error() shows oscillations too fast for the step, which the method damps away, in their size.
  virtual bool seesWhatItDamps() const { return false; }
  virtual System& system() = 0;
  /// f(t, y), evaluated unless the last accepted step left it behind.
  virtual const Vector& derivative(double t, const Vector& y) = 0;
  /// Leaves in error() that of a step from (t, y), if it can tell without trying one. Allocates nothing.
  virtual bool foresees(double /*t*/, double /*h*/, const Vector& /*y*/) { return false; }
  /// Tries a step from (t, y): increment() ≈ y(t + h) − y and, with an estimate, error(). Allocates nothing.
  virtual void step(double t, double h, const Vector& y) = 0;
  /// The same from where the last accepted step began; what a method knows of where that one ended is lost.
  virtual void stepAgain(double t, double h, const Vector& y) {
    forget();
    step(t, h, y);
    forget();
  }
  /// These are always the same objects.
  virtual const Vector& increment() const = 0;
  virtual const Vector& error() const = 0;

  /// The step just tried was taken.
  virtual void accept() = 0;
  /// f has jumped or the state was set: nothing known of it holds.
  virtual void forget() = 0;
};

}  // namespace planar_chain::ode
