#pragma once

/// The state at which the exact solve of coupled_linearized.h linearizes a chain, and its bodies there.

#include <vector>

#include "planar_chain/chain.h"
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

}  // namespace planar_chain
