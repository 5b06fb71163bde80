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
/// Which of several joints at rest stick, and which way the others start, follows from Gauss's principle: the
/// friction torques minimise ½ μᵀ M⁻¹ μ + μᵀ q̈_0 over |μ_i| ≤ c_i. At first all stick. Those with a larger
/// |μ| are released, those that would move against their friction stick again, until nothing changes. If that
/// takes too long, only the first joint changes each time.
///
/// A joint that comes to rest with |q̈| = a goes on the other way at once if a > 2 c Y, where Y = ∂q̈/∂μ. Y is
/// known from the last time. So such a joint is not held first; if that was wrong, it sticks in the next
/// round.
///
/// Source: P. Lötstedt, Mechanical systems of rigid bodies subject to unilateral constraints, SIAM J. Appl.
/// Math. 42 (1982) 281–296; K. G. Murty, Note on a Bard-type scheme for solving the complementarity problem,
/// Opsearch 11 (1974) 123–130.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "effects/effect_kind.h"

namespace planar_chain {

class Friction : public Effect, public Coupler, public Switching {
 public:
  explicit Friction(const Chain& chain);
  bool empty() const { return rubs_.empty(); }

  // Effect
  LoadKind mostActing() const override { return LoadKind::moments; }
  LoadKind acting() const override { return LoadKind::moments; }
  Powers apply(const ChainState& at, const Actions& to) override;
  bool hasConstantMoments() const override { return true; }
  void addTorques(const ChainState& at, double* tau) override;
  Powers powersAlong(const ChainState& at, const StateChange& along) override;
  Coupler* coupler() override { return this; }
  void couple(double t, int k, Couplings& to) const override;
  bool onlyHolds() const override { return true; }
  void attach(Mechanics& mechanics) override { mechanics_ = &mechanics; }
  Switching* switching() override { return this; }

  // Switching
  void enterState(double t, const double* y) override;
  void change(double t, double* y) override;
  double due(double t, const Eigen::VectorXd& y) const override;
  double nearest(const ode::Stretch& of) const override;
  bool mayHide() const override { return true; }
  std::optional<double> crossing(const ode::Stretch& of) const override;

 private:
  using Numbers = Eigen::ArrayXd;

  /// How much the change of each joint is due at t and y: of a sliding one by q̇, of a stuck one by μ. Far
  /// below 0 where there is no friction. Valid for the last few states.
  const Numbers& duesAt(double t, const double* y) const;
  /// The moments in the joints, likewise.
  const double* momentsAt(double t, const double* y) const;
  /// The same of sliding joints alone.
  void findSlidesDue(const double* omega, Numbers& due) const;
  double slideDue(int joint, const double* omega) const;
  double stickDue(int joint, const double* moments) const {
    return std::abs(moments[joint]) - breakaway_[joint] * (1 + slack);
  }
  /// The same of one joint at t within the stretch.
  double dueAt(int joint, double t, const ode::Stretch& of) const;
  /// The first time up to `last` at which it is due. It is due at `last`, but not where the stretch starts.
  std::optional<double> crossingOf(int joint, const ode::Stretch& of, double last) const;

  bool slides(int joint) const { return direction_[joint] != 0; }
  /// Call it when directions have changed.
  void takeDirections();
  /// True if a joint that comes to rest is likely to go on the other way at once.
  bool mayPass(int joint) const;
  /// Computes Y of the joint that has come to rest.
  void learn(const JointAnswer& answer);
  /// Decides for all joints at rest, and that stick at first.
  void decide(double t, const double* y);
  /// Lets joints break loose, and those stick that would move against their friction. Returns true if any
  /// did.
  bool correct(const JointAnswer& answer, bool oneByOne);

  static constexpr double slack = 1e-12;  ///< of a torque or an acceleration: less is rounding

  int n_;
  bool isBreakaway_ = false;  ///< a breakaway torque is larger than the sliding one
  std::vector<int> rubs_;     ///< the joints with friction,
  std::vector<int> stuck_;    ///< those of them that stick,
  std::vector<int> before_;   ///< those that did before the last change,
  std::vector<int> earlier_;  ///< and before that,
  std::vector<int> atRest_;   ///< and those at rest in the present decision
  // Of each joint:
  Numbers sliding_, breakaway_;  ///< torques, N m
  Numbers direction_;            ///< of q̇; 0: stuck, or no friction
  Numbers never_;                ///< 0 if it slides, else far below 0
  Numbers angle_;                ///< of a stuck joint, from body to body
  Numbers yield_;                ///< Y when it last came to rest, 1/(kg m²); 0: unknown

  Eigen::VectorXd moments_;  ///< on the bodies, N m
  Mechanics* mechanics_ = nullptr;
  /// The joint that comes to rest at the last crossing(), its direction until then, and |q̈|.
  struct Arrival {
    int joint = -1;
    double direction = 0, slope = 0;
  };
  mutable Arrival arrival_;
  mutable std::vector<int> due_;  ///< scratch of crossing()
  /// What is known of the last few states; the oldest are replaced first.
  struct Seen {
    double t;
    Numbers moments, dues;
    bool hasMoments, hasDues;
  };
  Seen& seen(double t) const;
  void forgetSeen();
  mutable std::array<Seen, 8> seen_;
  mutable std::size_t oldest_ = 0;
};

/// Keys `friction` and `breakaway` of a joint.
const EffectKind& frictionKind();

}  // namespace planar_chain
