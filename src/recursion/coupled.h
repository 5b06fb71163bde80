#pragma once

/// Forward dynamics in O(n) of a chain whose joints couple accelerations: with rotors, driven or stuck
/// joints, and a base that moves. articulated.h has the letters and the recursion without them.
///
/// The moment μ of such a joint on its body depends on the accelerations of both bodies. So a body shows its
/// inner pin, of acceleration a, and the body inside of it, of angular acceleration α_p,
///
///     F_pin = A a + H α_p + b          μ = H·a + Q α_p + c
///
/// N contains all other joint torques. The sweep inwards starts at the tip with zeros:
///
///     U = m iR + A iP + H              D0 = I + m|R|² + iP·(A iP) + 2 iP·H + Q
///     β = b − ω² A P                   ε  = N − iP·β − (c − ω² H·P)
///     f = β − F − ω² m R
///
///     free joint with a rotor, μ = −J (α − α_p); J = 0 without one:
///         D = D0 + J                   α = (ε − U·a + J α_p)/D
///         A ← m + A − U Uᵀ/D           H ← U J/D       Q ← J D0/D      b ← f + U ε/D    c ← −J ε/D
///     held joint, q̈ given: the limit J → ∞
///         α = α_p + q̈                  μ = D0 α + U·a − ε
///         A ← m + A                    H ← U           Q ← D0          b ← f + U q̈      c ← D0 q̈ − ε
///
/// Outwards a ← a + iα P − ω² P, from the acceleration of the ground pin less gravity and from the base's
/// angular acceleration. The F_pin of the first body is the force of the base on it. If all joints are held,
/// this is inverse dynamics.
///
/// Source: derived as in articulated.h. Against a dense system with all pin forces as unknowns: coupled_test.

#include <vector>

#include "planar_chain/chain.h"
#include "planar_chain/planar.h"
#include "recursion/articulated.h"

namespace planar_chain {

/// What couples the accelerations of a joint's two bodies.
template <class Real>
struct Coupling {
  Real rotor{};         ///< J, kg m²
  bool isHeld = false;  ///< driven or stuck: q̈ is given
  Real acceleration{};  ///< q̈ of a held joint, rad/s²
};

/// A 2-vector's outer product with itself, k times.
template <class Real>
constexpr Sym2<Real> square(Real k, Vec2<Real> U) {
  return {k * U.x * U.x, k * U.x * U.y, k * U.y * U.y};
}

template <class Real = double>
class Coupled {
 public:
  explicit Coupled(const Chain& chain) : bodies_(index(chain.size())) {
    for (int j = 0; j < chain.size(); ++j) {
      const Link& link = chain.links()[index(j)];
      bodies_[index(j)].of = {Real(link.mass),
                              Real(link.inertia),
                              {Real(link.com.x), Real(link.com.y)},
                              {Real(link.pin.x), Real(link.pin.y)}};
    }
  }

  /// Writes α, rad/s², and μ of each joint, N m. e, omega, N, F: as Articulated<Real>::accelerations; F may
  /// be nullptr. ground: acceleration of the ground pin less gravity, m/s². turning: the base's angular
  /// acceleration, rad/s². n values each. Returns F_pin of the first body, N. Allocates nothing.
  Vec2<Real> accelerations(const Rotation<Real>* e, const Real* omega, const Real* N, const Vec2<Real>* F,
                           const Coupling<Real>* joints, Vec2<Real> ground, Real turning, Real* alpha,
                           Real* moments) {
    // Inwards.
    Sym2<Real> A;
    Vec2<Real> H, b;
    Real Q{}, c{};
    for (std::size_t j = bodies_.size(); j-- > 0;) {
      Swept& body = bodies_[j];
      body.at = turned(body.of, e[j], omega[j]);
      const auto& [m, J, R, P, ww] = body.at;
      const Vec2<Real> mR = m * R, iP = perp(P), AiP = A * iP;
      const Vec2<Real> beta = b - ww * (A * P);
      const Vec2<Real> U = perp(mR) + AiP + H;
      const Real D0 = J + dot(iP, AiP) + Real(2) * dot(iP, H) + Q;
      const Real epsilon = N[j] - dot(iP, beta) - (c - ww * dot(H, P));
      Vec2<Real> f = beta - ww * mR;
      if (F) f -= F[j];
      const Coupling<Real>& joint = joints[j];
      const Real D = D0 + joint.rotor, over = joint.isHeld ? Real(0) : Real(1) / D;
      const Sym2<Real> taken = square(-over, U);
      A = {m + A.xx + taken.xx, A.xy + taken.xy, m + A.yy + taken.yy};
      if (joint.isHeld) {
        H = U;
        Q = D0;
        b = f + joint.acceleration * U;
        c = D0 * joint.acceleration - epsilon;
      } else {
        H = (joint.rotor * over) * U;
        Q = joint.rotor * over * D0;
        b = f + (epsilon * over) * U;
        c = -(joint.rotor * over * epsilon);
      }
      body.U = U;
      body.D0 = D0;
      body.epsilon = epsilon;
      body.over = over;
    }
    const Vec2<Real> pinForce = A * ground + turning * H + b;

    // Outwards.
    Vec2<Real> a = ground;
    Real parent = turning;
    for (std::size_t j = 0; j < bodies_.size(); ++j) {
      const Swept& body = bodies_[j];
      const Coupling<Real>& joint = joints[j];
      const Real pulled = body.epsilon - dot(body.U, a);
      if (joint.isHeld) {
        alpha[j] = parent + joint.acceleration;
        moments[j] = body.D0 * alpha[j] - pulled;
      } else {
        alpha[j] = body.over * (pulled + joint.rotor * parent);
        moments[j] = -joint.rotor * (alpha[j] - parent);
      }
      a += alpha[j] * perp(body.at.P) - body.at.ww * body.at.P;
      parent = alpha[j];
    }
    return pinForce;
  }

 private:
  struct Swept {
    Body<Real> of;
    Turned<Real> at;
    Vec2<Real> U;
    Real D0, epsilon, over;  ///< over: 1/D, 0 for a held joint
  };
  std::vector<Swept> bodies_;
};

}  // namespace planar_chain
