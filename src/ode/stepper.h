#pragma once

/// One step of a one-step method for one system: the interface between the methods and the step size control.

#include <limits>

#include "ode/system.h"

namespace planar_chain::ode {

struct Tolerance;

/// Constant properties of a method.
struct MethodFacts {
  const char* name;
  int order;
  /// Order of the embedded solution. 0: the method has no error estimate.
  int errorOrder;
  /// Largest h × frequency at which an undamped oscillation does not grow. Infinite for L-stable methods.
  double stabilityLimit = std::numeric_limits<double>::infinity();
  /// True if error() includes the stiff modes that the step damps.
  bool errorSeesStiffModes = false;
  /// A step may follow so much of the motion that its ends do not show what happens within. The ends of so
  /// many pieces do. stepAgain() costs nothing where there are several.
  int pieces = 1;
};

/// Only constructors allocate. No function throws.
class Stepper {
 public:
  /// f must outlive the stepper.
  Stepper(const MethodFacts& facts, System& f)
      : facts_(facts),
        system_(f),
        increment_(f.sizeInLaneOrder()),
        error_(facts.errorOrder > 0 ? f.sizeInLaneOrder() : 0) {}
  Stepper(const Stepper&) = delete;  // methods hold pointers into themselves
  Stepper& operator=(const Stepper&) = delete;
  virtual ~Stepper() = default;

  const MethodFacts& facts() const { return facts_; }
  System& system() const { return system_; }
  /// The results of the last attempt, in lane order. Each call returns the same object.
  const Vector& increment() const { return increment_; }
  const Vector& error() const { return error_; }

  /// The cost of one attempt, in evaluations of f. It is the same on every machine, so choices that use it
  /// are too.
  virtual double cost() const = 0;
  /// Returns f(t, y). Evaluates f unless the last accepted step already did.
  virtual const Vector& derivative(double t, const Vector& y) = 0;
  /// Returns true, and sets error(), if the method can estimate the error of a step without attempting it.
  virtual bool foresees(const State& /*from*/, double /*h*/) { return false; }
  /// Attempts a step from (t, y). Sets increment() ≈ y(t + h) − y and, with an estimate, error().
  virtual void step(double t, double h, const Vector& y) = 0;
  /// Attempts a step after foresees() with nearly this h. error() is not needed.
  virtual void stepAsForeseen(double t, double h, const Vector& y) { step(t, h, y); }
  /// As step(), but again from the start of the last accepted step. Discards the f known at its end.
  virtual void stepAgain(double t, double h, const Vector& y) {
    forget();
    step(t, h, y);
    forget();
  }
  /// Adds increment() to the state with Kahan's summation and sets its time. Returns false, and changes
  /// nothing, if the result is not finite.
  bool take(State& state, double t) const {
    const bool isFinite =
        vectors_.addCarried(state.y.data(), state.carry.data(), increment_.data(), increment_.size());
    if (isFinite) state.t = t;
    return isFinite;
  }
  /// As take(), after stepAgain() to the time t.
  bool takeAgain(State& state, double t) {
    stepAgain(state.t, t - state.t, state.y);
    return take(state, t);
  }
  /// As takeAgain(), for a step that is a polynomial, and without integrals.
  virtual bool lookAgain(State& state, double t) { return takeAgain(state, t); }
  /// Call this when the attempted step is accepted.
  virtual void accept() = 0;
  virtual void setTolerance(const Tolerance& /*tolerance*/) {}
  /// The values on which the next steps depend (simd/snapshot.h). Set the tolerance before.
  virtual void saveOrRestore(Snapshot& snapshot) = 0;
  /// Call this when f has jumped or the state was set. Discards all stored values of f.
  virtual void forget() = 0;
  /// Call this when the state at the end of the accepted step was moved within its error. Discards f there.
  virtual void forgetSlope() { forget(); }

 protected:
  const MethodFacts facts_;
  System& system_;
  const simd::VectorKernel& vectors_ = system_.vectors();
  Vector increment_, error_;
};

/// A method that solves with the Jacobian where its step starts.
class ImplicitStepper : public Stepper {
 public:
  ImplicitStepper(const MethodFacts& facts, LinearizedSystem& f)
      : Stepper(facts, f), f_(f), startSlope_(f.sizeInLaneOrder()) {}
  const Vector& derivative(double t, const Vector& y) override {
    linearize(t, y);
    return startSlope_;
  }
  void accept() override { linearized_ = false; }
  void forget() override { linearized_ = false; }
  void forgetSlope() override { linearized_ = false; }
  void saveOrRestore(Snapshot& snapshot) override {
    if (snapshot.isReading()) linearized_ = false;
  }

 protected:
  void linearize(double t, const Vector& y) {
    if (!linearized_) f_.linearize(t, y.data(), startSlope_.data());
    linearized_ = true;
  }

  LinearizedSystem& f_;
  Vector startSlope_;  ///< f where the step starts
  bool linearized_ = false;
};

}  // namespace planar_chain::ode
