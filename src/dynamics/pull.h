#pragma once

/// The force that pulls a point of the chain to a place: a critically damped spring, whatever hangs on the
/// point.
///
/// A force F at a point X of a link adds Λ⁻¹ F to the acceleration of X. Along a unit vector u it acts on the
/// effective mass m_eff:
///
///     Λ⁻¹ = J M_q⁻¹ Jᵀ,   v_X = J q̇              1/m_eff = u·Λ⁻¹ u
///
/// M_q contains the rotors. The columns of Λ⁻¹ take O(n): they are the accelerations of X in the chain at
/// rest without gravity, under a force of 1 N along x and along y. A mass m on a spring m ω² with a damper 2
/// m ω comes to rest soonest without overshoot. So, with d from X to the target,
///
///     F = Λ (ω² d − 2 ω v_X)                      adds ω² d − 2 ω v_X to the acceleration of X
///
/// Along a taut chain the effective mass is infinite. Along each axis of Λ⁻¹ it is replaced by this bound if
/// it exceeds it: the mass of the chain and of rods that have the inertia J of the rotors within X,
///
///     Σ m_i + Σ 3 J_i/l_i²          l_i² = max(|p^i|², 3 (I_i/m_i + |r^i|²)), the length of a uniform link
///
/// So the force is bounded. There the damping is less than critical.

#include <algorithm>
#include <cmath>
#include <vector>

#include "dynamics/inner_end.h"
#include "effects/effect_kind.h"
#include "lanes/coupled_chain.h"
#include "lanes/short_chain.h"
#include "planar_chain/chain.h"

namespace planar_chain {

/// What a link's centre of mass does; base-frame components.
struct CentreMotion {
  Vec2d place, velocity;  ///< m, m/s
  double omega;           ///< of the link, rad/s
};

/// A point of a link in motion; base-frame components.
struct PointMotion {
  Vec2d position;           ///< m
  Vec2d velocity;           ///< m/s
  Rotation<double> turn;    ///< of the link
  Sym2<double> mobility{};  ///< Λ⁻¹, 1/kg
  double mostMass = 0;      ///< the bound of the effective mass, kg
};

class Pull {
 public:
  /// The chain must outlive this object.
  explicit Pull(const Chain& chain)
      : chain_(chain), recursion_(chain.withoutSlides()), joints_(index(chain.size())) {
    const auto n = index(chain.size());
    for (auto* numbers : {&theta_, &omega_, &still_, &N_, &alpha_, &moments_}) numbers->resize(n);
    e_.resize(index(ShortChain::roomFor(chain.size())));
    F_.resize(n);
    double mass = 0;
    for (const Link& link : chain.links()) mass += link.mass;
    for (std::size_t i = 0; i < n; ++i) {
      const double J = joints_[i].rotor = inertiaIn(chain.joints()[i]);
      if (J > 0) mass += 3 * J / squareOfLength(chain.links()[i]);
      mostMass_.push_back(mass);
    }
    recursion_.couple(joints_.data() + chain.slides());
  }

