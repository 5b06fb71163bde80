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
///     ε   = (I + m|R|²) ρ_v − κ σ + δ − iP·b + (m iR − U_L)·(wP) − r     δ = −k (σ_j − σ_{j−1})
///     b ← m wR + B wP + b + U_R ε/D     r ← δ − k̂ ε/D
///
/// and outwards:  u' = (k̂ u'_parent + ε − U_L·δa)/D     δa ← δa + u' zP + wP.
///
/// (U_L − m iR)·(wP) is iP·(B wP) + p·(wP): so p need not be kept.
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
template <class Scalar, class Real>
Vec2<Scalar> turnScale(Vec2<Scalar> z, Vec2<Real> P) {
  return {mulAdd(P.x, z.x, -P.y * z.y), mulAdd(P.y, z.x, P.x * z.y)};
}

template <class Scalar, class Real>
Scalar dotMixed(Vec2<Real> a, Vec2<Scalar> b) {
  return mulAdd(a.x, b.x, a.y * b.y);
}

/// A 2×2 matrix without symmetry.
template <class Scalar>
struct Matrix2 {
  Scalar xx{}, xy{}, yx{}, yy{};
};

/// A body in the state at which the chain is linearized.
template <class Real>
struct BodyAt {
  Real m, J, omega, alpha, kappa, k, d;
  Vec2<Real> R, P;
};

/// What hangs on a pin, as its parent feels it.
template <class Scalar>
struct Shown {
  Matrix2<Scalar> B;
  Vec2<Scalar> h, p;
  Scalar q{};
};

/// What the factorization keeps of a body: its outer neighbour's B, and its own.
template <class Scalar>
struct LinearHandle {
  Matrix2<Scalar> B;
  Vec2<Scalar> UR, zP, ULD;  ///< ULD: U_L/D
  Scalar inverseD, k, kD;    ///< k: k̂; kD: k̂/D
};

/// What the way in keeps of a body for the way out.
template <class Scalar>
struct Sweep {
  Vec2<Scalar> wP;
  Scalar epsilonD;  ///< ε/D
};

/// k̂
template <class Scalar, class Real>
Scalar stiffness(const BodyAt<Real>& body, Scalar s) {
  return mulAdd(s, body.d, Scalar(body.k));
}

/// One body inwards, for the factorization of s·1 − J.
template <class Scalar, class Real>
LinearHandle<Scalar> eliminate(const BodyAt<Real>& body, Scalar s, Shown<Scalar>& shown) {
  const Vec2<Scalar> z{Real(-2) * body.omega * s - body.alpha, s * s - body.omega * body.omega};
  const Vec2<Scalar> zR = turnScale(z, body.R);
  const Vec2<Scalar> zP = turnScale(z, body.P);
  const Vec2<Real> iP = perp(body.P);
  const Scalar k = stiffness(body, s);
  const Matrix2<Scalar>& B = shown.B;

  const Vec2<Scalar> BzPh{mulAdd(B.xx, zP.x, mulAdd(B.xy, zP.y, shown.h.x)),
                          mulAdd(B.yx, zP.x, mulAdd(B.yy, zP.y, shown.h.y))};
  const Vec2<Scalar> UR = mulAdd(body.m, zR, BzPh);
  const Vec2<Scalar> miRp = mulAdd(body.m, perp(body.R), shown.p);
  const Vec2<Scalar> UL{mulAdd(iP.x, B.xx, mulAdd(iP.y, B.yx, miRp.x)),
                        mulAdd(iP.x, B.xy, mulAdd(iP.y, B.yy, miRp.y))};
  const Scalar Dm = mulAdd(body.J, s * s, body.kappa + shown.q) + dotMixed(iP, BzPh) + dot(shown.p, zP);
  const Scalar inverseD = Real(1) / (Dm + k);
  const Scalar kD = k * inverseD;
  const Vec2<Scalar> ULD = inverseD * UL;
  const LinearHandle<Scalar> handle{B, UR, zP, ULD, inverseD, k, kD};
  shown.B = {mulAdd(-UR.x, ULD.x, body.m + B.xx), mulAdd(-UR.x, ULD.y, B.xy), mulAdd(-UR.y, ULD.x, B.yx),
             mulAdd(-UR.y, ULD.y, body.m + B.yy)};
  shown.h = kD * UR;
  shown.p = k * ULD;
  shown.q = kD * Dm;
  return handle;
}

/// One body inwards, for a right-hand side: b and r of what hangs on its outer pin become those of what hangs
/// on its inner one. bend: σ less that of the parent.
template <class Scalar, class Real>
Sweep<Scalar> carry(const BodyAt<Real>& body, const LinearHandle<Scalar>& handle, Scalar sigma, Scalar bend,
                    Scalar rhoV, Vec2<Scalar>& b, Scalar& r) {
  const Vec2<Scalar> w{-(body.alpha * sigma), -rhoV - body.omega * body.omega * sigma};
  const Vec2<Scalar> wR = turnScale(w, body.R);
  const Vec2<Scalar> wP = turnScale(w, body.P);
  const Scalar delta = -(body.k * bend);
  const Scalar own = mulAdd(body.J, rhoV, mulAdd(-body.kappa, sigma, delta - r)) - dotMixed(perp(body.P), b) +
                     body.m * dotMixed(perp(body.R), wP);
  const Scalar eD = own * handle.inverseD - dot(handle.ULD, wP);
  const Vec2<Scalar> BwPb{mulAdd(handle.B.xx, wP.x, mulAdd(handle.B.xy, wP.y, b.x)),
                          mulAdd(handle.B.yx, wP.x, mulAdd(handle.B.yy, wP.y, b.y))};
  b = mulAdd(eD, handle.UR, mulAdd(body.m, wR, BwPb));
  r = delta - handle.k * eD;
  return {wP, eD};
}

