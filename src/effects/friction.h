#pragma once

/// Dry friction in joints, without smoothing.
///
///     slides    μ = −c sign(q̇)                  P_d = c |q̇|
///     sticks    q̈ = 0, |μ| ≤ breakaway torque   P_d = 0
///
/// A joint that sticks is held (recursion/coupled.h), so μ comes out, and its angle keeps every bit. The
/// integrator lands where q̇ of a sliding joint passes 0, and where μ of a stuck one passes its breakaway
/// torque.
///
/// Three parts: stick_slip.h is the state machine, complementarity.h decides which of several joints at rest
/// stick, and switch_instant.h finds the instant of a switch.
///
/// A joint that comes to rest with |q̈| = a goes on the other way at once if a > 2 c Y, where Y = ∂q̈/∂μ. Y is
/// known from the last time. So such a joint is not held first; if that was wrong, it sticks in the next
/// round.

#include <vector>

#include "effects/complementarity.h"
#include "effects/effect_kind.h"
#include "effects/stick_slip.h"
#include "effects/switch_instant.h"

namespace planar_chain {

class Friction : public Effect, public Coupler, public Switching, private RestingChain {
 public:
  /// tolerance: of rates, per second; 0 without error control.
  Friction(const Chain& chain, double tolerance);
  bool empty() const { return joints_.joints().empty(); }

  // Effect
  LoadKind mostActing() const override { return LoadKind::moments; }
  Powers apply(const ChainState& at, const Actions& to) override;
  bool hasConstantMoments() const override { return true; }
  void addTorques(const ChainState& at, double* tau) override;
  Powers powersAlong(const ChainState& at, const StateChange& along) override;
  void enter(double /*t*/) override { instant_.forget(); }
  Coupler* coupler() override { return this; }
  void couple(double t, int k, Couplings& to) const override;
  bool onlyHolds() const override { return true; }
  void attach(Mechanics& mechanics) override;
  Switching* switching() override { return this; }

  // Switching
  void enterState(double t, const double* y) override;
  void change(double t, double* y, const ode::Crossing& found) override;
  double due(double t, const Eigen::VectorXd& y) const override { return instant_.due(t, y.data()); }
  double nearest(const ode::Stretch& of) const override { return instant_.nearest(of); }
  bool mayHide() const override { return true; }
  std::optional<ode::Crossing> crossing(const ode::Stretch& of) const override {
    return instant_.crossing(of);
  }

 private:
  /// Call it when joints stick or slide otherwise.
  void take();
  /// True if the joint found, which comes to rest, is likely to go on the other way at once.
  bool mayPass(const ode::Crossing& found, int joint) const;
  /// Computes Y of the joint that has come to rest.
  void learn(const JointAnswer& answer);
  /// Decides for all joints at rest.
  void decide(double t, const double* y);
  void solve(std::vector<RestingJoint>& joints) override;  // RestingChain

  Coordinates coordinates_;
  int n_;
  StickSlip joints_;
  SwitchInstant instant_;
  Mechanics* mechanics_ = nullptr;
  Eigen::ArrayXd yield_;  ///< Y of each joint when it last came to rest, 1/(kg m²); 0: unknown

  // Of the present change:
  double t_ = 0;
  const double* y_ = nullptr;
  std::vector<RestingJoint> atRest_;
  struct Arrival {
    int joint = -1;
    double direction = 0, slope = 0;  ///< until then: the sign of q̇, and |q̈|
  } arrival_;
};

/// Keys `friction` and `breakaway` of a joint.
const EffectKind& frictionKind();

}  // namespace planar_chain
