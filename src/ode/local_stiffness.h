#pragma once

/// How stiff f is around a state: its largest eigenvalue, and how far rounding moves it.

#include "ode/system.h"

namespace planar_chain::ode {

class LocalStiffness {
 public:
  /// f must outlive this object. Allocates; the other functions do not.
  explicit LocalStiffness(System& f);

  /// Calls update() at the first of every hundred calls.
  void maybeUpdate(double t, const Vector& y);
  /// Makes the next maybeUpdate() the first one.
  void forget() { calls_ = 0; }
  /// Measures both at the arranged state y, by six evaluations of f.
  void update(double t, const Vector& y);

  /// |λ| of the largest eigenvalue of J = ∂f/∂y, 1/s. Power iteration improves it from update to update.
  double largestEigenvalue() const { return eigenvalue_; }
  /// How far rounding of y moves component i over a step of h. Error estimates below are noise. f is off by
  /// noise_i, and the effect stops growing after the fastest mode's own time 1/|λ|.
  double roundingOver(double h, Eigen::Index i) const { return noise_[i] * timeOf(h); }
  double timeOf(double h) const { return h * eigenvalue_ > 1 ? 1 / eigenvalue_ : h; }
  const Vector& noise() const { return noise_; }

 private:
  void applyJacobian(double t, const Vector& y);

  System& f_;
  int calls_ = 0;  ///< since the last update that maybeUpdate() made
  double eigenvalue_ = 0;
  Vector zigzag_;
  Vector direction_, base_, moved_, slope_, noise_;
};

}  // namespace planar_chain::ode
