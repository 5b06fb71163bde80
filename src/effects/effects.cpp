#include "effects/effects.h"

#include <algorithm>

#include "effects/effect_kind.h"

namespace planar_chain {

Effects::Effects(const Scene& scene, std::unique_ptr<Effect> more, bool (EffectKind::*has)() const) {
  if (more) all_.push_back(std::move(more));
  const std::vector<const EffectKind*>& kinds = effectKinds();
  for (auto kind = kinds.rbegin(); kind != kinds.rend(); ++kind) {
    if (has && !(**kind.*has)()) continue;
    if (std::unique_ptr<Effect> effect = (*kind)->make(scene)) all_.push_back(std::move(effect));
  }
  for (const auto& effect : all_) {
    Coupler* coupler = effect->coupler();
    if (coupler) couplers_.push_back(coupler);
    Switching* switching = effect->switching();
    if (!switching) continue;
    switching_.push_back(switching);
    haveUncoupledSwitches_ = haveUncoupledSwitches_ || !coupler;
  }
  for (auto* effects : {&active_, &activeInOrder_}) effects->reserve(all_.size());
  activeInLanes_.reserve(all_.size());
  activeForces_.reserve(all_.size());
  couplersInTime_.reserve(all_.size());
  arrange(nullptr);
  enter(0);
}

void Effects::arrange(const Arrangement* lanes) {
  for (const auto& effect : all_) {
    if (effect->inLanes()) effect->inLanes()->arrange(lanes);
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
  for (Switching* switching : switching_) {
    switching->enterState(t, y);
    listActive();  // friction, the last, asks what the others do
  }
}

void Effects::change(double t, double* y, const ode::Crossing& found) {
  for (Switching* switching : switching_) {
    switching->change(t, y, found.by == switching ? found : ode::Crossing{});
    listActive();
  }
}

bool Effects::takeSwitches(const Effects& of) {
  if (switching_.size() != of.switching_.size()) return false;
  for (std::size_t k = 0; k < switching_.size(); ++k) switching_[k]->takeFrom(*of.switching_[k]);
  listActive();
  return true;
}

void Effects::remember() {
  for (const auto& effect : all_) effect->remember();
}

void Effects::recall() {
  for (const auto& effect : all_) effect->recall();
}

void Effects::listActive() {
  active_.clear();
  activeInOrder_.clear();
  activeInLanes_.clear();
  activeForces_.clear();
  couplersInTime_.clear();
  acting_ = LoadKind::nothing;
  reach_ = 0;
  variesWithTime_ = false;
  momentsAreConstant_ = true;
  for (const auto& effect : all_) {
    if (effect->variesWithTime()) {
      variesWithTime_ = true;
      if (effect->coupler()) couplersInTime_.push_back(effect->coupler());
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
  for (const Coupler* coupler : couplers_) {
    if (coupler->base()) return coupler->base();
  }
  return nullptr;
}

bool Effects::holdTip() const {
  return std::any_of(couplers_.begin(), couplers_.end(),
                     [](const Coupler* coupler) { return coupler->holdsTip(); });
}

void Effects::couple(double t, int k, Couplings& to) const {
  std::fill(to.joints.begin(), to.joints.end(), JointLaw<double>{});
  for (const Coupler* coupler : couplers_) coupler->couple(t, k, to);
}

void Effects::coupleInTime(double t, Couplings& to) const {
  for (const Coupler* coupler : couplersInTime_) coupler->couple(t, 0, to);
}

// ---- Switches --------------------------------------------------------------------------------------

double Effects::due(double t, const Eigen::VectorXd& y) const {
  double most = -std::numeric_limits<double>::infinity();
  for (const Switching* switching : switching_) most = std::max(most, switching->due(t, y));
  return most;
}

namespace {

/// The least of them that is above 0; −1: there is none.
template <class Parts, class TimeOf>
double firstOf(const Parts& parts, const TimeOf& timeOf) {
  double first = -1;
  for (const auto* part : parts) {
    const double own = timeOf(*part);
    if (own > 0 && (first < 0 || own < first)) first = own;
  }
  return first;
}

}  // namespace

double Effects::nearest(const ode::Stretch& of) const {
  return firstOf(switching_, [&](const Switching& part) { return part.nearest(of); });
}

double Effects::hidden(const ode::Stretch& step) const {
  return firstOf(switching_, [&](const Switching& part) { return part.hidden(step); });
}

bool Effects::mayHide(const ode::Stretch& of, bool isLong) const {
  return std::any_of(switching_.begin(), switching_.end(),
                     [&](const Switching* switching) { return switching->mayHide(of, isLong); });
}

std::optional<ode::Crossing> Effects::crossing(const ode::Stretch& of) const {
  std::optional<ode::Crossing> first;
  for (const Switching* switching : switching_) {
    if (switching->due(of.t + of.h, of.next) <= 0) continue;
    std::optional<ode::Crossing> own = switching->crossing(of);
    if (!own) return {};
    own->by = switching;
    if (!first || own->t < first->t) first = own;
  }
  return first;
}

}  // namespace planar_chain
