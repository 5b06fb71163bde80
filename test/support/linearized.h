#pragma once

/// The exact solve of recursion/linearized.h link by link, in any number type: what the kernels are compared
/// with.

#include <cmath>
#include <complex>
#include <memory>
#include <utility>
#include <vector>

#include "planar_chain/chain.h"
#include "recursion/linearized.h"

namespace planar_chain {

template <class Scalar = double>
class Linearized {
 public:
  using Real = decltype(std::abs(Scalar()));

  explicit Linearized(const Chain& chain)
      : Linearized(chain, std::make_shared<std::vector<BodyAt<Real>>>(index(chain.size()))) {}

  /// Another factorization at the state of `other`, whenever that is linearized.
  template <class Other>
  explicit Linearized(const Linearized<Other>& other) : Linearized(other.chain_, other.shared_) {}

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
      body.kappa = -body.m * dot(body.R, a);
      forces_[index(j)] = body.m * accelerationAt(body, a, body.R);
      a = accelerationAt(body, a, body.P);
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
    LinearArticulatedTerms<Scalar> articulated;
    for (int j = n_ - 1; j >= 0; --j) factors_[index(j)] = eliminate(bodies_[index(j)], s, articulated);
  }

  /// [u; v] = (s·1 − J)⁻¹ [ρ_q; ρ_v]; n values each, and the results may stand in the same place. Allocates
  /// nothing.
  void solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) {
    Vec2<Scalar> b;
    Scalar r{};
    for (int j = n_ - 1; j >= 0; --j) {
      const Scalar sigma = rhoQ[j] / s_;
      const Scalar relative = j > 0 ? sigma - rhoQ[j - 1] / s_ : sigma;
      epsilonD_[index(j)] = carry(bodies_[index(j)], factors_[index(j)], s_, sigma, relative, rhoV[j], b, r);
    }
    Moving<Scalar> moving;
    for (int j = 0; j < n_; ++j) {
      const Scalar sigma = rhoQ[j] / s_;
      moving.pass(bodies_[index(j)], factors_[index(j)], s_, sigma, rhoV[j], epsilonD_[index(j)]);
      u[j] = sigma + moving.parent;
      v[j] = s_ * moving.parent;
    }
  }

 private:
  template <class Other>
  friend class Linearized;

  Linearized(const Chain& chain, std::shared_ptr<std::vector<BodyAt<Real>>> shared)
      : n_(chain.size()),
        chain_(chain),
        shared_(std::move(shared)),
        bodies_(*shared_),
        forces_(index(n_)),
        factors_(index(n_)),
        epsilonD_(index(n_)) {}

  int n_;
  const Chain& chain_;
  Scalar s_{};
  std::shared_ptr<std::vector<BodyAt<Real>>> shared_;
  std::vector<BodyAt<Real>>& bodies_;
  std::vector<Vec2<Real>> forces_;  ///< m × acceleration of the centre of mass less gravity
  std::vector<LinearFactors<Scalar>> factors_;
  std::vector<Scalar> epsilonD_;
};

}  // namespace planar_chain
