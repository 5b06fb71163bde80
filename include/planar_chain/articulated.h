#pragma once

/// Forward dynamics in O(n): articulated bodies in the plane. The road that runs.
///
/// A pin passes a force but no moment that depends on the motion, so all that hangs on a pin shows it a
/// symmetric 2×2 "articulated mass" A and a bias force b:  F_pin = A a_pin + b.  With e_j = exp(i θ_j),
/// R = e r, P = e p, and N the moment about the inner pin of everything but pins and inertia
/// (N_j = M_j + τ_j − τ_{j+1} + X×F), inwards from the tip, where A = 0 and b = 0:
///
///     U = m iR + A iP
///     D = I + m|R|² + iP·(A iP)
///     β = b − ω² A P
///     u = N − iP·β
///     A ← m·1 + A − U Uᵀ/D
///     b ← β − F − ω² m R + U u/D
///
/// and outwards from the ground, a = −g (gravity is an acceleration of the frame, so F holds none):
///
///     α = (u − U·a)/D        a ← a + iα P − ω² P
///
/// Source: R. Featherstone, Rigid Body Dynamics Algorithms (2008), ch. 7, reduced to planar pins; the
/// reduction drops the rotation from the handle, which leaves 2×2 matrices and one division a link.
/// Templated on the number type: tests run it in long double.

#include <vector>

#include "planar_chain/chain.h"
#include "planar_chain/planar.h"

namespace planar_chain {

/// What the recursion needs of one body.
template <class Real>
struct Body {
  Real m, I;
  Vec2<Real> r, p;
};

template <class Real = double>
class Articulated {
 public:
  explicit Articulated(const Chain& chain)
      : bodies_(static_cast<std::size_t>(chain.size())), handles_(static_cast<std::size_t>(chain.size())) {
    for (std::size_t j = 0; j < bodies_.size(); ++j) {
      const Link& link = chain.links()[j];
      bodies_[j] = {Real(link.mass),
                    Real(link.inertia),
                    {Real(link.com.x), Real(link.com.y)},
                    {Real(link.pin.x), Real(link.pin.y)}};
    }
  }

  int size() const { return static_cast<int>(bodies_.size()); }

  /// e: exp(i θ_j); omega: ω_j, rad/s; N: N m; F: outer forces without gravity, N, ground components, or
  /// nullptr where there are none; alpha: the result, rad/s². Each of size n. ground: acceleration of the
  /// ground pin less gravity, m/s². Allocates nothing.
  void accelerations(const Rotation<Real>* e, const Real* omega, const Real* N, const Vec2<Real>* F,
                     Vec2<Real> ground, Real* alpha) {
    if (F) {
      inwards<true>(e, omega, N, F);
    } else {
      inwards<false>(e, omega, N, F);
    }
    outwards(e, omega, ground, alpha);
  }

 private:
  /// What a body shows on the way in and needs on the way out.
  struct Handle {
    Vec2<Real> U;
    Real u, D;
  };

  template <bool hasForces>
  void inwards(const Rotation<Real>* e, const Real* omega, const Real* N, const Vec2<Real>* F) {
    Sym2<Real> A;
    Vec2<Real> b;
    for (int j = size() - 1; j >= 0; --j) {
      const Body<Real>& body = bodies_[static_cast<std::size_t>(j)];
      const Real m = body.m;
      const Real ww = omega[j] * omega[j];
      const Vec2<Real> R = e[j] * body.r;
      const Vec2<Real> P = e[j] * body.p;

      const Vec2<Real> AiP = A * perp(P);
      const Vec2<Real> U = m * perp(R) + AiP;
      const Real D = body.I + m * dot(R, R) + dot(perp(P), AiP);
      const Vec2<Real> beta = b - ww * (A * P);
      const Real u = N[j] - dot(perp(P), beta);

      const Real xD = U.x / D;
      const Real yD = U.y / D;
      A = {m + A.xx - U.x * xD, A.xy - U.x * yD, m + A.yy - U.y * yD};
      b = beta - (ww * m) * R + Vec2<Real>{u * xD, u * yD};
      if constexpr (hasForces) b -= F[j];
      handles_[static_cast<std::size_t>(j)] = {U, u, D};
    }
  }

  void outwards(const Rotation<Real>* e, const Real* omega, Vec2<Real> a, Real* alpha) const {
    for (int j = 0; j < size(); ++j) {
      const Handle& handle = handles_[static_cast<std::size_t>(j)];
      const Vec2<Real> P = e[j] * bodies_[static_cast<std::size_t>(j)].p;
      alpha[j] = (handle.u - dot(handle.U, a)) / handle.D;
      a += alpha[j] * perp(P) - (omega[j] * omega[j]) * P;
    }
  }

  std::vector<Body<Real>> bodies_;
  std::vector<Handle> handles_;
};

}  // namespace planar_chain
