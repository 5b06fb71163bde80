#pragma once

/// The effects that a scene has, as one: what acts now, summed over the list. Absence is emptiness: a scene
/// without effects has an empty list, and nothing is asked in the loop.

#include <memory>
#include <vector>

#include "effects/effect.h"
#include "effects/effect_kind.h"
#include "planar_chain/scene.h"

namespace planar_chain {

class Effects {
 public:
  /// Makes the effects of a scene, of all kinds or of those for which `has` is true. more: one that the scene
  /// does not say, or nullptr. The scene's chain outlives this object. Allocates.
  /// @throws std::invalid_argument when the scene names a body that the chain does not have
  explicit Effects(const Scene& scene, std::unique_ptr<Effect> more = nullptr,
                   bool (EffectKind::*has)() const = nullptr);
  /// Takes the order in which inLanes() compute. Allocates.
  void takeLaneOrder(const LaneOrder* lanes);

  bool empty() const { return all_.empty(); }
  const std::vector<std::unique_ptr<Effect>>& all() const { return all_; }
  LoadKind mostActing() const;
  /// True if one of them is, such as any(&Effect::hasPower).
  bool any(bool (Effect::*is)() const) const;
  /// True if effects couple accelerations, and all of those do it by holding joints.
  bool onlyHold() const;
  /// True if all have Taylor series.
  bool haveSeries() const;
  /// True if one of them has forces that are, such as anyForces(&Forces::dependOnMotion).
  bool anyForces(bool (Forces::*are)() const) const;

  // ---- What acts now: chosen by enter(), enterState() and fire() --------------------------------------

  /// See Effect. These allocate nothing.
  void enter(double t);
  void enterState(double t, const double* y);
  /// Chooses what acts as in a scene with other numbers. Returns false if that has other effects.
  bool takeFrom(const Effects& other);
  void fire(double t, double* y, const ode::LocatedEvent& located = {});
  void remember();
  void recall();
  void saveOrRestore(Snapshot& snapshot);

  bool act() const { return acting_ != LoadKind::nothing; }
  LoadKind acting() const { return acting_; }
  int reach() const { return reach_; }
  bool varyWithTime() const { return variesWithTime_; }
  /// True if all that act have constant moments and no forces.
  bool haveConstantMoments() const { return momentsAreConstant_; }
  double until() const { return least(&Effect::until); }
  double longestStep() const { return least(&Effect::longestStep); }

  /// All that act; those of them that need chain order, and those that work in lanes; those with forces.
  const std::vector<Effect*>& active() const { return active_; }
  const std::vector<Effect*>& activeInOrder() const { return activeInOrder_; }
  const std::vector<InLanes*>& activeInLanes() const { return activeInLanes_; }
  const std::vector<Forces*>& activeForces() const { return activeForces_; }

  // The effects together. Powers are summed here, for all recursions.
  Powers apply(const ChainState& at, const Actions& to) const { return apply(active_, at, to); }
  static Powers apply(const std::vector<Effect*>& effects, const ChainState& at, const Actions& to) {
    Powers sum;
    for (Effect* effect : effects) sum += effect->apply(at, to);
    return sum;
  }
  Powers applyRates(const ChainState& at, const Actions& to) const {
    Powers sum;
    for (Effect* effect : active_) {
      if (effect->variesWithTime()) sum += effect->applyRates(at, to);
    }
    return sum;
  }
  static Powers powersAlong(const std::vector<Effect*>& effects, const ChainState& at,
                            const StateChange& along) {
    Powers sum;
    for (Effect* effect : effects) sum += effect->powersAlong(at, along);
    return sum;
  }
  void addTorques(const ChainState& at, double* tau) const {
    for (Effect* effect : active_) effect->addTorques(at, tau);
  }

  // ---- Coupled joints and the base ----------------------------------------------------------------------

  const std::vector<JointConstraint*>& jointConstraints() const { return jointConstraints_; }
  /// The laws of the base, or nullptr if it stands still.
  const BaseLaws* base() const;
  /// True if the tip is held.
  bool holdTip() const;
  /// Order k of all that couples at t.
  void couple(double t, int k, Couplings& to) const;
  /// True if something couples otherwise at another time.
  bool coupleInTime() const { return !jointConstraintsInTime_.empty(); }
  /// Order 0 of that; the rest of `to` stays.
  void coupleInTime(double t, Couplings& to) const;

  // ---- Events -------------------------------------------------------------------------------------------

  const ode::EventList& events() const { return events_; }
  /// True if an effect that does not couple accelerations has some.
  bool haveUncoupledEvents() const { return haveUncoupledEvents_; }

 private:
  void listActive();
  double least(double (Effect::*of)() const) const;

  std::vector<std::unique_ptr<Effect>> all_;
  std::vector<Events*> withEvents_;
  ode::EventList events_;
  std::vector<Effect*> active_, activeInOrder_;
  std::vector<InLanes*> activeInLanes_;
  std::vector<Forces*> activeForces_;
  std::vector<JointConstraint*> jointConstraints_, jointConstraintsInTime_;
  LoadKind acting_ = LoadKind::nothing;
  int reach_ = 0;
  bool variesWithTime_ = false, momentsAreConstant_ = true, haveUncoupledEvents_ = false;
};

}  // namespace planar_chain
