#include "effects/effects.h"

#include <algorithm>

#include "effects/effect_kind.h"

namespace planar_chain {

Effects::Effects(const Scene& scene, std::unique_ptr<Effect> more, bool (EffectKind::*has)() const) {
  if (more) all_.push_back(std::move(more));
  for (const EffectKind* kind : effectKinds()) {
    if (has && !(kind->*has)()) continue;
    if (std::unique_ptr<Effect> effect = kind->make(scene)) all_.push_back(std::move(effect));
  }
  for (const auto& effect : all_) {
    JointConstraint* jointConstraint = effect->jointConstraint();
    if (jointConstraint) jointConstraints_.push_back(jointConstraint);
    Events* events = effect->events();
    if (!events) continue;
    withEvents_.push_back(events);
    events->addEvents(events_);
    haveUncoupledEvents_ = haveUncoupledEvents_ || !jointConstraint;
  }
  for (const auto& effect : all_) {
    if (effect->forces()) effect->forces()->takeBase(base());
  }
  for (auto* effects : {&active_, &activeInOrder_}) effects->reserve(all_.size());
  activeInLanes_.reserve(all_.size());
  activeForces_.reserve(all_.size());
  jointConstraintsInTime_.reserve(all_.size());
  takeLaneOrder(nullptr);
  enter(0);
}

void Effects::takeLaneOrder(const LaneOrder* lanes) {
  for (const auto& effect : all_) {
    if (effect->inLanes()) effect->inLanes()->takeLaneOrder(lanes);
  }
}

LoadKind Effects::mostActing() const {
  LoadKind most = LoadKind::nothing;
  for (const auto& effect : all_) most = std::max(most, effect->mostActing());
  return most;
}

bool Effects::any(bool (Effect::*is)() const) const {
  return std::any_of(all_.begin(), all_.end(), [is](const auto& effect) { return (*effect.*is)(); });
}

bool Effects::onlyHold() const {
  const auto onlyHolds = [](const JointConstraint* jointConstraint) { return jointConstraint->onlyHolds(); };
  return !jointConstraints_.empty() &&
         std::all_of(jointConstraints_.begin(), jointConstraints_.end(), onlyHolds);
}

bool Effects::haveSeries() const {
  return std::all_of(all_.begin(), all_.end(), [](const auto& effect) { return effect->hasSeries(); });
}

bool Effects::anyForces(bool (Forces::*are)() const) const {
  return std::any_of(all_.begin(), all_.end(), [are](const auto& effect) {
    const Forces* forces = effect->forces();
    return forces && (forces->*are)();
  });
}

double Effects::least(double (Effect::*of)() const) const {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& effect : all_) least = std::min(least, (*effect.*of)());
  return least;
}

// ---- What acts now ---------------------------------------------------------------------------------

void Effects::enter(double t) {
  for (const auto& effect : all_) effect->enter(t);
  listActive();
}

void Effects::enterState(double t, const double* y) {
  for (Events* events : withEvents_) {
    events->enterState(t, y);
    listActive();  // friction, the last, asks what the others do
  }
}

void Effects::fire(double t, double* y, const ode::LocatedEvent& located) {
  for (Events* events : withEvents_) {
    events->fire(t, y, located);
    listActive();
  }
}

bool Effects::takeFrom(const Effects& other) {
  if (withEvents_.size() != other.withEvents_.size()) return false;
  for (std::size_t k = 0; k < withEvents_.size(); ++k) withEvents_[k]->takeFrom(*other.withEvents_[k]);
  listActive();
  return true;
}

void Effects::remember() {
  for (const auto& effect : all_) effect->remember();
}

void Effects::recall() {
  for (const auto& effect : all_) effect->recall();
}

void Effects::saveOrRestore(Snapshot& snapshot) {
  for (const auto& effect : all_) effect->saveOrRestore(snapshot);
  listActive();
}

void Effects::listActive() {
  active_.clear();
  activeInOrder_.clear();
  activeInLanes_.clear();
  activeForces_.clear();
  jointConstraintsInTime_.clear();
  acting_ = LoadKind::nothing;
  reach_ = 0;
  variesWithTime_ = false;
  momentsAreConstant_ = true;
  for (const auto& effect : all_) {
    if (effect->variesWithTime()) {
      variesWithTime_ = true;
      if (effect->jointConstraint()) jointConstraintsInTime_.push_back(effect->jointConstraint());
    }
    if (effect->acting() == LoadKind::nothing) continue;
    active_.push_back(effect.get());
    momentsAreConstant_ = momentsAreConstant_ && effect->hasConstantMoments();
    if (effect->inLanes()) {
      activeInLanes_.push_back(effect->inLanes());
    } else {
      activeInOrder_.push_back(effect.get());
    }
    acting_ = std::max(acting_, effect->acting());
    if (Forces* forces = effect->forces()) {
      activeForces_.push_back(forces);
      reach_ = std::max(reach_, forces->reach());
    }
  }
}

// ---- Coupled joints and the base -------------------------------------------------------------------

const BaseLaws* Effects::base() const {
  for (const JointConstraint* jointConstraint : jointConstraints_) {
    if (jointConstraint->base()) return jointConstraint->base();
  }
  return nullptr;
}

bool Effects::holdTip() const {
  return std::any_of(jointConstraints_.begin(), jointConstraints_.end(),
                     [](const JointConstraint* jointConstraint) { return jointConstraint->holdsTip(); });
}

void Effects::couple(double t, int k, Couplings& to) const {
  std::fill(to.joints.begin(), to.joints.end(), JointLaw<double>{});
  for (const JointConstraint* jointConstraint : jointConstraints_) jointConstraint->couple(t, k, to);
}

void Effects::coupleInTime(double t, Couplings& to) const {
  for (const JointConstraint* jointConstraint : jointConstraintsInTime_) jointConstraint->couple(t, 0, to);
}

}  // namespace planar_chain
