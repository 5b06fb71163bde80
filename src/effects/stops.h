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

#include "effects/effect_kind.h"
#include "planar_chain/chain.h"

namespace planar_chain {

class Stops : public Effect, public Switching {
 public:
  explicit Stops(const Chain& chain);

  bool empty() const { return stops_.empty(); }

  // Effect
  LoadKind mostActing() const override { return LoadKind::moments; }
  LoadKind acting() const override { return active_.empty() ? LoadKind::nothing : LoadKind::moments; }
  bool hasPower() const override;
  Powers apply(const ChainState& at, const Actions& to) override;
  void addTorques(const ChainState& at, double* tau) override;
  void addStiffness(double* k, double* d) const override;
  Powers powersAlong(const ChainState& at, const StateChange& along) override;
  Switching* switching() override { return this; }

  // Switching
  void enterState(double t, const double* y) override;
  void change(double t, double* y, const ode::Crossing& found) override;
  double due(double t, const Eigen::VectorXd& y) const override;
  double nearest(const ode::Stretch& of) const override;

 private:
  enum class Place { free, pushing, parted };
  struct Stop {
    Coordinate q;  ///< of the joint
    double limit;
    double sign;  ///< + upper, − lower
    double k, d;
    Place place = Place::free;

    double depth(const double* theta) const { return sign * (q(theta) - limit); }
    double speed(const double* omega) const { return sign * q(omega); }
    /// Bounds the rounding error of depth(), rad.
    double rounding(const double* theta) const;
    /// How far the change to another place is due, rad; ≤ 0: it is not. A push must be wrong by more than
    /// rounding: in an overdamped stop k x and d ẋ cancel, and s is below the rounding of either.
    double due(const double* theta, const double* omega) const;
    Place next(double x, double xd) const;
  };

  /// Those that do something now.
  void listActive();
  /// Calls add(joint, torque) for each that pushes, + on the joint's own link. Returns P_d, W.
  template <class Add>
  double addUp(const double* theta, const double* omega, Add&& add) const;

  Coordinates coordinates_;
  int n_;
  std::vector<Stop> stops_;
  std::vector<const Stop*> active_;
};

/// Keys `lower`, `upper`, `stop_stiffness` and `stop_damping` of a joint.
const EffectKind& stopKind();

}  // namespace planar_chain
