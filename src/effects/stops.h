#pragma once

/// Joint limits: one-sided spring-dampers, which push and never pull.
///
/// With x = q − upper at the upper limit and x = lower − q at the lower one (how deep the joint is in the
/// stop, if positive) and s = k x + d ẋ, a stop is
///
///     free       x < 0            no torque        V = 0          P_d = 0
///     pushing    x > 0, s > 0     s against x      V = ½ k x²     P_d = d ẋ²
///     parted     x > 0, s < 0     no torque        V = ½ k x²     P_d = −k x ẋ
///
/// Parted, the joint leaves faster than the stop follows, which relaxes into its own damper; so V depends on
/// the angle alone, P_d ≥ 0, and the energy balance closes. At each change of place the torque has a corner,
/// and a jump where a damped stop is hit; the integrator lands there (ode/switches.h), so that each step sees
/// one smooth f.

#include <vector>

#include "ode/switches.h"
#include "planar_chain/chain.h"

namespace planar_chain {

class Stops : public ode::Switches {
 public:
  explicit Stops(const Chain& chain);

  bool empty() const { return stops_.empty(); }
  bool dissipate() const;
  /// Whether one does something now.
  bool act() const { return !active_.empty(); }

  /// Every stop to the place that the state (y = [θ ω …]) says, whatever it was before.
  void enter(const double* y);
  /// Every stop whose change is due to its next place. Allocates nothing.
  void change(const double* y);

  // ode::Switches
  double due(const Eigen::VectorXd& y) const override;
  double nearest(const Eigen::VectorXd& y, const Eigen::VectorXd& next, double h) const override;

  /// Calls add(joint, torque) for each that pushes, + on the joint's own link; returns P_d, W.
  template <class Add>
  double apply(const double* theta, const double* omega, Add&& add) const {
    double dissipated = 0;
    for (const Stop* stop : active_) {
      const double x = stop->depth(theta);
      const double xd = stop->speed(omega);
      if (stop->place == Place::pushing) {
        add(stop->joint, -stop->sign * (stop->k * x + stop->d * xd));
        dissipated += stop->d * xd * xd;
      } else {
        dissipated -= stop->k * x * xd;
      }
    }
    return dissipated;
  }
  /// Adds what pushing stops do as springs and dampers, to k and d of each joint.
  void addStiffness(double* k, double* d) const;
  /// The derivative of P_d along (u, v), changes of the angles and rates.
  double dissipationAlong(const double* theta, const double* omega, const double* u, const double* v) const;

 private:
  enum class Place { free, pushing, parted };
  struct Stop {
    int joint;
    double limit;
    double sign;  ///< + upper, − lower
    double k, d;
    Place place = Place::free;

    double depth(const double* theta) const { return sign * (relative(theta, joint) - limit); }
    double speed(const double* omega) const { return sign * relative(omega, joint); }
    /// How far the change to another place is due; ≤ 0: it is not. All in rad.
    double due(double x, double xd) const;
    Place next(double x, double xd) const;
  };

  /// Those that do something now.
  void listActive();

  int n_;
  std::vector<Stop> stops_;
  std::vector<const Stop*> active_;
};

}  // namespace planar_chain