/// The real numbers below those of a solve.
template <class Scalar>
struct RealOf {
  using type = Scalar;
};
template <class Real>
struct RealOf<std::complex<Real>> {
  using type = Real;
};

template <class Scalar = double>
class Linearized {
 public:
  using Real = typename RealOf<Scalar>::type;

  explicit Linearized(const Chain& chain)
      : n_(chain.size()),
        chain_(chain),
        shared_(std::make_shared<std::vector<BodyAt<Real>>>(static_cast<std::size_t>(n_))),
        bodies_(*shared_),
        forces_(static_cast<std::size_t>(n_)),
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

  /// k (N m/rad), d (N m s/rad) of each joint, with whatever acts like a spring or damper there; 0 before. n
  /// values each. Allocates nothing.
  void setJoints(const double* k, const double* d) {
    for (int j = 0; j < n_; ++j) {
      bodies_[index(j)].k = k[j];
      bodies_[index(j)].d = d[j];
    }
  }

  /// The state to linearize at: e = exp(i θ_j), ω (rad/s), α (rad/s²), and what acts: F (N) outer forces
  /// without gravity and XF = Σ X·F (N m) of each body, both nullptr where there are none. n values each.
  /// Allocates nothing.
  void linearize(const Rotation<double>* e, const double* omega, const double* alpha, const Vec2d* F,
                 const double* XF) {
    const auto wide = [](Vec2d a) { return Vec2<Real>{Real(a.x), Real(a.y)}; };
    Vec2<Real> a = wide(-1.0 * chain_.gravity());
    for (int j = 0; j < n_; ++j) {
      const Link& link = chain_.links()[index(j)];
      const Rotation<Real> turn{Real(e[j].c), Real(e[j].s)};
      BodyAt<Real>& body = bodies_[index(j)];
      body.m = link.mass;
      body.R = turn * wide(link.com);
      body.P = turn * wide(link.pin);
      body.J = link.inertia + body.m * dot(body.R, body.R);
      body.omega = omega[j];
      body.alpha = alpha[j];
      const Real ww = body.omega * body.omega;
      body.kappa = -body.m * dot(body.R, a);
      forces_[index(j)] = body.m * (a + body.alpha * perp(body.R) - ww * body.R);
      a += body.alpha * perp(body.P) - ww * body.P;
    }
    Vec2<Real> outer;
    for (int j = n_ - 1; j >= 0; --j) {
      BodyAt<Real>& body = bodies_[index(j)];
      body.kappa -= dot(body.P, outer);
      if (XF) body.kappa += XF[j];
      outer += forces_[index(j)];
      if (F) outer -= wide(F[j]);
    }
  }

  /// Factors s·1 − J at the state of the last linearize(). Allocates nothing.
  void factor(Scalar s) {
    s_ = s;
    Shown<Scalar> shown;
    for (int j = n_ - 1; j >= 0; --j) handles_[index(j)] = eliminate(bodies_[index(j)], s, shown);
  }

  /// [u; v] = (s·1 − J)⁻¹ [ρ_q; ρ_v]; n values each, and the results may stand in the same place. Allocates
  /// nothing.
  void solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) {
    Vec2<Scalar> b;
    Scalar r{};
    for (int j = n_ - 1; j >= 0; --j) {
      const Scalar sigma = rhoQ[j] / s_;
      const Scalar bend = j > 0 ? sigma - rhoQ[j - 1] / s_ : sigma;
      sweeps_[index(j)] = carry(bodies_[index(j)], handles_[index(j)], sigma, bend, rhoV[j], b, r);
    }
    Vec2<Scalar> da;
    Scalar parent{};
    for (int j = 0; j < n_; ++j) {
      const LinearHandle<Scalar>& handle = handles_[index(j)];
      const Sweep<Scalar>& sweep = sweeps_[index(j)];
      parent = handle.kD * parent + sweep.epsilonD - dot(handle.ULD, da);
      da += parent * handle.zP + sweep.wP;
      u[j] = rhoQ[j] / s_ + parent;
      v[j] = s_ * parent;
    }
  }

 private:
  template <class Other>
  friend class Linearized;

  static std::size_t index(int j) { return static_cast<std::size_t>(j); }

  int n_;
  const Chain& chain_;
  Scalar s_{};
  std::shared_ptr<std::vector<BodyAt<Real>>> shared_;
  std::vector<BodyAt<Real>>& bodies_;
  std::vector<Vec2<Real>> forces_;  ///< m × acceleration of the centre of mass less gravity
  std::vector<LinearHandle<Scalar>> handles_;
  std::vector<Sweep<Scalar>> sweeps_;
};

}  // namespace planar_chain
