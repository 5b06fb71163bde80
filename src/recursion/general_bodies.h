#pragma once

/// The state at which the exact solve of general_linearized.h linearizes a chain, and its bodies there.

#include <vector>

#include "planar_chain/chain.h"
#include "recursion/general.h"
#include "recursion/linearized.h"
#include "recursion/tip_constraint.h"

namespace planar_chain {

/// The state to linearize at, n values each; XF and F may be nullptr. They outlive the solve.
struct GeneralState {
  const Rotation<double>* e;
  const double* omega;                    ///< of the bodies, against the ground
  const double *rates, *xdd;              ///< of the coordinates; xdd: angles against the ground
  const Displacement<double>* displaced;  ///< of prismatic joints
  const Vec2d* F;
  const double* XF;  ///< of the bodies behind revolute joints
  const double *k, *d;
  const JointLaw<double>* joints;
  Vec2d base;              ///< acceleration of the base's pin less gravity, m/s²
  double baseTurning = 0;  ///< rad/s²
  Vec2d tipForce{};        ///< λ, N; it is not in F and XF
  Tip<double> tip{};       ///< the rows that act; their acceleration is not read
};

/// A prismatic joint.
struct PrismaticAt {
  Vec2d axis, S;                      ///< direction, and displacement, m
  Vec2d force;                        ///< on its body and all outside, at the body's own point, N
  double rate = 0, acceleration = 0;  ///< ṡ, s̈
};

/// The bodies at that state.
class GeneralBodies {
 public:
  explicit GeneralBodies(const Chain& chain)
      : chain_(chain),
        coordinates_(chain.coordinates()),
        at_(index(chain.size())),
        prismatic_(coordinates_.anyIsPrismatic() ? at_.size() : 0),
        forces_(at_.size()) {}

  /// Allocates nothing.
  void take(const GeneralState& state) {
    joints_ = state.joints;
    tip_ = state.tip;
    const std::size_t mixed = coordinates_.anyIsInside() ? size() : index(coordinates_.leading());
    Moved<double> moved{state.base, state.baseTurning};
    takeOutwards<true>(state, 0, mixed, moved);
    takeOutwards<false>(state, mixed, size(), moved);
    Vec2d outer = -1.0 * state.tipForce;
    takeInwards<false>(state, mixed, size(), outer);
    takeInwards<true>(state, 0, mixed, outer);
  }

  std::size_t size() const { return at_.size(); }
  const BodyAt<double>& operator[](std::size_t j) const { return at_[j]; }
  /// Joint j, if it is prismatic.
  const PrismaticAt& prismatic(std::size_t j) const { return prismatic_[j]; }
  const JointLaw<double>& joint(std::size_t j) const { return joints_[j]; }
  bool isPrismatic(std::size_t j) const { return coordinates_.isPrismatic(static_cast<int>(j)); }
  const Coordinates& coordinates() const { return coordinates_; }
  const Tip<double>& tip() const { return tip_; }

 private:
  /// Bodies first … end − 1. isMixed: a joint may be prismatic.
  template <bool isMixed>
  void takeOutwards(const GeneralState& state, std::size_t first, std::size_t end, Moved<double>& moved) {
    for (std::size_t j = first; j < end; ++j) {
      const Link& link = chain_.links()[j];
      BodyAt<double>& body = at_[j];
      body.m = link.mass;
      body.R = state.e[j] * link.com;
      body.P = state.e[j] * link.pin;
      body.J = link.inertia + body.m * dot(body.R, body.R);
      body.omega = state.omega[j];
      body.k = state.k[j];
      body.d = state.d[j];
      if (isMixed && isPrismatic(j)) {
        const auto& [d, S, gamma] = state.displaced[j];
        prismatic_[j] = {d, S, {}, state.rates[j], state.xdd[j]};
        moved.a = mulAdd(moved.alpha, perp(S), moved.a + gamma) + state.xdd[j] * d;
      } else {
        moved.alpha = state.xdd[j];
      }
      body.alpha = moved.alpha;
      body.kappa = -body.m * dot(body.R, moved.a);
      forces_[j] = body.m * accelerationAt(body, moved.a, body.R);
      moved.a = accelerationAt(body, moved.a, body.P);
    }
  }
  template <bool isMixed>
  void takeInwards(const GeneralState& state, std::size_t first, std::size_t end, Vec2d& outer) {
    for (std::size_t j = end; j-- > first;) {
      const bool isAxial = isMixed && isPrismatic(j);
      at_[j].kappa -= dot(at_[j].P, outer);
      if (state.XF && !isAxial) at_[j].kappa += state.XF[j];
      outer += forces_[j];
      if (state.F) outer -= state.F[j];
      if (isAxial) prismatic_[j].force = outer;
    }
  }

  const Chain& chain_;
  const Coordinates& coordinates_;
  std::vector<BodyAt<double>> at_;
  std::vector<PrismaticAt> prismatic_;  ///< none if all joints are revolute
  std::vector<Vec2d> forces_;
  const JointLaw<double>* joints_ = nullptr;
  Tip<double> tip_;
};

}  // namespace planar_chain
