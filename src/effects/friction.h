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
/// Source: P. Lötstedt, Mechanical systems of rigid bodies subject to unilateral constraints, SIAM J. Appl.
/// Math. 42 (1982) 281–296; K. G. Murty, Note on a Bard-type scheme for solving the complementarity problem,
/// Opsearch 11 (1974) 123–130.

#include <array>
#include <optional>
#include <vector>

#include "effects/effect_kind.h"

namespace planar_chain {

class Friction : public Effect, public Switching {
 public:
  explicit Friction(const Chain& chain);
  bool empty() const { return rubs_.empty(); }

  // Effect
  LoadKind mostActing() const override { return LoadKind::moments; }
  LoadKind acting() const override { return LoadKind::moments; }
  Powers apply(const ChainState& at, const Actions& to) override;
  void addTorques(const ChainState& at, double* tau) override;
  Powers powersAlong(const ChainState& at, const StateChange& along) override;
  bool couples() const override { return true; }
  void couple(double t, int k, Couplings& to) const override;
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
  struct Rub {
    int joint;
    double sliding, breakaway;  ///< torques, N m
    int direction = 0;          ///< of q̇; 0: stuck
    bool mayStick = false;      ///< at rest in the present decision
    double angle = 0;           ///< of a stuck joint, from body to body

    /// How much the change is due: of a sliding joint by q̇, of a stuck one by μ.
    double slideDue(const double* omega) const;
    double stickDue(double mu) const;
    double due(const double* omega, const double* moments) const {
      return direction != 0 ? slideDue(omega) : stickDue(moments[joint]);
    }
  };

  /// The moments in the joints at t and y.
  const double* momentsAt(double t, const double* y) const;
  /// How much the change of a joint is due at t within the stretch.
  double dueAt(const Rub& rub, double t, const ode::Stretch& of) const;
  /// The first time up to `last` at which it is due. It is due at `last`, but not where the stretch starts.
  std::optional<double> crossingOf(const Rub& rub, const ode::Stretch& of, double last) const;
  void takeMoments();

  /// Decides for all joints that may stick, and that stick at first.
  void decide(double t, const double* y);
  bool anySticks() const;

  int n_;
  bool isBreakaway_ = false;  ///< a breakaway torque is larger than the sliding one
  std::vector<Rub> rubs_;
  Eigen::VectorXd moments_;  ///< on the bodies, N m
  Mechanics* mechanics_ = nullptr;
  mutable std::vector<double> dueAtEnd_;  ///< of each rub: crossing()'s scratch
  /// Moments of the last few states; the oldest are replaced first.
  struct Seen {
    double t;
    Eigen::VectorXd moments;
  };
  mutable std::array<Seen, 8> seen_;
  mutable std::size_t oldest_ = 0;
};

/// Keys `friction` and `breakaway` of a joint.
const EffectKind& frictionKind();

}  // namespace planar_chain
