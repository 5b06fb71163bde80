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
/// Source: derived as in articulated.h. Against another formulation: machines_test.

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
    // Inwards. H, Q and c are 0 inside of a joint that couples nothing.
    Sym2<Real> A;
    Vec2<Real> H, b;
    Real Q{}, c{};
    bool outerCouples = false;
    for (std::size_t j = bodies_.size(); j-- > 0;) {
      Swept& body = bodies_[j];
      const Coupling<Real>& joint = joints[j];
      body.at = turned(body.of, e[j], omega[j]);
      const bool couples = joint.isHeld || joint.rotor != Real(0);
      if (!couples && !outerCouples) {
        const Handle<Real> handle = inwards<false>(body.at, N[j], A, b);
        if (F) b -= F[j];
        body.U = handle.inverseD * handle.U;
        body.epsilon = handle.inverseD * handle.u;
        continue;
      }
      outerCouples = couples;
      const auto& [m, J, R, P, ww] = body.at;
      const Vec2<Real> mR = m * R, iP = perp(P), AiP = A * iP;
      const Vec2<Real> beta = b - ww * (A * P);
      const Vec2<Real> U = perp(mR) + AiP + H;
      const Real D0 = J + dot(iP, AiP) + Real(2) * dot(iP, H) + Q;
      const Real epsilon = N[j] - dot(iP, beta) - (c - ww * dot(H, P));
      Vec2<Real> f = beta - ww * mR;
      if (F) f -= F[j];
      if (joint.isHeld) {
        A = {m + A.xx, A.xy, m + A.yy};
        H = body.U = U;
        Q = body.D0 = D0;
        b = f + joint.acceleration * U;
        c = D0 * joint.acceleration - epsilon;
        body.epsilon = epsilon;
        continue;
      }
      const Real over = Real(1) / (D0 + joint.rotor), held = joint.rotor * over;
      const Sym2<Real> taken = square(-over, U);
      A = {m + A.xx + taken.xx, A.xy + taken.xy, m + A.yy + taken.yy};
      H = held * U;
      Q = held * D0;
      b = f + (epsilon * over) * U;
      c = -(held * epsilon);
      body.U = over * U;
      body.epsilon = over * epsilon;
      body.held = held;
    }
    const Vec2<Real> pinForce = A * ground + turning * H + b;

    // Outwards.
    Vec2<Real> a = ground;
    Real parent = turning;
    for (std::size_t j = 0; j < bodies_.size(); ++j) {
      const Swept& body = bodies_[j];
      const Coupling<Real>& joint = joints[j];
      const Real pulled = mulAdd(-body.U.x, a.x, mulAdd(-body.U.y, a.y, body.epsilon));
      Real turn = pulled, moment{};
      if (joint.isHeld) {
        turn = parent + joint.acceleration;
        moment = body.D0 * turn - pulled;
      } else if (joint.rotor != Real(0)) {
        turn += body.held * parent;
        moment = -joint.rotor * (turn - parent);
      }
      a = mulAdd(turn, perp(body.at.P), mulAdd(-body.at.ww, body.at.P, a));
      alpha[j] = parent = turn;
      moments[j] = moment;
    }
    return pinForce;
  }

 private:
  struct Swept {
    Body<Real> of;
    Turned<Real> at;
    // U and ε; over D but for held joints. J/D of rotors, D0 of held joints.
    Vec2<Real> U;
    Real epsilon, held, D0;
  };
  std::vector<Swept> bodies_;
};

}  // namespace planar_chain
