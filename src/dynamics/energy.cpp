#include "planar_chain/energy.h"

#include <algorithm>
#include <cmath>

#include "dynamics/stored_energy.h"
#include "lanes/segments.h"
#include "recursion/pose.h"

namespace planar_chain {

Stores::Stores(const Chain& chain) {
  for (const EffectKind* kind : effectKinds()) {
    const auto storesIn = [kind](const auto& part) { return kind->stiffnessOf(part) > 0; };
    if (std::any_of(chain.joints().begin(), chain.joints().end(), storesIn) ||
        std::any_of(chain.links().begin(), chain.links().end(), storesIn)) {
      kinds.push_back(kind);
    }
  }
  for (const Joint& joint : chain.joints()) rotors.push_back(inertiaIn(joint));
  if (std::all_of(rotors.begin(), rotors.end(), [](double J) { return J == 0; })) rotors.clear();
}

namespace {

/// Calls f(j, body, x, v, ω): each body, position and velocity of its centre of mass, and its rate, from the
/// ground outwards.
template <class F>
void forCentres(const Chain& chain, const double* theta, const double* omega, const BaseState& base, F f) {
  // A block of bodies at a time, whose rotations need no memory of the heap.
  constexpr int atOnce = 32;
  const Coordinates& coordinates = chain.coordinates();
  double angles[atOnce], rates[atOnce];
  Rotation<double> e[atOnce];
  PointAt<double> pin{base.pin, base.velocity};
  for (int first = 0; first < chain.size(); first += atOnce) {
    const int count = std::min(atOnce, chain.size() - first);
    for (int k = 0; k < count; ++k) {
      angles[k] = coordinates.angle(theta, first + k) + base.angle;
      rates[k] = coordinates.angle(omega, first + k) + base.rate;
    }
    plainRotations(angles, e, count);
    pin = sweepOutwards(
        chain, first, first + count, pin, e, rates, theta + first, omega + first,
        [&](int j, const PointAt<double>& own) {
          const int k = j - first;
          const Vec2d R = e[k] * chain.links()[index(j)].com;
          f(j, PosedBody{own.position, e[k]}, own.position + R, own.velocity + rates[k] * perp(R), rates[k]);
        });
  }
}

}  // namespace

Energy energyOf(const Chain& chain, const double* theta, const double* omega) {
  return energyOf(chain, Stores(chain), theta, omega);
}

Energy energyOf(const Chain& chain, const Stores& stores, const double* theta, const double* omega,
                const BaseState& base) {
  Energy energy;
  const Coordinates& coordinates = chain.coordinates();
  forCentres(chain, theta, omega, base, [&](int j, const PosedBody& body, Vec2d x, Vec2d v, double rate) {
    const Link& link = chain.links()[index(j)];
    double stored = 0;
    for (const EffectKind* kind : stores.kinds) {
      stored += kind->energyIn(chain.joints()[index(j)], coordinates.relative(theta, j)) +
                kind->energyOf(link, body);
    }
    energy.kinetic += 0.5 * (link.mass * dot(v, v) + link.inertia * rate * rate);
    energy.elastic += stored;
    energy.potential -= link.mass * dot(chain.gravity(), x);
  });
  energy.potential += energy.elastic;
  for (std::size_t i = 0; i < stores.rotors.size(); ++i) {
    const double rate = coordinates.relative(omega, static_cast<int>(i));
    energy.kinetic += 0.5 * stores.rotors[i] * rate * rate;
  }
  return energy;
}

double angularMomentum(const Chain& chain, const double* theta, const double* omega) {
  double momentum = 0;
  forCentres(chain, theta, omega, {}, [&](int j, const PosedBody&, Vec2d x, Vec2d v, double rate) {
    const Link& link = chain.links()[index(j)];
    momentum += link.mass * cross(x, v) + link.inertia * rate;
  });
  return momentum;
}

double leastStored(const Stores& stores, const Joint& joint, double q, double acting) {
  const auto V = [&](double at) {
    double sum = 0;
    for (const EffectKind* kind : stores.kinds) sum += kind->energyIn(joint, at);
    return sum;
  };
  constexpr int most = 10;  // Newton's method: V is quadratic in pieces
  for (int k = 0; k < most; ++k) {
    const double slope = (V(q + 1) - V(q - 1)) / 2, curvature = V(q + 1) - 2 * V(q) + V(q - 1);
    if (!(std::abs(slope) > acting && curvature > 0)) break;
    q -= slope / curvature;
  }
  return q;
}

}  // namespace planar_chain
