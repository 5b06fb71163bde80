#pragma once

/// The exact linear solve of linearized.h for a chain with coupled joints (coupled.h). A rotor is one more
/// term of the joint's spring, and a held joint is its limit:
///
///     rotor    k̂ = k + s d + s² J         δ also + J (ρ_v,i − ρ_v,i−1)
///     held     k̂ → ∞:   B ← m·1 + B     h ← U_R     p ← U_L     q ← D_m
///              u' = u'_parent + w,   w = (ρ_v,i − ρ_v,i−1)/s²,   b ← b − E_v ρ_v − E_q σ + U_R w,   r ← D_m
///              w − ε
///
/// The moment of a joint changes by δμ = q u'_parent + p·δa + r with (p, q, r) of its inner pin, and the
/// force of the base by b of the first body. They give the changes of the powers.

#include <complex>
#include <memory>
#include <vector>

#include "recursion/coupled.h"
#include "recursion/linearized.h"

namespace planar_chain {

/// The state to linearize at, n values each; XF and F may be nullptr. They outlive the solve.
struct CoupledState {
  const Rotation<double>* e;
  const double *omega, *alpha;  ///< of the bodies, against the ground
  const Vec2d* F;
  const double* XF;
  const double *k, *d;
  const Coupling<double>* joints;
  Vec2d ground;  ///< acceleration of the first pin less gravity, m/s²
  Vec2d tip{};   ///< λ, the force on the tip (ended.h), N; it is not in F and XF
};

/// The bodies at that state.
class CoupledBodies {
 public:
  explicit CoupledBodies(const Chain& chain) : chain_(chain), at_(index(chain.size())), forces_(at_.size()) {}

  /// Allocates nothing.
  void take(const CoupledState& state) {
    joints_ = state.joints;
    Vec2d a = state.ground;
    for (std::size_t j = 0; j < at_.size(); ++j) {
      const Link& link = chain_.links()[j];
      BodyAt<double>& body = at_[j];
      body.m = link.mass;
      body.R = state.e[j] * link.com;
      body.P = state.e[j] * link.pin;
      body.J = link.inertia + body.m * dot(body.R, body.R);
      body.omega = state.omega[j];
      body.alpha = state.alpha[j];
      body.k = state.k[j];
      body.d = state.d[j];
      body.kappa = -body.m * dot(body.R, a);
      forces_[j] = body.m * accelerationAt(body, a, body.R);
      a = accelerationAt(body, a, body.P);
    }
    Vec2d outer = -1.0 * state.tip;
    for (std::size_t j = at_.size(); j-- > 0;) {
      at_[j].kappa -= dot(at_[j].P, outer);
      if (state.XF) at_[j].kappa += state.XF[j];
      outer += forces_[j];
      if (state.F) outer -= state.F[j];
    }
  }

  std::size_t size() const { return at_.size(); }
  const BodyAt<double>& operator[](std::size_t j) const { return at_[j]; }
  const Coupling<double>& joint(std::size_t j) const { return joints_[j]; }

 private:
  const Chain& chain_;
  std::vector<BodyAt<double>> at_;
  std::vector<Vec2d> forces_;
  const Coupling<double>* joints_ = nullptr;
};

template <class Scalar>
class CoupledLinearized {
 public:
  /// bodies must outlive this object.
  explicit CoupledLinearized(const CoupledBodies& bodies)
      : bodies_(bodies), handles_(bodies.size()), moments_(bodies.size()) {}

  /// Factors s·1 − J. Allocates nothing.
  void factor(Scalar s) {
    s_ = s;
    Shown<Scalar> shown;
    for (std::size_t j = bodies_.size(); j-- > 0;) eliminate(j, shown);
  }

