#pragma once

/// The exact linear solve of implicit methods in O(n).
///
/// Implicit methods need (s·1 − J) [u; v] = [ρ_q; ρ_v] with J the full Jacobian of (θ̇, ω̇) = (ω, α(θ, ω)).
/// The upper half says v = s u − ρ_q. So that v is not left over from a subtraction, write u = σ + u' with
/// σ = ρ_q/s; then v = s u'. For the lower half the recursion of articulated.h is differentiated as it
/// stands, so geometric (tension) stiffness, Coriolis terms, springs and dampers are all in it, and nothing
/// is approximated. With δα = s² u' − ρ_v, a point P of body j has δ(acceleration) = (z u' + w) P, where
///
///     z = i (s² − ω²) − 2 ω s − α          w = −i ρ_v − (i ω² + α) σ
///
/// (products of complex numbers). The joint at the inner pin resists with k̂ = k + s d. What hangs on a pin
/// shows its parent, which moves by δa and turns by σ + u', the force B δa + h u' + b and the moment
/// p·δa + q u' + r. With a the acceleration of the inner pin less gravity, F_outer the force on the next body
/// at its pin, X·F summed over the loads, inwards:
///
///     κ   = X·F − R·(m a) − P·F_outer
///     U_R = m zR + B zP + h                U_L = m iR + Bᵀ iP + p
///     D_m = (I + m|R|²) s² + κ + q + iP·(B zP + h) + p·(zP)        D = D_m + k̂
///     B ← m·1 + B − U_R U_Lᵀ/D     h ← U_R k̂/D     p ← k̂ U_L/D     q ← k̂ D_m/D
///
///     ε   = (I + m|R|²) ρ_v − κ σ + δ − iP·(B wP + b) − p·(wP) − r       δ = −k (σ_j − σ_{j−1})
///     b ← m wR + B wP + b + U_R ε/D     r ← δ − k̂ ε/D
///
/// and outwards:  u' = (k̂ u'_parent + ε − U_L·δa)/D     δa ← δa + u' zP + wP.
///
/// q is not written k̂ − k̂²/D, which cancels for stiff springs. The handles are not symmetric, as J is not.
/// Everything is analytic in s, so Scalar may be complex.

#include <complex>
#include <memory>
#include <vector>

#include "planar_chain/chain.h"
#include "planar_chain/planar.h"

namespace planar_chain {

/// z·P, a product of complex numbers of the plane; z's parts may themselves be complex numbers.
template <class Scalar>
Vec2<Scalar> turnScale(Vec2<Scalar> z, Vec2d P) {
  return {z.x * P.x - z.y * P.y, z.x * P.y + z.y * P.x};
}

template <class Scalar>
Scalar dotMixed(Vec2d a, Vec2<Scalar> b) {
  return a.x * b.x + a.y * b.y;
}

/// A body in the state at which the chain is linearized.
struct BodyAt {
  double m, J, omega, alpha, kappa, k, d;
  Vec2d R, P;
  Vec2d force;  ///< m × acceleration of the centre of mass less gravity
};

template <class Scalar = double>
class Linearized {
 public:
  explicit Linearized(const Chain& chain)
      : n_(chain.size()),
        chain_(chain),
        shared_(std::make_shared<std::vector<BodyAt>>(static_cast<std::size_t>(n_))),
        bodies_(*shared_),
        handles_(static_cast<std::size_t>(n_)),
        sweeps_(static_cast<std::size_t>(n_)) {}

  /// Another factorization at the state of `other`, whenever that is linearized.
  template <class Other>
  explicit Linearized(const Linearized<Other>& other)
      : n_(other.n_),
        chain_(other.chain_),
        shared_(other.shared_),
        bodies_(*shared_),
        handles_(static_cast<std::size_t>(n_)),
        sweeps_(static_cast<std::size_t>(n_)) {}

  /// The state to linearize at: e = exp(i θ_j), ω (rad/s), α (rad/s²), and what acts: F (N) outer forces
  /// without gravity and XF = Σ X·F (N m) of each body, both nullptr where there are none. k, d: of each
  /// joint, with whatever acts like a spring or damper there. n values each. Allocates nothing.
  void linearize(const Rotation<double>* e, const double* omega, const double* alpha, const Vec2d* F,
                 const double* XF, const double* k, const double* d) {
    Vec2d a = -1.0 * chain_.gravity();
    for (int j = 0; j < n_; ++j) {
      const Link& link = chain_.links()[index(j)];
      BodyAt& body = bodies_[index(j)];
      body.m = link.mass;
      body.R = e[j] * link.com;
      body.P = e[j] * link.pin;
      body.J = link.inertia + link.mass * dot(body.R, body.R);
      body.omega = omega[j];
      body.alpha = alpha[j];
      body.k = k[j];
      body.d = d[j];
      const double ww = omega[j] * omega[j];
      body.kappa = -link.mass * dot(body.R, a);
      body.force = link.mass * (a + alpha[j] * perp(body.R) - ww * body.R);
      a += alpha[j] * perp(body.P) - ww * body.P;
    }
    Vec2d outer;
    for (int j = n_ - 1; j >= 0; --j) {
      BodyAt& body = bodies_[index(j)];
      body.kappa -= dot(body.P, outer);
      if (XF) body.kappa += XF[j];
      outer += body.force;
      if (F) outer -= F[j];
    }
  }

