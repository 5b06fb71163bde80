#include "planar_chain/energy.h"

#include <algorithm>

#include "dynamics/stored_energy.h"

namespace planar_chain {

std::vector<const EffectKind*> storingKinds(const Chain& chain) {
  std::vector<const EffectKind*> storing;
  for (const EffectKind* kind : effectKinds()) {
    const auto storesIn = [kind](const Joint& joint) { return kind->stiffnessOf(joint) > 0; };
    if (std::any_of(chain.joints().begin(), chain.joints().end(), storesIn)) storing.push_back(kind);
  }
  return storing;
}

Energy energyOf(const Chain& chain, const double* theta, const double* omega) {
  return energyOf(chain, storingKinds(chain), theta, omega);
}

Energy energyOf(const Chain& chain, const std::vector<const EffectKind*>& kinds, const double* theta,
                const double* omega) {
  Energy energy;
  Vec2d pin, pinVelocity;
  for (int j = 0; j < chain.size(); ++j) {
    const Link& link = chain.links()[index(j)];
    const Joint& joint = chain.joints()[index(j)];
    const auto e = Rotation<double>::of(theta[j]);
    const Vec2d R = e * link.com;
    const Vec2d P = e * link.pin;
    const Vec2d v = pinVelocity + omega[j] * perp(R);
    double stored = 0;
    for (const EffectKind* kind : kinds) stored += kind->energyIn(joint, relative(theta, j));
    energy.kinetic += 0.5 * (link.mass * dot(v, v) + link.inertia * omega[j] * omega[j]);
    energy.elastic += stored;
    energy.potential -= link.mass * dot(chain.gravity(), pin + R);
    pin += P;
    pinVelocity += omega[j] * perp(P);
  }
  energy.potential += energy.elastic;
  return energy;
}

double angularMomentum(const Chain& chain, const double* theta, const double* omega) {
  double momentum = 0;
  Vec2d pin, pinVelocity;
  for (int j = 0; j < chain.size(); ++j) {
    const Link& link = chain.links()[index(j)];
    const auto e = Rotation<double>::of(theta[j]);
    const Vec2d R = e * link.com;
    const Vec2d P = e * link.pin;
    momentum += link.mass * cross(pin + R, pinVelocity + omega[j] * perp(R)) + link.inertia * omega[j];
    pin += P;
    pinVelocity += omega[j] * perp(P);
  }
  return momentum;
}

}  // namespace planar_chain
