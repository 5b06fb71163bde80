#pragma once

/// What f is like around a state: its largest eigenvalue, and how much of it is rounding.

#include "ode/system.h"

namespace planar_chain::ode {

class Surroundings {
 public:
  /// f must outlive this object.
  explicit Surroundings(System& f);

  /// Looks anew, if it has not done so for a while: seven evaluations every hundred calls. Allocates nothing.
  void visit(double t, const Vector& y);
  /// The next visit() is the first.
  void forget() { calls_ = 0; }
  /// Looks anew.
  void look(double t, const Vector& y);

  /// |λ| of the largest eigenvalue of J = ∂f/∂y, by power iteration that goes on from look to look; 1/s.
  double largestEigenvalue() const { return eigenvalue_; }
  /// How far rounding of y moves component i over a step of h: no error estimate can be relied on below.
  /// f is off by noise_i, and what that shakes stops growing after the fastest mode's own time 1/|λ|.
  double roundingOver(double h, Eigen::Index i) const { return noise_[i] * timeOf(h); }
  double timeOf(double h) const { return h * eigenvalue_ > 1 ? 1 / eigenvalue_ : h; }
  const Vector& noise() const { return noise_; }

 private:
  void applyJacobian(double t, const Vector& y);

  System& f_;
  int calls_ = 0;
  double eigenvalue_ = 0;
  Vector zigzag_;
  Vector direction_, base_, moved_, slope_, noise_;
};

}  // namespace planar_chain::ode