  /// [u; v] = (s·1 − J)⁻¹ [ρ_q; ρ_v]; n values each, and the results may stand in the same place. Allocates
  /// nothing.
  void solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) {
    Vec2<Scalar> b;
    Scalar r{};
    for (std::size_t j = bodies_.size(); j-- > 0;) {
      const BodyAt<double>& body = bodies_[j];
      Handle& handle = handles_[j];
      const Scalar sigma = rhoQ[j] / s_;
      const Scalar bend = j > 0 ? sigma - rhoQ[j - 1] / s_ : sigma;
      const Scalar jump = j > 0 ? rhoV[j] - rhoV[j - 1] : rhoV[j];
      const bool isHeld = bodies_.joint(j).isHeld;
      const Scalar delta = isHeld ? Scalar{} : bodies_.joint(j).rotor * jump - body.k * bend;
      const Scalar epsilon = handle.Mv * rhoV[j] + handle.Mq * sigma + delta - dotMixed(perp(body.P), b) - r;
      const Scalar turn = isHeld ? jump / (s_ * s_) : epsilon * handle.over;
      b = mulAdd(turn, handle.UR, mulAdd(-rhoV[j], handle.Ev, mulAdd(-sigma, handle.Eq, b)));
      r = isHeld ? handle.Dm * turn - epsilon : delta - handle.kD * epsilon;
      handle.turn = turn;
      moments_[j] = r;
    }
    pinForce_ = b;

    Vec2<Scalar> da;
    Scalar parent{};
    for (std::size_t j = 0; j < bodies_.size(); ++j) {
      const BodyAt<double>& body = bodies_[j];
      const Handle& handle = handles_[j];
      const Scalar sigma = rhoQ[j] / s_;
      moments_[j] += handle.q * parent + handle.p.x * da.x + handle.p.y * da.y;
      parent = handle.kD * parent + handle.turn - handle.ULD.x * da.x - handle.ULD.y * da.y;
      da = mulAdd(parent, turnScale(turnOf(body, s_), body.P),
                  da + turnScale(driftOf(body, sigma, rhoV[j]), body.P));
      u[j] = sigma + parent;
      v[j] = s_ * parent;
    }
  }

  /// The changes of the joints' moments and of the force of the base along the last solution.
  const std::vector<Scalar>& moments() const { return moments_; }
  Vec2<Scalar> pinForce() const { return pinForce_; }

 private:
  struct Handle {
    Scalar Mv, Mq, Dm, over, kD;  ///< over: 1/D; kD: k̂/D; 0 and 1 for a held joint
    Vec2<Scalar> Ev, Eq, UR, ULD, p;
    Scalar q, turn;  ///< turn: ε/D, or w
  };

  void eliminate(std::size_t j, Shown<Scalar>& shown) {
    const BodyAt<double>& body = bodies_[j];
    const Coupling<double>& joint = bodies_.joint(j);
    const auto [x, y] = turnOf(body, s_);
    const Vec2d P = body.P, iP = perp(P);
    const Matrix2<Scalar> B = shown.B;
    const Vec2<Scalar> lambda{iP.x * B.xx + iP.y * B.yx + shown.p.x, iP.x * B.xy + iP.y * B.yy + shown.p.y};
    const Scalar alongTurn = dotMixed(iP, lambda), alongPin = dotMixed(P, lambda);
    const double ww = body.omega * body.omega;
    Handle& handle = handles_[j];
    handle.Ev = B.times(iP, {Scalar(-body.m * body.R.y), Scalar(body.m * body.R.x)});
    const Vec2<Scalar> Ed = B.times(P, {Scalar(body.m * body.R.x), Scalar(body.m * body.R.y)});
    handle.Mv = body.J + alongTurn;
    handle.Mq = ww * alongTurn + body.alpha * alongPin - body.kappa;
    handle.Eq = {ww * handle.Ev.x + body.alpha * Ed.x, ww * handle.Ev.y + body.alpha * Ed.y};
    handle.UR = mulAdd(y, handle.Ev, mulAdd(x, Ed, shown.h));
    const Vec2<Scalar> UL = mulAdd(body.m, perp(body.R), lambda);
    handle.Dm =
        body.J * s_ * s_ + body.kappa + shown.q + dotMixed(iP, shown.h) + y * alongTurn + x * alongPin;
    const Scalar k = body.k + s_ * (body.d + s_ * joint.rotor);
    handle.over = joint.isHeld ? Scalar{} : 1.0 / (handle.Dm + k);
    handle.kD = joint.isHeld ? Scalar(1) : k * handle.over;
    handle.ULD = handle.over * UL;

    const Vec2<Scalar>&UR = handle.UR, &ULD = handle.ULD;
    shown.B = {body.m + B.xx - UR.x * ULD.x, B.xy - UR.x * ULD.y, B.yx - UR.y * ULD.x,
               body.m + B.yy - UR.y * ULD.y};
    shown.h = handle.kD * UR;
    shown.p = handle.p = handle.kD * UL;
    shown.q = handle.q = handle.kD * handle.Dm;
  }

  const CoupledBodies& bodies_;
  Scalar s_{};
  std::vector<Handle> handles_;
  std::vector<Scalar> moments_;
  Vec2<Scalar> pinForce_;
};

}  // namespace planar_chain
