#include "effects/effects.h"

#include <algorithm>

#include "effects/effect_kind.h"

namespace planar_chain {

Effects::Effects(const Scene& scene, const Arrangement* lanes, std::unique_ptr<Effect> more) {
  if (more) all_.push_back(std::move(more));
  const std::vector<const EffectKind*>& kinds = effectKinds();
  for (auto kind = kinds.rbegin(); kind != kinds.rend(); ++kind) {
    if (std::unique_ptr<Effect> effect = (*kind)->make(scene, lanes)) all_.push_back(std::move(effect));
  }
  for (const auto& effect : all_) {
    if (Switching* switching = effect->switching()) switching_.push_back(switching);
  }
  active_.reserve(all_.size());
  activeInOrder_.reserve(all_.size());
  activeInLanes_.reserve(all_.size());
  enter(0);
}

LoadKind Effects::mostActing() const {
  LoadKind most = LoadKind::nothing;
  for (const auto& effect : all_) most = std::max(most, effect->mostActing());
  return most;
}

bool Effects::havePower() const {
  return std::any_of(all_.begin(), all_.end(), [](const auto& effect) { return effect->hasPower(); });
}

// ---- What acts now ---------------------------------------------------------------------------------

void Effects::enter(double t) {
  for (const auto& effect : all_) effect->enter(t);
  listActive();
}

void Effects::enterState(const double* y) {
  for (Switching* switching : switching_) switching->enterState(y);
  listActive();
}

void Effects::change(const double* y) {
  for (Switching* switching : switching_) switching->change(y);
  listActive();
}

void Effects::listActive() {
  active_.clear();
  activeInOrder_.clear();
  activeInLanes_.clear();
  acting_ = LoadKind::nothing;
  reach_ = 0;
  variesWithTime_ = false;
  for (const auto& effect : all_) {
    if (effect->acting() == LoadKind::nothing) continue;
    active_.push_back(effect.get());
    (effect->worksInLanes() ? activeInLanes_ : activeInOrder_).push_back(effect.get());
    acting_ = std::max(acting_, effect->acting());
    reach_ = std::max(reach_, effect->reach());
    variesWithTime_ = variesWithTime_ || effect->variesWithTime();
  }
}

double Effects::until() const {
  double until = std::numeric_limits<double>::infinity();
  for (const auto& effect : all_) until = std::min(until, effect->until());
  return until;
}

double Effects::longestStep() const {
  double longest = std::numeric_limits<double>::infinity();
  for (const auto& effect : all_) longest = std::min(longest, effect->longestStep());
  return longest;
}

// ---- Derivatives -----------------------------------------------------------------------------------

bool Effects::areNonlinear() const {
  return std::any_of(all_.begin(), all_.end(), [](const auto& effect) { return effect->isNonlinear(); });
}

void Effects::findStiffness(double* k, double* d) const {
  for (const auto& effect : all_) effect->addStiffness(k, d);
}

void Effects::addTangents(const ChainState& at, double* k, double* d) const {
  for (const Effect* effect : active_) effect->addTangents(at, k, d);
}

void Effects::addForceStiffness(const ChainState& at, double* XF) {
  for (Effect* effect : active_) effect->addForceStiffness(at, XF);
}

Powers Effects::powersAlong(const ChainState& at, const StateChange& along) {
  Powers change;
  for (Effect* effect : activeInOrder_) change += effect->powersAlong(at, along);
  return change;
}

bool Effects::havePowerInOrder() const {
  return std::any_of(all_.begin(), all_.end(),
                     [](const auto& effect) { return effect->hasPower() && !effect->worksInLanes(); });
}

bool Effects::havePowerInLanes() const {
  return std::any_of(all_.begin(), all_.end(),
                     [](const auto& effect) { return effect->hasPower() && effect->worksInLanes(); });
}

Powers Effects::applyRates(const ChainState& at, const Actions& to) {
  Powers rates;
  for (Effect* effect : active_) rates += effect->applyRates(at, to);
  return rates;
}

void Effects::reserveSeries(int orders) {
  for (const auto& effect : all_) effect->reserveSeries(orders);
}

void Effects::addOrder(int k, const Series& known, const Actions& to) {
  for (Effect* effect : active_) effect->addOrder(k, known, to);
}

void Effects::addTorques(const ChainState& at, double* tau) {
  for (Effect* effect : active_) effect->addTorques(at, tau);
}

// ---- Switches --------------------------------------------------------------------------------------

double Effects::due(const Eigen::VectorXd& y) const {
  double most = -std::numeric_limits<double>::infinity();
  for (const Switching* switching : switching_) most = std::max(most, switching->due(y));
  return most;
}

double Effects::nearest(const Eigen::VectorXd& y, const Eigen::VectorXd& next, double h) const {
  double first = -1;
  for (const Switching* switching : switching_) {
    const double own = switching->nearest(y, next, h);
    if (own > 0 && (first < 0 || own < first)) first = own;
  }
  return first;
}

}  // namespace planar_chain
