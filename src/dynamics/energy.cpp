#include "planar_chain/energy.h"

#include "effects/effect_kind.h"

namespace planar_chain {

Energy energyOf(const Chain& chain, const double* theta, const double* omega) {
  const std::vector<const EffectKind*>& kinds = effectKinds();
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
