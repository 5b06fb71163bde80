#include "dynamics/near_scenes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dynamics/closed_state.h"
#include "dynamics/effect_tangents.h"
#include "lanes/column_series.h"

namespace planar_chain {

// ---- An event ----------------------------------------------------------------------------------------

EventPlace::EventPlace(const Effects& effects, const ode::LocatedEvent& located, double t, const double* y) {
  const ode::EventList& events = effects.events();
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < events.size(); ++k) {
    if (located.by && located.by != events[k]) continue;
    std::vector<double> g(index(events[k]->most()));
    events[k]->values(t, y, g.data());
    for (int i = 0; i < events[k]->count(); ++i) {
      const bool isIt = located.by ? i == located.which : g[index(i)] > most;
      if (!isIt) continue;
      list = k;
      which = i;
      most = g[index(i)];
    }
  }
}

double EventPlace::valueIn(const Effects& effects, double t, const double* y) const {
  const ode::EventFunctions& events = *effects.events()[list];
  std::vector<double> g(index(events.most()));
  events.values(t, y, g.data());
  return g[index(which)];
}

// ---- A number of the scene ---------------------------------------------------------------------------

namespace {

bool isSame(const GivenMotion& a, const GivenMotion& b) {
  return a.value == b.value && a.rate == b.rate && a.acceleration == b.acceleration;
}

}  // namespace

NearScenes::One::Rates::Rates(const Scene& scene, Effects& effects)
    : mechanism(scene, true), motion(mechanism, effects), at(mechanism, effects) {}

NearScenes::One::One(const Scene& near, double weight_) : scene(near), weight(weight_), effects(scene) {
  if (!effects.jointConstraints().empty()) ratesMade();
}

NearScenes::One::Rates& NearScenes::One::ratesMade() {
  if (!rates) rates = std::make_unique<Rates>(scene, effects);
  return *rates;
}

NearScenes::NearScenes(const VariedNumber& number) {
  for (std::size_t k = 0; k < number.scenes.size(); ++k)
    all_.push_back(std::make_unique<One>(number.scenes[k], number.weights[k]));
}

bool NearScenes::enter(double t, const Effects& effects) {
  return std::all_of(all_.begin(), all_.end(), [&](const std::unique_ptr<One>& one) {
    one->effects.enter(t);
    if (one->rates) one->rates->motion.forget();
    return one->effects.takeFrom(effects) && one->effects.until() == effects.until();
  });
}

void NearScenes::slopes(double t, const double* y, double* to) {
  std::fill_n(to, all_.front()->scene.chain.size(), 0.0);
  for (const auto& one : all_) {
    One::Rates& rates = one->ratesMade();
    rates.motion.evaluator().evaluate(t, y, rates.at);
    for (int i = 0; i < rates.mechanism.size(); ++i) to[i] += one->weight * rates.at.slopes()[i];
  }
}

Eigen::VectorXd NearScenes::changeOfChain() const {
  Eigen::VectorXd sum = 0 * ColumnSeries::termsOf(all_.front()->scene.chain);
  for (const auto& one : all_) sum += one->weight * ColumnSeries::termsOf(one->scene.chain);
  return sum;
}

bool NearScenes::changeOfJoints(double t, const double* y, const Effects& effects,
                                Eigen::Matrix4Xd& to) const {
  const int n = all_.front()->scene.chain.size();
  Couplings own(n), near(n);
  to.setZero(4, n);
  for (const auto& one : all_) {
    const auto varies = [](Effect* effect) { return !effect->jointConstraint() && effect->variesWithTime(); };
    const std::vector<Effect*>& active = one->effects.active();
    if (std::any_of(active.begin(), active.end(), varies)) return false;
    for (const int order : {1, 0}) {  // a piece of a law follows from these
      effects.couple(t, order, own);
      one->effects.couple(t, order, near);
      for (std::size_t i = 0; i < index(n); ++i) {
        if (near.joints[i].isPrescribed && !isSame(near.prescribed[i], own.prescribed[i])) return false;
      }
    }
    to += one->weight * jointTerms(one->effects, near, one->scene.chain.coordinates(), t, y);
  }
  return true;
}

double NearScenes::eventSlope(const EventPlace& event, double t, const double* y) const {
  double sum = 0;
  for (const auto& one : all_) sum += one->weight * event.valueIn(one->effects, t, y);
  return sum;
}

Eigen::VectorXd NearScenes::start() const {
  const auto n = static_cast<Eigen::Index>(all_.front()->scene.q.size());
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(2 * n), x(2 * n);
  for (const auto& one : all_) {
    std::vector<double> q = one->scene.q, qd = one->scene.qd;
    closeState(one->scene, 0, q, qd);
    one->scene.chain.coordinates().toAbsolute(q.data(), x.data());
    one->scene.chain.coordinates().toAbsolute(qd.data(), x.data() + n);
    sum += one->weight * x;
  }
  return sum;
}

// ---- The joints --------------------------------------------------------------------------------------

Eigen::Matrix4Xd jointTerms(const Effects& effects, const Couplings& couplings,
                            const Coordinates& coordinates, double t, const double* y) {
  const int n = coordinates.size();
  EffectTangents tangents(n, effects);
  tangents.takeConstant(effects);
  std::vector<double> torques(index(n));
  effects.addTorques({t, y, y + n}, torques.data());
  Eigen::Matrix4Xd terms(4, n);
  for (int i = 0; i < n; ++i) {
    const double d = tangents.constantD[index(i)], k = tangents.constantK[index(i)];
    terms.col(i) << couplings.joints[index(i)].armature, d, k,
        torques[index(i)] + k * coordinates.relative(y, i) + d * coordinates.relative(y + n, i);
  }
  return terms;
}

}  // namespace planar_chain
