#pragma once

/// How stiff f is around a state: its largest eigenvalue, and how far rounding moves it.

#include "ode/integrator.h"

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
  /// Rounding of y moves f by noise(), and y over a step of h by noise() × timeOf(h): the effect stops
  /// growing after the fastest mode's own time 1/|λ|. Error estimates below that are noise.
  const Vector& noise() const { return noise_; }
  double timeOf(double h) const { return h * eigenvalue_ > 1 ? 1 / eigenvalue_ : h; }

 private:
  void applyJacobian(double t, const Vector& y);

  System& f_;
  int calls_ = 0;  ///< since the last update that maybeUpdate() made
  double eigenvalue_ = 0;
  Vector zigzag_, direction_, base_, moved_, slope_, noise_;
};

/// The error that a step of h may add to component i: most × Tolerance::size(), or perNoise × noise_i if that
/// is more.
struct Allowance {
  Allowance(const Tolerance& tolerance, const LocalStiffness& stiffness, double h)
      : most(std::max(share * tolerance.value * std::min(std::max(h, shortestCounted), 1.0),
                      std::numeric_limits<double>::epsilon())),
        perNoise(std::min(1.0, tolerance.value * perRounding) * clearly * stiffness.timeOf(h)) {}

  double most, perNoise;

 private:
  static constexpr double shortestCounted = 1e-3;  // s
  static constexpr double share = 0.25;            // of the tolerance that a step's error may use
  static constexpr double perRounding = 1e10;  // 1 over the tolerance down to which rounding counts in full
  static constexpr double clearly = 4;         // above rounding, so that steps whose estimate is that grow
};

}  // namespace planar_chain::ode
