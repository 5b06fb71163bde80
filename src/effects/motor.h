#pragma once

/// One motor: what motors.h has above. Nothing here allocates.

#include <algorithm>
#include <limits>

#include "effects/motors.h"
#include "planar_chain/chain.h"
#include "simd/elementary.h"

namespace planar_chain {

/// While a torque lags, steps are so short that its series has no cancellation: in a joint that is held it
/// moves nothing, and no error estimate sees it. It lags no longer when x differs from u by less than a
/// rounding of what it was.
inline constexpr double longestByLags = 3, lagsToTheEnd = 39;

class Motor {
 public:
  Motor(const Coordinates& coordinates, int joint, const Joint& values)
      : q(coordinates, joint),
        limit_(values.other("effort_limit")),
        slope_(values.has(noLoadSpeed) ? limit_ / values.other(noLoadSpeed) : 0),
        lag_(values.other(timeConstant)) {}

  Coordinate q;  ///< of the joint

  /// u from t on.
  void command(double t, double u) {
    if (lagged(t) == u_) x0_ = u_;  // it has arrived, and stays for times before t too
    if (u == u_) return;
    x0_ = lagged(t);
    t0_ = t;
    u_ = u;
    isNew_ = true;
  }
  void finish() {
    x0_ = u_;
    isNew_ = true;
  }
  /// Sets x at t.
  void set(double t, double x) {
    x0_ = x;
    t0_ = t;
    isNew_ = true;
  }
  /// x at t, N m.
  double lagged(double t) const {
    const bool isOver = !(t - t0_ < lagsToTheEnd * lag_);
    return lag_ == 0 || isOver ? u_ : u_ + (x0_ - u_) * simd::exp(-(t - t0_) / lag_);
  }
  double rate(double t) const { return lag_ > 0 ? (u_ - lagged(t)) / lag_ : 0; }
  /// True if x changes from t on.
  bool isLagging(double t) const { return lag_ > 0 && lagged(t) != u_; }
  bool hasLag() const { return lag_ > 0; }
  double lag() const { return lag_; }
  /// Returns the coefficient k > 0 of the Taylor series of x around t, x_k = (x − u) (−1/T)^k / k!. Call it
  /// for 1, 2, … in turn.
  double order(int k, double t) {
    if (k == 1) coefficient_ = lag_ > 0 ? lagged(t) - u_ : 0;
    if (lag_ > 0) coefficient_ /= -lag_ * k;
    return coefficient_;
  }

  bool hasLine() const { return slope_ > 0; }
  /// The torque for x at the rate q̇, in any regime.
  double torqueOf(double x, double rate) const {
    if (!hasLine()) return x;
    const double side = signOf(x);
    return side * std::min(side * x, std::max(0.0, limitAt(side, rate)));
  }
  /// The torque in the present regime.
  double torque(double t, const double* omega) const {
    if (regime_ == Regime::free) return lagged(t);
    return regime_ == Regime::line ? side_ * limitAt(side_, q(omega)) : 0;
  }
  /// −∂τ/∂q̇ in the present regime.
  double damping() const { return regime_ == Regime::line ? slope_ : 0; }
  bool isFree() const { return regime_ == Regime::free; }
  /// ∂τ/∂x in the present regime, of x so many s before.
  double shareLeft(double since) const {
    return !isFree() || lag_ == 0 ? 0 : simd::exp(-std::min(since / lag_, lagsToTheEnd));
  }
  /// ∂τ/∂u in the present regime, so many s after u changed.
  double share(double acting) const { return isFree() ? 1 - shareLeft(acting) : 0; }

  /// Chooses the regime. At its edge, the line acts.
  void choose(double t, const double* omega) {
    isNew_ = false;
    if (!hasLine()) return;
    const double x = lagged(t);
    side_ = signOf(x);
    const double limit = limitAt(side_, q(omega));
    const bool isWithin = side_ * x < limit || (x == 0 && u_ == 0);
    regime_ = isWithin ? Regime::free : limit > 0 ? Regime::line : Regime::idle;
  }
  /// Two event functions, N m: one of them is above 0 if another regime is due.
  void events(double t, const double* omega, double* g) const;
  /// Their derivatives; a: q̈ of the joints.
  void slopes(double t, const double* omega, const double* a, double* slope) const;
  double noise(const double* omega) const {
    constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
    return rounding * (limit_ + slope_ * sumOfSizes(omega, q));
  }
  bool isDue(double t, const double* omega) const {
    double g[2];
    events(t, omega, g);
    return isNew_ || g[0] > 0 || g[1] > 0;
  }

 private:
  enum class Regime { free, line, idle };

  /// l
  double limitAt(double side, double rate) const { return limitAt(side, rate, limit_); }
  double limitAt(double side, double rate, double atRest) const { return atRest - side * slope_ * rate; }
  double signOf(double x) const { return x < 0 || (x == 0 && u_ < 0) ? -1 : 1; }
  /// Two functions of x and q̇, N m. A change is due where one is positive; from `free` only if s x is, too.
  double gap(int which, double x, double rate) const { return gap(which, x, rate, limit_); }
  /// That function for this limit at rest; for 0, with the derivatives of x and q̇, its derivative.
  double gap(int which, double x, double rate, double limitAtRest) const {
    if (regime_ == Regime::free) {
      const double side = which == 0 ? 1 : -1;
      return side * x - limitAt(side, rate, limitAtRest);
    }
    const double limit = limitAt(side_, rate, limitAtRest);
    if (regime_ == Regime::line) return which == 0 ? limit - side_ * x : -limit;
    return which == 0 ? limit : -side_ * x;
  }

  double limit_, slope_, lag_;  ///< L, N m; L/ω_0, N m s/rad, 0: no line; T, s, 0: no lag
  double u_ = 0, x0_ = 0, t0_ = 0;
  double coefficient_ = 0;  ///< of the last order
  Regime regime_ = Regime::free;
  double side_ = 1;     ///< s, unless it is free
  bool isNew_ = false;  ///< u has changed since choose()
};

inline void Motor::events(double t, const double* omega, double* g) const {
  const double x = lagged(t), rate = q(omega), noise = this->noise(omega);
  g[0] = gap(0, x, rate) - noise;
  g[1] = gap(1, x, rate) - noise;
  if (regime_ != Regime::free) return;
  g[0] = std::min(g[0], x - noise);
  g[1] = std::min(g[1], -x - noise);
}

inline void Motor::slopes(double t, const double* omega, const double* a, double* slope) const {
  const double x = lagged(t), rate = q(omega), xd = this->rate(t);
  slope[0] = gap(0, xd, q(a), 0);
  slope[1] = gap(1, xd, q(a), 0);
  if (regime_ != Regime::free) return;
  if (x < gap(0, x, rate)) slope[0] = xd;
  if (-x < gap(1, x, rate)) slope[1] = -xd;
}

}  // namespace planar_chain
