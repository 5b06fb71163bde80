#pragma once

/// The rails of slides on a base that turns by φ. A point that the slides up to i carry lies X from the
/// ground pin. Along the rails it moves at w. With e = exp(i φ), and p, d of slides in base axes,
///
///     X = Σ e (s_j d_j + p_{j−1})          w = Σ ṡ_j e d_j,   j ≤ i
///     v = v_base + w + φ̇ iX                a = a_base + Σ s̈_j e d_j + D,   D = φ̈ iX − φ̇² X + 2 φ̇ i w
///
/// D is the acceleration of Euler, of the centre and of Coriolis. Vectors have ground components.

#include "planar_chain/chain.h"
#include "recursion/dual.h"
#include "recursion/ends.h"

namespace planar_chain {

/// How the base turns.
template <class Real>
struct BaseTurn {
  Rotation<Real> e{};
  Real rate{}, acceleration{};  ///< φ̇, φ̈

  /// φ̈ iX − φ̇² X
  Vec2<Real> drift(Vec2<Real> X) const { return acceleration * perp(X) - (rate * rate) * X; }
};

/// A point that slides carry: X, v − v_base and D.
template <class Real>
struct RailPoint {
  Vec2<Real> place, velocity, drift;

  /// The point `arm` further, on the same slide.
  RailPoint at(Vec2<Real> arm, const BaseTurn<Real>& base) const {
    return {place + arm, velocity + base.rate * perp(arm), drift + base.drift(arm)};
  }
};

template <class Real>
struct Rails {
  PerEnd<Vec2<Real>> d;         ///< the directions
  PerEnd<RailPoint<Real>> own;  ///< the slides' own points
  PerEnd<RailPoint<Real>> com;  ///< their centres of mass
  RailPoint<Real> first;        ///< the pin of the first body that turns
};

/// s, rates: s_i and ṡ_i.
template <class Real>
Rails<Real> railsOf(const Chain& chain, const BaseTurn<Real>& base, const Real* s, const Real* rates) {
  const auto turned = [&](Vec2d a) { return base.e * Vec2<Real>{Real(a.x), Real(a.y)}; };
  Rails<Real> rails;
  RailPoint<Real>& at = rails.first;
  for (std::size_t i = 0; i < index(chain.slides()); ++i) {
    const Vec2<Real> d = rails.d[i] = turned(chain.joints()[i].axis);
    const Vec2<Real> slid = s[i] * d, w = rates[i] * d;
    at = at.at(slid, base);
    at.velocity += w;
    at.drift += (base.rate + base.rate) * perp(w);
    rails.own[i] = at;
    rails.com[i] = at.at(turned(chain.links()[i].com), base);
    at = at.at(turned(chain.links()[i].pin), base);
  }
  return rails;
}

inline Vec2d changeOf(Vec2<Dual> vector) {
  return {vector.x.slope, vector.y.slope};
}

/// The same while s_i and ṡ_i change by u_i and v_i.
inline Rails<Dual> changingRails(const Chain& chain, const BaseTurn<Dual>& base, const double* s,
                                 const double* rates, const double* u, const double* v) {
  PerEnd<Dual> places, speeds;
  for (std::size_t i = 0; i < index(chain.slides()); ++i) {
    places[i] = {s[i], u[i]};
    speeds[i] = {rates[i], v[i]};
  }
  return railsOf(chain, base, places.data(), speeds.data());
}

}  // namespace planar_chain
