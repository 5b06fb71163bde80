#pragma once

/// Forward dynamics in O(n): articulated bodies in the plane. The road that runs.
///
/// A pin passes a force but no moment that depends on the motion, so all that hangs on a pin shows it a
/// symmetric 2×2 "articulated mass" A and a bias force b:  F_pin = A a_pin + b.  With e_j = exp(i θ_j),
/// R = e r, P = e p, and N the moment about the inner pin of everything but pins and inertia
/// (N_j = M_j + τ_j − τ_{j+1} + X×F), inwards from the tip, where A = 0 and b = 0:
///
///     U = m iR + A iP
///     D = I + m|R|² + iP·(A iP)         (|R| as it comes out rounded, not |r|: then A cancels better)
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

/// What a body shows on the way in and needs on the way out.
template <class Real>
struct Handle {
  Vec2<Real> U;
  Real u, inverseD;
};

/// One body inwards: (A, b) of all that hangs on its outer pin become those of all that hangs on its inner
/// one, but for outer forces on the body itself. ww = ω².
template <class Real>
inline Handle<Real> inwards(const Body<Real>& body, Vec2<Real> R, Vec2<Real> P, Real ww, Real N,
                            Sym2<Real>& A, Vec2<Real>& b) {
  const Vec2<Real> AiP = A * perp(P);
  const Vec2<Real> U = body.m * perp(R) + AiP;
  const Real inverseD = Real(1) / (body.I + body.m * dot(R, R) + dot(perp(P), AiP));
  const Vec2<Real> beta = b - ww * (A * P);
  const Real u = N - dot(perp(P), beta);

  const Vec2<Real> UD = inverseD * U;
  A = {body.m + A.xx - U.x * UD.x, A.xy - U.x * UD.y, body.m + A.yy - U.y * UD.y};
  b = beta - (ww * body.m) * R + u * UD;
  return {U, u, inverseD};
}

template <class Real = double>
class Articulated {
 public:
  explicit Articulated(const Chain& chain) : handles_(static_cast<std::size_t>(chain.size())) {
    for (const Link& link : chain.links()) {
      bodies_.push_back({Real(link.mass),
                         Real(link.inertia),
                         {Real(link.com.x), Real(link.com.y)},
                         {Real(link.pin.x), Real(link.pin.y)}});
    }
  }

  int size() const { return static_cast<int>(bodies_.size()); }

  /// e: exp(i θ_j); omega: ω_j, rad/s; N: N m; F: outer forces without gravity, N, ground components, or
  /// nullptr where there are none; alpha: the result, rad/s². Each of size n. ground: acceleration of the
  /// ground pin less gravity, m/s². Allocates nothing.
  void accelerations(const Rotation<Real>* e, const Real* omega, const Real* N, const Vec2<Real>* F,
                     Vec2<Real> ground, Real* alpha) {
    Sym2<Real> A;
    Vec2<Real> b;
    for (int j = size() - 1; j >= 0; --j) {
      const Body<Real>& body = bodies_[index(j)];
      handles_[index(j)] = inwards(body, e[j] * body.r, e[j] * body.p, omega[j] * omega[j], N[j], A, b);
      if (F) b -= F[j];
    }
    Vec2<Real> a = ground;
    for (int j = 0; j < size(); ++j) {
      const Handle<Real>& handle = handles_[index(j)];
      const Vec2<Real> P = e[j] * bodies_[index(j)].p;
      alpha[j] = (handle.u - dot(handle.U, a)) * handle.inverseD;
      a += alpha[j] * perp(P) - (omega[j] * omega[j]) * P;
    }
  }

 private:
  static std::size_t index(int j) { return static_cast<std::size_t>(j); }

  std::vector<Body<Real>> bodies_;
  std::vector<Handle<Real>> handles_;
};

}  // namespace planar_chain
