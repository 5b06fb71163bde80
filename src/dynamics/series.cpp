/// The Taylor series of the motion: of dynamics.h.

#include <algorithm>

#include "dynamics/dynamics.h"

namespace planar_chain {

/// Beside a held tip nothing else that couples has a series.
bool Dynamics::hasSeries() const {
  const bool isMixed = mechanism_.coordinates().anyIsPrismatic();
  const bool couples = effects_.jointConstraints().size() > 1;
  return effects_.haveSeries() && !(holdsTip() && (isMixed || couples));
}

double Dynamics::seriesCost(int order) const {
  constexpr double ofGeneralOrder = 1.6;  // by clock, 2 to 20 links: 1 to 2
  return series_ ? series_->cost(order) : ofGeneralOrder * order;
}

void Dynamics::reserveSeries(int order) {
  const int reserved = series_ ? series_->orders() : generalSeries_ ? generalSeries_->orders() : 0;
  if (reserved >= order) return;
  const bool couples = !effects_.jointConstraints().empty() || effects_.anyForces(&Forces::dependOnMotion);
  if (holdsTip() || (MotionSeries::areFor(mechanism_.chain()) && !couples)) {
    const Chain& chain = mechanism_.chain();
    series_.emplace(chain, order, MotionSeries::kernelFor(chain, mechanism_.kernelChoice()), holdsTip());
  } else {
    generalSeries_.emplace(mechanism_.chain(), order);
    orders_.emplace(n_);
  }
  for (const auto& effect : effects_.all()) effect->reserveSeries(order);
  takeStiffness();
}

void Dynamics::series(double t, const double* y, const double* carry, int order, double* c) {
  std::copy_n(y, 2 * n_, c);
  lastSeries_ = {t, c, order};
  if (!series_) return findGeneralSeries(t, y, order, c);
  (general_ ? seriesOrders_ : evaluations_) += order;
  if (!effects_.act())
    return series_->find(order, {nullptr, nullptr, nullptr, external_.ground}, nullptr, c, carry);
  known_ = {t, n_, c, series_->rotations()};
  const bool hasForces = effects_.acting() == LoadKind::forces;
  if (general_) {
    const Evaluation& at = general_->at(t, y);
    std::copy(at.N.begin(), at.N.end(), room_.N.begin());
    if (hasForces) std::copy(at.F.begin(), at.F.end(), room_.F.begin());
  } else {
    apply(effects_.active(), t, y, y + n_);
  }
  const Vec2d* F = hasForces ? room_.F.data() : nullptr;
  series_->find(order, {nullptr, room_.N.data(), F, external_.ground}, this, c, carry);
}

void Dynamics::findGeneralSeries(double t, const double* y, int order, double* c) {
  const Evaluation& at = general_->at(t, y);  // counts as the first order
  seriesOrders_ += order - 1;
  const bool hasForces = effects_.acting() == LoadKind::forces;
  Couplings& orders = *orders_;
  effects_.couple(t, 0, orders);
  known_ = {t, n_, c, generalSeries_->rotations()};
  generalSeries_->begin(at.e.data(), at.xdd.data(), c,
                        {nullptr, hasForces ? at.F.data() : nullptr, orders.joints.data(), at.ground,
                         at.base.rate, at.groundTurning});
  for (int k = 1; k < order; ++k) {
    effects_.couple(t, k, orders);
    findOrder(k);
    generalSeries_->find(k, {room_.N.data(), hasForces ? room_.F.data() : nullptr, orders.joints.data(),
                             orders.pinAcceleration(), orders.angle.rate, orders.angle.acceleration});
  }
}

void Dynamics::findOrder(int k) {
  const Actions to{room_.N.data(), room_.F.data()};
  std::fill_n(to.N, n_, 0.0);
  const Coordinates& coordinates = mechanism_.coordinates();
  const std::vector<double>&stiffness = tangents_->constantK, &damping = tangents_->constantD;
  for (int i = 0; i < n_; ++i) {
    const double torque = -stiffness[index(i)] * coordinates.relative(known_.theta(k), i) -
                          damping[index(i)] * coordinates.relative(known_.omega(k), i);
    coordinates.addTorque(torque, i, to.N);
  }
  if (effects_.acting() == LoadKind::forces) std::fill_n(to.F, n_, Vec2d{});
  for (Effect* effect : effects_.active()) effect->addOrder(k, known_, to);
}

void Dynamics::integrands(double t, const double* y, double* rates) {
  const Powers powers = general_ ? general_->powers(t, y) : apply(effects_.active(), t, y, y + n_);
  rates[0] = powers.supplied;
  rates[1] = powers.dissipated;
}

}  // namespace planar_chain
