#pragma once

/// The force that pulls a point of the chain to a target: a critically damped spring, whatever hangs on the
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

#include "effects/effect_kind.h"
#include "lanes/general_chain.h"
#include "lanes/kernel.h"
#include "lanes/short_chain.h"
#include "planar_chain/chain.h"
#include "recursion/pose.h"

namespace planar_chain {

/// The motion of a link's centre of mass; base-frame components.
struct CentreMotion {
  Vec2d position, velocity;  ///< m, m/s
  double omega;              ///< of the link, rad/s
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
      : chain_(chain),
        recursion_(chain, simd::kernelFor(chain.size(), {}), chain.size() > ShortChain::most),
        laws_(index(chain.size())) {
    const auto n = index(chain.size());
    for (auto* numbers : {&x_, &rates_, &omega_, &still_, &N_, &xdd_, &moments_}) numbers->resize(n);
    e_.resize(index(ShortChain::roomFor(chain.size())));
    F_.resize(n);
    displaced_.resize(n);
    double mass = 0;
    for (const Link& link : chain.links()) mass += link.mass;
    for (std::size_t i = 0; i < n; ++i) {
      const Joint& joint = chain.joints()[i];
      const double J = laws_[i].armature = inertiaIn(joint);
      if (J > 0) mass += joint.isPrismatic ? J : 3 * J / squareOfLength(chain.links()[i]);
      mostMass_.push_back(mass);
    }
    recursion_.take(laws_.data());
  }

  /// Returns the motion of a point of a link, with the base at rest at 0. q, qd: relative angles (rad) and
  /// rates (rad/s), n each; point: link frame, m. Allocates nothing.
  PointMotion motionOf(const double* q, const double* qd, int link, Vec2d point) {
    PointMotion motion;
    const Coordinates& coordinates = chain_.coordinates();
    coordinates.toAbsolute(q, x_.data());
    coordinates.toAbsolute(qd, rates_.data());
    for (int j = 0; j < chain_.size(); ++j) {
      e_[index(j)] = Rotation<double>::of(coordinates.angle(x_.data(), j));
      omega_[index(j)] = coordinates.angle(rates_.data(), j);
    }
    const Vec2d arm = e_[index(link)] * point;
    sweepOutwards(chain_, PointAt<double>{}, e_.data(), omega_.data(), x_.data(), rates_.data(),
                  [&](int j, const PointAt<double>& own) {
                    if (j != link) return;
                    motion.position = own.position + arm;
                    motion.velocity = own.velocity + omega_[index(j)] * perp(arm);
                  });
    motion.turn = e_[index(link)];
    motion.mobility = mobility(link, arm);
    motion.mostMass = mostMass_[index(link)];
    return motion;
  }
  /// Returns it with a base that moves. angles: of the links, absolute, rad; q: displacements of prismatic
  /// joints, m, n each.
  PointMotion motionOf(const double* angles, const double* q, const CentreMotion& centre, int link,
                       Vec2d point) {
    for (int j = 0; j < chain_.size(); ++j) {
      e_[index(j)] = Rotation<double>::of(angles[j]);
      x_[index(j)] = q[j];
    }
    const Rotation<double> turn = e_[index(link)];
    const Vec2d arm = turn * (point - chain_.links()[index(link)].com);
    return {centre.position + arm, centre.velocity + centre.omega * perp(arm), turn,
            mobility(link, turn * point), mostMass_[index(link)]};
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
  /// Λ⁻¹ at the present rotations and displacements. arm: from the link's own point.
  Sym2<double> mobility(int link, Vec2d arm) {
    for (int j = 0; j < chain_.size(); ++j) {
      const auto i = index(j);
      if (chain_.coordinates().isPrismatic(j))
        displaced_[i] = displacementOf(chain_.joints()[i].axis, e_[i], 0.0, x_[i], 0.0);
    }
    const Vec2d alongX = answer(link, arm, {1, 0}), alongY = answer(link, arm, {0, 1});
    return {alongX.x, (alongX.y + alongY.x) / 2, alongY.y};
  }
  /// The acceleration that the force gives the point, at rest and without gravity.
  Vec2d answer(int link, Vec2d arm, Vec2d force) {
    const Coordinates& coordinates = chain_.coordinates();
    const int turner = coordinates.turner(link);
    if (turner >= 0) N_[index(turner)] = cross(arm, force);
    F_[index(link)] = force;
    EndForces<double> ends;
    recursion_.accelerations({e_.data(), N_.data(), F_.data(), {}}, nullptr, still_.data(), displaced_.data(),
                             0, {}, xdd_.data(), moments_.data(), ends);
    if (turner >= 0) N_[index(turner)] = 0;
    F_[index(link)] = {};

    // Velocities by xdd in place of rates are accelerations of the chain at rest.
    Vec2d a;
    for (int j = 0; j < chain_.size(); ++j) omega_[index(j)] = coordinates.angle(xdd_.data(), j);
    sweepOutwards(chain_, 0, link + 1, PointAt<double>{}, e_.data(), omega_.data(), x_.data(), xdd_.data(),
                  [&](int, const PointAt<double>& own) { a = own.velocity; });
    return a + omega_[index(link)] * perp(arm);
  }

  const Chain& chain_;
  GeneralChain recursion_;
  std::vector<JointLaw<double>> laws_;
  std::vector<double> mostMass_;  ///< of points of each link, kg
  std::vector<Rotation<double>> e_;
  std::vector<double> x_, rates_, omega_, still_, N_, xdd_, moments_;
  std::vector<Vec2d> F_;
  std::vector<Displacement<double>> displaced_;
};

}  // namespace planar_chain
