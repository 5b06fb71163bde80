#include "dynamics/closed_state.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/closure.h"
#include "effects/effects.h"
#include "lanes/segments.h"

namespace planar_chain {

namespace {

/// The direction of v, rad, to 1e-6: a first guess whose digits do not depend on the C library.
double guessedAngle(Vec2d v) {
  return std::round(std::atan2(v.y, v.x) * 0x1p20) * 0x1p-20;
}

/// Lays the chain along an arc from its first pin to the tip's position, which hangs down. Prismatic and
/// prescribed joints stay.
void layArc(const Chain& chain, const Couplings& at, std::vector<double>& y) {
  const Coordinates& coordinates = chain.coordinates();
  const int leading = coordinates.leading(), n = chain.size();
  std::vector<Rotation<double>> e(index(n));
  const std::vector<double> none(index(n));
  // The way from the pin of body `first`, and its length, by angles of the bodies behind `turn`.
  const auto wayFrom = [&](int first, double turn) {
    Vec2d start;
    for (int j = 0; j < n; ++j) e[index(j)] = plainRotation(coordinates.angle(y.data(), j) + turn);
    const PointAt<double> tip = sweepOutwards(chain, PointAt<double>{}, e.data(), none.data(), y.data(),
                                              none.data(), [&](int j, const PointAt<double>& own) {
                                                if (j == first) start = own.position;
                                              });
    return tip.position - start;
  };
  Vec2d to = at.tipPosition - at.base().pin;
  if (leading > 0) to -= wayFrom(0, at.angle.value) - wayFrom(leading, at.angle.value);
  if (at.tip.rows == 1) to = dot(at.tip.row[0], to) * at.tip.row[0];
  // The chord shrinks while the angle of the arc grows to a whole turn.
  Vec2d chord;
  const auto turnBy = [&](double arc) {
    for (int j = leading; j < n; ++j) {
      if (coordinates.isPrismatic(j)) continue;
      const Vec2d pin = chain.links()[index(j)].pin;
      const double alongArc = arc * (j - leading) / (n - leading) - guessedAngle(pin);
      const int k = coordinates.inner(j);
      const double inner = k >= 0 ? y[index(k)] : 0;
      y[index(j)] = at.joints[index(j)].isPrescribed ? inner + at.prescribed[index(j)].value : alongArc;
    }
    chord = wayFrom(leading, 0);
    return length(chord);
  };
  double low = 0, high = 2 * pi;
  for (int k = 0; k < 60; ++k) (turnBy((low + high) / 2) > length(to) ? low : high) = (low + high) / 2;
  const double turn = guessedAngle(to) - guessedAngle(chord) - at.angle.value;
  bool turns = false;
  for (int j = leading; j < n; ++j) {
    turns = turns || !at.joints[index(j)].isPrescribed;
    if (turns && !coordinates.isPrismatic(j)) y[index(j)] += turn;
  }
}

/// Bends the chain to an arc that spans this angle, rad, less where its joints are far in or out.
void bend(const Mechanism& mechanism, const Couplings& at, double angle, std::vector<double>& y) {
  const int n = mechanism.size(), leading = mechanism.coordinates().leading();
  double turned = 0;
  for (int j = leading; j < n; ++j) {
    if (mechanism.coordinates().isPrismatic(j)) continue;
    const double own = angle * (0.5 - (j - leading + 0.5) / (n - leading));
    if (!at.joints[index(j)].isPrescribed) turned = own;
    y[index(j)] += turned;
  }
}

/// How far a tip that is pinned is beyond the reach of a chain on a fixed pin, or within its longest link, m.
double outOfReach(const Chain& chain, const Couplings& at) {
  if (chain.coordinates().anyIsPrismatic() || at.tip.rows < 2) return 0;
  double whole = 0, longest = 0;
  for (const Link& link : chain.links()) {
    whole += length(link.pin);
    longest = std::max(longest, length(link.pin));
  }
  const double distance = length(at.tipPosition - at.base().pin), rounding = Closure::closed * whole;
  const double gap = std::max(distance - whole, 2 * longest - whole - distance);
  return gap > rounding ? gap : 0;
}

}  // namespace

Closing closeState(const Scene& scene, double t, std::vector<double>& q, std::vector<double>& qd) {
  Closing closing;
  if (!scene.tip) return closing;
  Effects effects(scene);
  const Mechanism mechanism(scene, true);
  Closure closure(mechanism);
  Couplings at(mechanism.size());
  effects.enter(t);
  effects.couple(t, 0, at);

  const Coordinates& coordinates = mechanism.coordinates();
  const std::size_t n = q.size();
  std::vector<double> held = q, rates = qd, start(2 * n);
  at.hold(held.data(), rates.data());
  coordinates.toAbsolute(held.data(), start.data());
  coordinates.toAbsolute(rates.data(), start.data() + n);

  closing = {false, outOfReach(scene.chain, at)};
  if (closing.gap > 0) return closing;
  closing.gap = std::numeric_limits<double>::infinity();
  std::vector<double> y;
  for (const double angle : {0.0, std::nan(""), 0.3, -0.3, 1.5, -1.5, 4.0, -4.0}) {
    y = start;
    if (std::isnan(angle)) {
      layArc(scene.chain, at, y);
    } else {
      bend(mechanism, at, angle, y);
    }
    closing.isClosed = closure.project(at, y.data(), nullptr);
    closing.gap = std::min(closing.gap, length(closure.gap(at, y.data())));
    if (closing.isClosed) break;
  }
  if (!closing.isClosed) return closing;

  closing.onlyTouches = at.tip.rows == 1 && closure.spread(at, y.data()) < singularTip;
  coordinates.toRelative(y.data(), q.data());
  coordinates.toRelative(y.data() + n, qd.data());
  at.hold(q.data(), qd.data());
  return closing;
}

}  // namespace planar_chain
