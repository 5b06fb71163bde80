/// The Taylor series of the motion: of dynamics.h.

#include <algorithm>

#include "dynamics/dynamics.h"

namespace planar_chain {

/// What else couples has no series beside a slide or a held tip.
bool Dynamics::hasSeries() const {
  const std::size_t tips = mechanism_.slides() == 0 && holdsTip() ? 1 : 0;
  const bool couples = effects_.couplers().size() > tips || effects_.anyForces(&Forces::dependOnMotion);
  return MotionSeries::areFor(mechanism_.chain()) && effects_.haveSeries() &&
         !(mechanism_.hasEnds() && couples);
}

double Dynamics::seriesCost(int order) const {
  constexpr double ofCoupledOrder = 4.5;  // by clock, 2 to 20 links
  return series_ ? series_->cost(order) : ofCoupledOrder * order;
}

void Dynamics::reserveSeries(int order) {
  const int reserved = series_ ? series_->orders() : coupledSeries_ ? coupledSeries_->orders() : 0;
  if (reserved >= order) return;
  if (coupled_ && !mechanism_.hasEnds()) {
    coupledSeries_.emplace(mechanism_.chain(), order);
    orders_.emplace(n_);
  } else {
    series_.emplace(mechanism_.chain(), order, nullptr, holdsTip());
  }
  for (const auto& effect : effects_.all()) effect->reserveSeries(order);
  takeStiffness();
}

void Dynamics::series(double t, const double* y, const double* carry, int order, double* c) {
  std::copy_n(y, 2 * n_, c);
  if (!series_) return findCoupledSeries(t, y, order, c);
  (coupled_ ? endedOrders_ : evaluations_) += order;
  if (!effects_.act())
    return series_->find(order, {nullptr, nullptr, nullptr, outside_.ground}, nullptr, c, carry);
  known_ = {t, n_, c, series_->rotations()};
  const bool hasForces = effects_.acting() == LoadKind::forces;
  if (coupled_) {
    const Evaluation& at = coupled_->at(t, y);
    std::copy(at.N.begin(), at.N.end(), room_.N.begin());
    if (hasForces) std::copy(at.F.begin(), at.F.end(), room_.F.begin());
  } else {
    apply(effects_.active(), t, y, y + n_);
  }
  const Vec2d* F = hasForces ? room_.F.data() : nullptr;
  series_->find(order, {nullptr, room_.N.data(), F, outside_.ground}, this, c, carry);
}

void Dynamics::findCoupledSeries(double t, const double* y, int order, double* c) {
  const Evaluation& at = coupled_->at(t, y);
  const Vec2d* F = effects_.acting() == LoadKind::forces ? room_.F.data() : nullptr;
  coupledSeries_->begin(at.e.data(), at.omega(), at.alpha.data(), at.ground, F ? at.F.data() : nullptr);
  known_ = {t, n_, c, coupledSeries_->rotations()};
  double* alpha = room_.derivative.data();
  double* omega = alpha + n_;
  std::copy_n(at.alpha.data(), n_, alpha);
  Couplings& orders = *orders_;
  effects_.couple(t, 0, orders);
  for (int k = 0; k < order; ++k) {
    double *row = c + std::ptrdiff_t{2} * n_ * k, *next = row + std::ptrdiff_t{2} * n_;
    if (k > 0) {
      effects_.couple(t, k, orders);
      for (int i = 0; i < n_; ++i) omega[i] = row[n_ + i] + orders.angle.rate;
      findOrder(k);
      coupledSeries_->find(k, omega, room_.N.data(), F, orders.joints.data(), orders.pinAcceleration(),
                           orders.angle.acceleration, alpha);
    }
    for (int i = 0; i < n_; ++i) {
      next[i] = row[n_ + i] / (k + 1);
      next[n_ + i] = (alpha[i] - orders.angle.acceleration) / (k + 1);
    }
  }
}

void Dynamics::findOrder(int k) {
  const Actions to{room_.N.data(), room_.F.data()};
  std::fill_n(to.N, n_, 0.0);
  const Coordinates coordinates = mechanism_.coordinates();
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
  const Powers powers = coupled_ ? coupled_->powers(t, y) : apply(effects_.active(), t, y, y + n_);
  rates[0] = powers.supplied;
  rates[1] = powers.dissipated;
}

}  // namespace planar_chain