  /// Factors s·1 − J at the state of the last linearize(). Allocates nothing.
  void factor(Scalar s) {
    s_ = s;
    Matrix B;
    Vec2<Scalar> h, p;
    Scalar q{};
    for (int j = n_ - 1; j >= 0; --j) {
      const BodyAt& body = bodies_[index(j)];
      Handle& handle = handles_[index(j)];
      const Vec2<Scalar> z{-2.0 * body.omega * s - body.alpha, s * s - body.omega * body.omega};
      const Vec2<Scalar> zR = turnScale(z, body.R);
      const Vec2<Scalar> zP = turnScale(z, body.P);
      const Vec2d iP = perp(body.P);
      const Scalar k = body.k + s * body.d;

      const Vec2<Scalar> BzPh = B * zP + h;
      const Vec2<Scalar> UR = Vec2<Scalar>{body.m * zR.x, body.m * zR.y} + BzPh;
      const Vec2<Scalar> UL = transposedTimes(B, iP) + p +
                              Vec2<Scalar>{-body.m * body.R.y + Scalar{}, body.m * body.R.x + Scalar{}};
      const Scalar Dm = body.J * s * s + body.kappa + q + dotMixed(iP, BzPh) + dot(p, zP);
      const Scalar D = Dm + k;
      handle = {B, p, zP, UR, UL, D, k};

      const Scalar kD = k / D;
      const Scalar xD = UL.x / D, yD = UL.y / D;
      B = {body.m + B.xx - UR.x * xD, B.xy - UR.x * yD, B.yx - UR.y * xD, body.m + B.yy - UR.y * yD};
      h = kD * UR;
      p = kD * UL;
      q = kD * Dm;
    }
  }

  /// [u; v] = (s·1 − J)⁻¹ [ρ_q; ρ_v]; n values each, and the results may stand in the same place. Allocates
  /// nothing.
  void solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) {
    Vec2<Scalar> b;
    Scalar r{};
    for (int j = n_ - 1; j >= 0; --j) {
      const BodyAt& body = bodies_[index(j)];
      const Handle& handle = handles_[index(j)];
      Sweep& sweep = sweeps_[index(j)];
      const Scalar sigma = rhoQ[j] / s_;
      const Vec2<Scalar> w{-body.alpha * sigma, -rhoV[j] - body.omega * body.omega * sigma};
      const Vec2<Scalar> wR = turnScale(w, body.R);
      sweep.wP = turnScale(w, body.P);
      const Scalar delta = -body.k * (j > 0 ? sigma - rhoQ[j - 1] / s_ : sigma);
      const Vec2<Scalar> BwPb = handle.B * sweep.wP + b;
      sweep.epsilon = body.J * rhoV[j] - body.kappa * sigma + delta - dotMixed(perp(body.P), BwPb) -
                      dot(handle.p, sweep.wP) - r;
      const Scalar eD = sweep.epsilon / handle.D;
      b = Vec2<Scalar>{body.m * wR.x, body.m * wR.y} + BwPb + eD * handle.UR;
      r = delta - handle.k * eD;
    }
    Vec2<Scalar> da;
    Scalar parent{};
    for (int j = 0; j < n_; ++j) {
      const Handle& handle = handles_[index(j)];
      const Sweep& sweep = sweeps_[index(j)];
      parent = (handle.k * parent + sweep.epsilon - dot(handle.UL, da)) / handle.D;
      da += parent * handle.zP + sweep.wP;
      u[j] = rhoQ[j] / s_ + parent;
      v[j] = s_ * parent;
    }
  }

 private:
  template <class Other>
  friend class Linearized;

  static std::size_t index(int j) { return static_cast<std::size_t>(j); }

  /// A 2×2 matrix without symmetry.
  struct Matrix {
    Scalar xx{}, xy{}, yx{}, yy{};
    friend Vec2<Scalar> operator*(const Matrix& A, Vec2<Scalar> a) {
      return {A.xx * a.x + A.xy * a.y, A.yx * a.x + A.yy * a.y};
    }
  };
  static Vec2<Scalar> transposedTimes(const Matrix& A, Vec2d a) {
    return {A.xx * a.x + A.yx * a.y, A.xy * a.x + A.yy * a.y};
  }

  /// What the factorization keeps of a body: its neighbour's handle, and its own.
  struct Handle {
    Matrix B;
    Vec2<Scalar> p, zP, UR, UL;
    Scalar D, k;
  };
  struct Sweep {
    Vec2<Scalar> wP;
    Scalar epsilon;
  };

  int n_;
  const Chain& chain_;
  Scalar s_{};
  std::shared_ptr<std::vector<BodyAt>> shared_;
  std::vector<BodyAt>& bodies_;
  std::vector<Handle> handles_;
  std::vector<Sweep> sweeps_;
};

}  // namespace planar_chain
