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

  /// True if there is none.
  bool empty() const { return all_.empty(); }
  LoadKind mostActing() const;
  /// True if one ever supplies or takes power.
  bool havePower() const;

  // ---- What acts now: chosen by enter(), enterState() and change() --------------------------------------

  /// See Effect. These allocate nothing.
  void enter(double t);
  void enterState(const double* y);
  void change(const double* y);

  bool act() const { return acting_ != LoadKind::nothing; }
  LoadKind acting() const { return acting_; }
  int reach() const { return reach_; }
  bool varyWithTime() const { return variesWithTime_; }
  double until() const;
  double longestStep() const;

  /// All that act; those of them that need chain order; those that work in lane order.
  const std::vector<Effect*>& active() const { return active_; }
  const std::vector<Effect*>& activeInOrder() const { return activeInOrder_; }
  const std::vector<Effect*>& activeInLanes() const { return activeInLanes_; }

  // ---- Derivatives --------------------------------------------------------------------------------------

  /// True if k or d of a joint depends on the state.
  bool areNonlinear() const;
  /// See Effect, summed; the first sets k and d.
  void findStiffness(double* k, double* d) const;
  void addTangents(const ChainState& at, double* k, double* d) const;
  void addForceStiffness(const ChainState& at, double* XF);
  Powers powersAlong(const ChainState& at, const StateChange& along);
  Powers powersAlongInLanes(const double* omega, const double* v) {
    Powers change;
    for (Effect* effect : activeInLanes_) change += effect->powersAlongInLanes(omega, v);
    return change;
  }
  /// True if powersAlong(), or powersAlongInLanes(), is ever not zero.
  bool havePowerInOrder() const;
  bool havePowerInLanes() const;
  Powers applyRates(const ChainState& at, const Actions& to);

  void reserveSeries(int orders);
  void addOrder(int k, const Series& known, const Actions& to);
  void addTorques(const ChainState& at, double* tau);

  // ---- ode::Switches ------------------------------------------------------------------------------------

  bool haveSwitches() const { return !switching_.empty(); }
  double due(const Eigen::VectorXd& y) const override;
  double nearest(const Eigen::VectorXd& y, const Eigen::VectorXd& next, double h) const override;

 private:
  void listActive();

  std::vector<std::unique_ptr<Effect>> all_;
  std::vector<Switching*> switching_;
  std::vector<Effect*> active_, activeInOrder_, activeInLanes_;
  LoadKind acting_ = LoadKind::nothing;
  int reach_ = 0;
  bool variesWithTime_ = false;
};

}  // namespace planar_chain
