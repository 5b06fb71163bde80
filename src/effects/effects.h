#pragma once

/// The effects that a scene has, as one: what acts now, summed over the list. Absence is emptiness: a scene
/// without effects has an empty list, and nothing is asked in the loop.

#include <memory>
#include <vector>

#include "effects/effect.h"
#include "lanes/arrangement.h"
#include "planar_chain/scene.h"

namespace planar_chain {

class Effects : public ode::Switches {
 public:
  /// Makes the effects of a scene. more: one that the scene does not say, or nullptr. The scene's chain and
  /// `lanes` outlive this object.
  /// @throws std::invalid_argument when the scene names a body that the chain does not have
  Effects(const Scene& scene, const Arrangement* lanes, std::unique_ptr<Effect> more = nullptr);

  bool empty() const { return all_.empty(); }
  const std::vector<std::unique_ptr<Effect>>& all() const { return all_; }
  LoadKind mostActing() const;
  /// True if one of them is, such as any(&Effect::hasPower).
  bool any(bool (Effect::*is)() const) const;

  // ---- What acts now: chosen by enter(), enterState() and change() --------------------------------------

  /// See Effect. These allocate nothing.
  void enter(double t);
  void enterState(double t, const double* y);
  void change(double t, double* y, const ode::Crossing& found = {});

  bool act() const { return acting_ != LoadKind::nothing; }
  LoadKind acting() const { return acting_; }
  int reach() const { return reach_; }
  bool varyWithTime() const { return variesWithTime_; }
  /// True if all that act have constant moments and no forces.
  bool haveConstantMoments() const { return momentsAreConstant_; }
  double until() const { return least(&Effect::until); }
  double longestStep() const { return least(&Effect::longestStep); }

  /// All that act; those of them that need chain order; those that work in lane order.
  const std::vector<Effect*>& active() const { return active_; }
  const std::vector<Effect*>& activeInOrder() const { return activeInOrder_; }
  const std::vector<Effect*>& activeInLanes() const { return activeInLanes_; }

  // ---- ode::Switches ------------------------------------------------------------------------------------

  bool haveSwitches() const { return !switching_.empty(); }
  /// True if an effect that does not couple accelerations has some.
  bool haveUncoupledSwitches() const { return haveUncoupledSwitches_; }
  double due(double t, const Eigen::VectorXd& y) const override;
  double nearest(const ode::Stretch& of) const override;
  bool mayHide() const override;
  std::optional<ode::Crossing> crossing(const ode::Stretch& of) const override;

 private:
  void listActive();
  double least(double (Effect::*of)() const) const;

  std::vector<std::unique_ptr<Effect>> all_;
  std::vector<Switching*> switching_;
  std::vector<Effect*> active_, activeInOrder_, activeInLanes_;
  LoadKind acting_ = LoadKind::nothing;
  int reach_ = 0;
  bool variesWithTime_ = false, momentsAreConstant_ = true, haveUncoupledSwitches_ = false;
};

}  // namespace planar_chain
