#pragma once

/// The momenta of a free chain, while nothing but gravity acts on it from outside: with the centre of mass C,
/// its velocity V, and the angular momentum L about C,
///
///     C(t + h) = C + h V + h²/2 g          V(t + h) = V + h g          L(t + h) = L
///
/// A step meets this within its error. Then the chain is moved as one rigid body, which is the least motion
/// in the metric of the mass matrix: C and V by what they lack, and by δ = (L − L_is)/J about C, where J is
/// the moment of inertia about C. So the errors of steps do not add up. O(n).
///
/// Source: as closure.h.

#include <algorithm>
#include <vector>

#include "dynamics/add_carried.h"
#include "dynamics/mechanism.h"
#include "effects/effects.h"
#include "planar_chain/scene.h"
#include "recursion/pose.h"

namespace planar_chain {

/// True if nothing holds the chain: it begins with two prismatic joints without mass along x and y and a
/// revolute one, with nothing in these three; all others are revolute, and the tip is free.
inline bool isFree(const Scene& scene) {
  const Chain& chain = scene.chain;
  const Coordinates& coordinates = chain.coordinates();
  if (coordinates.leading() != 2 || coordinates.anyIsInside() || chain.size() == 2 || scene.base || scene.tip)
    return false;
  for (std::size_t i = 0; i <= 2; ++i) {
    const Joint& joint = chain.joints()[i];
    if (joint.stiffness != 0 || joint.damping != 0 || joint.isLimited() || !joint.others.empty())
      return false;
    if (i < 2 && chain.links()[i].mass != 0) return false;
  }
  return chain.joints()[0].axis == Vec2d{1, 0} && chain.joints()[1].axis == Vec2d{0, 1} &&
         std::none_of(scene.drives.begin(), scene.drives.end(),
                      [](const Drive& drive) { return drive.joint <= 2; });
}

/// Only the constructor allocates.
class Momenta {
 public:
  /// The chain must be free. The arguments must outlive this object.
  Momenta(const Mechanism& mechanism, Effects& effects)
      : mechanism_(mechanism), effects_(effects), n_(mechanism.size()), e_(index(n_)), torques_(index(n_)) {
    for (const Link& link : mechanism.chain().links()) mass_ += link.mass;
  }

  /// Moves the state y at t1 to what follows from the state `before` at t0, unless something acts from
  /// outside. carry: the rounding errors of y. Nothing is switched between t0 and t1.
  void keep(double t0, const double* before, double t1, double* y, double* carry) {
    if (isActedOn(t0, before) || isActedOn(t1, y)) return;
    const Values then = of(before), now = of(y);
    if (now.J <= 0) return;
    const double h = t1 - t0, turn = (then.L - now.L) / now.J;
    const Vec2d g = mechanism_.chain().gravity();
    const auto pinOf = [](const double* numbers) { return Vec2d{numbers[0], numbers[1]}; };
    const Vec2d V = pinOf(before + n_) + then.V;
    const Vec2d dx = (pinOf(before) - pinOf(y)) + (then.C - now.C) + h * V + (h * h / 2) * g;
    const Vec2d dv = V - pinOf(y + n_) - now.V + h * g - turn * perp(now.C);
    const auto move = [&](int i, double change) { addCarried(change, y[i], carry + i); };
    move(0, dx.x);
    move(1, dx.y);
    move(n_, dv.x);
    move(n_ + 1, dv.y);
    for (int j = leading; j < n_; ++j) move(n_ + j, turn);
  }

 private:
  /// C and V are measured from the first pin.
  struct Values {
    Vec2d C, V;
    double L, J;
  };
  Values of(const double* y) {
    mechanism_.rotate(y, 0, e_.data());
    const Chain& chain = mechanism_.chain();
    Vec2d first, momentum;
    double L = 0, J = 0;
    sweepOutwards<false>(chain, leading, n_, PointAt<double>{}, e_.data() + leading, y + n_ + leading, y, y,
                         [&](int j, const PointAt<double>& pin) {
                           const Link& link = chain.links()[index(j)];
                           const double omega = y[n_ + j];
                           const Vec2d R = e_[index(j)] * link.com;
                           const Vec2d c = pin.position + R, p = link.mass * (pin.velocity + omega * perp(R));
                           first += link.mass * c;
                           momentum += p;
                           L += cross(c, p) + link.inertia * omega;
                           J += link.mass * dot(c, c) + link.inertia;
                         });
    const Vec2d C = (1 / mass_) * first;
    return {C, (1 / mass_) * momentum, L - cross(C, momentum), J - mass_ * dot(C, C)};
  }
  /// Steps are short against what changes with time, so a torque that is 0 at both ends of one is 0 within
  /// it.
  bool isActedOn(double t, const double* y) {
    if (effects_.acting() == LoadKind::forces) return true;
    std::fill(torques_.begin(), torques_.end(), 0.0);
    effects_.addTorques({t, y, y + n_}, torques_.data());
    return std::any_of(torques_.begin(), torques_.begin() + leading + 1, [](double tau) { return tau != 0; });
  }

  static constexpr int leading = 2;
  const Mechanism& mechanism_;
  Effects& effects_;
  int n_;
  double mass_ = 0;  ///< of the chain, kg
  std::vector<Rotation<double>> e_;
  std::vector<double> torques_;
};

}  // namespace planar_chain
