#include "dynamics/mechanism.h"

#include <algorithm>

#include "lanes/kernel.h"

namespace planar_chain {

Mechanism::Mechanism(const Chain& chain, bool inOrder, bool holdsTip)
    : chain_(chain),
      coordinates_(chain.coordinates()),
      n_(chain.size()),
      holdsTip_(holdsTip),
      places_(n_),
      rotations_(simd::kernels().front()->rotations) {
  if (slides() > 0) bodies_.emplace(chain.withoutSlides());
  if (inOrder || holdsTip || n_ <= ShortChain::most) return;
  lanes_.emplace(n_);
  places_ = lanes_->places();
}

Recursion Mechanism::makeRecursion() const {
  if (bodies().size() <= ShortChain::most) return ShortChain(bodies());
  return Segments(bodies());
}

void Mechanism::rotate(const double* theta, double angle, Rotation<double>* e) const {
  rotate(theta + slides(), e + slides(), n_ - slides());
  if (angle == 0) return;
  const Rotation<double> turn = plainRotation(angle);
  for (int j = slides(); j < n_; ++j) e[j] = turn * e[j];
}

void Mechanism::toLanes(const double* inOrder, double* inLanes) const {
  if (!lanes_) {
    std::copy_n(inOrder, 2 * n_, inLanes);
    return;
  }
  lanes_->arrange(inOrder, inLanes);
  lanes_->arrange(inOrder + n_, inLanes + places_);
}

void Mechanism::toOrder(const double* inLanes, double* inOrder) const {
  if (!lanes_) {
    std::copy_n(inLanes, 2 * n_, inOrder);
    return;
  }
  lanes_->restore(inLanes, inOrder);
  lanes_->restore(inLanes + places_, inOrder + n_);
}

const double* Mechanism::quantityInLanes(const double* values, double* room) const {
  if (!lanes_) return values;
  lanes_->arrange(values, room);
  return room;
}

const double* Mechanism::stateInOrder(const double* y, double* room) const {
  if (!lanes_) return y;
  toOrder(y, room);
  return room;
}

void Mechanism::findPinVelocities(const Rotation<double>* e, const double* omega, int count,
                                  Vec2d* velocities, Vec2d v) const {
  for (int j = slides(); j < count; ++j) {
    velocities[j] = v;
    v += omega[j] * perp(e[j] * chain_.links()[index(j)].pin);
  }
}

void Mechanism::findPinChanges(const Rotation<double>* e, const double* omega, const double* u,
                               const double* v, int count, const Rails<Dual>& rails, Vec2d* places,
                               Vec2d* velocities, Vec2d dx, Vec2d dv) const {
  for (int i = 0; i < std::min(slides(), count); ++i) {
    const RailPoint<Dual>& own = rails.own[index(i)];
    if (places) places[i] = dx + changeOf(own.place);
    velocities[i] = dv + changeOf(own.velocity);
  }
  dx += changeOf(rails.first.place);
  dv += changeOf(rails.first.velocity);
  for (int j = slides(); j < count; ++j) {
    if (places) places[j] = dx;
    velocities[j] = dv;
    const Vec2d P = e[j] * chain_.links()[index(j)].pin;
    dx += u[j] * perp(P);
    dv += v[j] * perp(P) - (omega[j] * u[j]) * P;
  }
}

}  // namespace planar_chain
