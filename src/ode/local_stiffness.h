#pragma once

/// How stiff f is around a state: its largest eigenvalue, and how far rounding moves it.

#include <algorithm>
#include <cmath>
#include <limits>

#include "ode/integrator.h"
#include "simd/power_iteration.h"

namespace planar_chain::ode {

class LocalStiffness {
 public:
  /// f must outlive this object. works: the number of components at the end that move no other one and
  /// depend on the unit of mass; they count as no stiffness. Allocates; the other functions do not.
  explicit LocalStiffness(System& f, Eigen::Index works = 0) : f_(f), works_(works) {
    Vector pattern(f.size());
    pattern.setOnes();
    for (Eigen::Index i = 1; i < pattern.size(); i += 2) pattern[i] = -1;
    f.toLaneOrder(pattern.data(), zigzag_.data());
    direction_ = zigzag_;
  }

  /// Steps between updates. An update takes six evaluations of f, so these cost at most 6 % of explicit steps
  /// with one evaluation each. The eigenvalue changes with the chain's shape, over hundreds of steps.
  static constexpr int period = 100;

  /// Calls update() at the first of every `period` calls.
  void maybeUpdate(double t, const Vector& y, const Tolerance& tolerance) {
    if (calls_ == 0) update(t, y, tolerance);
    calls_ = (calls_ + 1) % period;
  }
  /// Makes the next maybeUpdate() the first one.
  void forget() { calls_ = 0; }
  /// Call this when f has become stiffer or less stiff. As forget(); and from now on the least stiff state
  /// gives the time that an error of a rate lasts, also after a stop is left.
  void change() {
    forget();
    lasting_ = &least_;
  }
  /// Also forgets the direction that power iteration has found.
  void begin() {
    forget();
    direction_ = zigzag_;
    least_ = std::numeric_limits<double>::infinity();
    lasting_ = &eigenvalue_;
  }
  void saveOrRestore(Snapshot& snapshot) {
    bool isLeast = lasting_ == &least_;
    snapshot(calls_, eigenvalue_, counted_, least_, isLeast, noise_, direction_);
    lasting_ = isLeast ? &least_ : &eigenvalue_;
  }
  /// Measures both at the state y in lane order, by six evaluations of f. Units that the tolerance does not
  /// have are 1.
  void update(double t, const Vector& y, const Tolerance& tolerance = {}) {
    f_.slope(t, y.data(), base_.data());
    moved_.tail(works_) = y.tail(works_);
    eigenvalue_ = simd::largestEigenvalue<double>(
        {y.size() - works_, y.data(), base_.data(), moved_.data(), slope_.data(), direction_.data()},
        [&] { f_.slope(t, moved_.data(), slope_.data()); });
    if (!simd::isMeasured(eigenvalue_)) {
      direction_ = zigzag_.cwiseAbs();
      eigenvalue_ = 0;
    }
    least_ = std::min(least_, eigenvalue_);

    // Move each component by one unit in the last place of unit_i + |y_i|, up and down by turns.
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      const double unit = i < tolerance.unit.size() ? tolerance.unit[i] : 1;
      const double ulp = std::numeric_limits<double>::epsilon() * (unit + std::abs(y[i]));
      moved_[i] = y[i] + zigzag_[i] * ulp;
    }
    f_.slope(t, moved_.data(), slope_.data());
    counted_ = 0;
    noise_ = (slope_ - base_).cwiseAbs();
    if (!noise_.allFinite()) noise_.setZero();
  }

  /// |λ| of the largest eigenvalue of J = ∂f/∂y, 1/s. Power iteration improves it from update to update.
  double largestEigenvalue() const { return eigenvalue_; }
  /// Rounding of y moves f by noise(), and y over a step of h by noise() × timeOf(h): the effect stops
  /// growing after the fastest mode's own time 1/|λ|. Error estimates below that are noise.
  const Vector& noise() const { return noise_; }
  /// The share of it that counts beside this tolerance: below 1e-10 in proportion to it, or that of count()
  /// since the last update, if that is more.
  double share(double tolerance) const {
    constexpr double perRounding = 1e10;  // 1 over the tolerance down to which rounding counts in full
    return std::max(counted_, std::min(1.0, tolerance * perRounding));
  }
  void count(double share) { counted_ = share; }
  bool isCounted() const { return counted_ > 0; }
  double timeOf(double h) const { return h * eigenvalue_ > 1 ? 1 / eigenvalue_ : h; }
  /// T, s: the shortest time for which a rate's error turns the links (integrator.h).
  double turningTime(double h, double tolerance) const {
    return std::min(1.0, std::max({h / 2, 1 / *lasting_, leastTurningTime(tolerance)}));
  }
  /// The part of it that the tolerance determines.
  static double leastTurningTime(double tolerance) {
    constexpr double byThemselves = 2e-10;  // the tolerance at which rates count in full
    const double fine = byThemselves / tolerance;
    return fine * fine;
  }

 private:
  System& f_;
  const Eigen::Index works_;
  int calls_ = 0;  ///< since the last update that maybeUpdate() made
  double eigenvalue_ = 0, counted_ = 0;
  double least_ = std::numeric_limits<double>::infinity();  ///< eigenvalue_ since begin()
  const double* lasting_ = &eigenvalue_;                    ///< that of turningTime()
  Vector noise_{f_.sizeInLaneOrder()}, base_ = noise_, moved_ = noise_, slope_ = noise_, direction_ = noise_;
  Vector zigzag_ = noise_;  ///< the highest mode of a chain: every component opposite to its neighbours
};

/// The error that a step of h may add to an angle: most × size, or perNoise × noise_i if that is more. A rate
/// has mostOfRates in place of most.
struct Allowance {
  Allowance(const Tolerance& tolerance, const LocalStiffness& stiffness, double h)
      : most(mostAt(tolerance.value, h)),
        turningTime(tolerance.ofRates ? 1 : stiffness.turningTime(h, tolerance.value)),
        mostOfRates(tolerance.ofRates ? mostAt(*tolerance.ofRates, h) : most / turningTime),
        perNoise(stiffness.share(tolerance.value) * clearly * stiffness.timeOf(h)) {}

  double most, turningTime, mostOfRates, perNoise;

  /// The size of component i of y.
  double size(const Tolerance& tolerance, const Vector& y, Eigen::Index i) const {
    const double size = tolerance.size(y, i);
    return i < tolerance.firstRate
               ? size
               : std::min(size, slowUnits * tolerance.unit[i] + turningTime * std::abs(y[i]));
  }

  static constexpr double shortestCounted = 1e-3;  ///< s
  static constexpr double share = 0.25;            ///< of the tolerance that a step's error may use
  static constexpr double slowUnits = 16;          ///< of a rate: its size counts in full up to there

 private:
  static double mostAt(double tolerance, double h) {
    return std::max(share * tolerance * std::min(std::max(h, shortestCounted), 1.0),
                    std::numeric_limits<double>::epsilon());
  }

  static constexpr double clearly = 4;  // above rounding, so that steps whose estimate is that grow
};

}  // namespace planar_chain::ode