  /// Returns the motion of a point of a link, with the base at rest at 0. q, qd: relative angles (rad) and
  /// rates (rad/s), n each; point: link frame, m. Allocates nothing.
  PointMotion motionOf(const double* q, const double* qd, int link, Vec2d point) {
    PointMotion motion;
    const Coordinates coordinates = chain_.coordinates();
    coordinates.toAbsolute(q, theta_.data());
    coordinates.toAbsolute(qd, omega_.data());
    for (int i = 0; i < chain_.size(); ++i) {
      const auto at = index(i);
      const bool slides = coordinates.slides(i);
      if (!slides) e_[at] = Rotation<double>::of(theta_[at]);
      if (i > link) continue;
      const Vec2d arm = e_[at] * (i < link ? chain_.links()[at].pin : point), axis = chain_.joints()[at].axis;
      motion.position += arm;
      motion.velocity += slides ? omega_[at] * axis : omega_[at] * perp(arm);
      if (slides) motion.position += theta_[at] * axis;
      arm_ = arm;
    }
    motion.turn = e_[index(link)];
    motion.mobility = mobility(link, {});
    motion.mostMass = mostMass_[index(link)];
    return motion;
  }
  /// Returns it with a base that moves. angles: absolute, rad, n; the angle of a slide is that of the base.
  PointMotion motionOf(const double* angles, const CentreMotion& centre, int link, Vec2d point) {
    const int slides = chain_.slides();
    const double base = slides > 0 ? angles[0] : 0;  // without slides, absolute angles suffice
    for (int i = slides; i < chain_.size(); ++i) e_[index(i)] = Rotation<double>::of(angles[i] - base);
    arm_ = e_[index(link)] * point;
    const auto turn = Rotation<double>::of(angles[link]);
    const Vec2d arm = turn * (point - chain_.links()[index(link)].com);
    return {centre.place + arm, centre.velocity + centre.omega * perp(arm), turn,
            mobility(link, Rotation<double>::of(base)), mostMass_[index(link)]};
  }

  /// Returns F on that point, N. pulsation: ω, rad/s, > 0.
  Vec2d force(const PointMotion& point, Vec2d target, double pulsation) const {
    const Vec2d wanted = pulsation * pulsation * (target - point.position) - 2 * pulsation * point.velocity;
    const auto [inverse, axis] = eigen(point.mobility);  // 1/m along each axis of Λ⁻¹
    Vec2d force;
    for (const std::size_t i : {0, 1}) {
      force += (dot(axis[i], wanted) / std::fmax(inverse[i], 1 / point.mostMass)) * axis[i];
    }
    return force;
  }

 private:
  /// l² of a link. It is > 0: a point mass on both of its pins is no link of a Chain.
  static double squareOfLength(const Link& link) {
    return std::fmax(dot(link.pin, link.pin), 3 * (link.inertia / link.mass + dot(link.com, link.com)));
  }
  /// Λ⁻¹ of a chain whose rails are turned by this.
  Sym2<double> mobility(int link, Rotation<double> turn) {
    const Rotation<double> back{turn.c, -turn.s};
    const Vec2d alongX = turn * answer(link, back * Vec2d{1, 0});
    const Vec2d alongY = turn * answer(link, back * Vec2d{0, 1});
    return {alongX.x, (alongX.y + alongY.x) / 2, alongY.y};
  }
  /// The acceleration that the force gives the point, at rest and without gravity.
  Vec2d answer(int link, Vec2d force) {
    const std::size_t last = index(link);
    const std::size_t slides = index(chain_.slides());
    N_[last] = last < slides ? 0 : cross(arm_, force);
    F_[last] = force;
    InnerEnd<double> inner = innerEndOf(chain_, joints_.data());
    setForces(N_.data(), F_.data(), inner);
    EndsMotion<double> ends;
    recursion_.accelerations({e_.data() + slides, N_.data() + slides, F_.data() + slides, {}}, nullptr,
                             still_.data(), 0, inner, {}, alpha_.data() + slides, moments_.data(), ends);
    std::copy_n(ends.acceleration.begin(), slides, alpha_.begin());
    N_[last] = 0;
    F_[last] = {};

    Vec2d a;
    for (std::size_t i = 0; i < std::min(slides, last + 1); ++i) a += alpha_[i] * chain_.joints()[i].axis;
    for (std::size_t i = slides; i < last; ++i) a += alpha_[i] * perp(e_[i] * chain_.links()[i].pin);
    return last < slides ? a : a + alpha_[last] * perp(arm_);
  }

  const Chain& chain_;
  CoupledChain recursion_;
  std::vector<Coupling<double>> joints_;
  std::vector<double> mostMass_;  ///< of points of each link, kg
  Vec2d arm_;                     ///< from the link's inner pin to the point, base frame
  std::vector<Rotation<double>> e_;
  std::vector<double> theta_, omega_, still_, N_, alpha_, moments_;
  std::vector<Vec2d> F_;
};

}  // namespace planar_chain
