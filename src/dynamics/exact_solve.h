#pragma once

/// (s·1 − J)⁻¹ of the chain with all its effects, for the stiff methods: the recursion of linearized.h, link
/// by link or in segments, and the rows of the works W = (W_s, W_d), which nothing depends on,
///
///     s x_W = rhs_W + the change of the powers along (u, v)

#include <complex>
#include <optional>
#include <variant>
#include <vector>

#include "dynamics/mechanism.h"
#include "effects/effects.h"
#include "lanes/linearized_segments.h"
#include "ode/system.h"
#include "recursion/linearized.h"
#include "simd/cache_lines.h"

namespace planar_chain {

class ExactSolve {
 public:
  /// Both must outlive this object. Allocates; of the rest only reserve() does.
  ExactSolve(const Mechanism& mechanism, Effects& effects);

  /// Takes k and d of the joints from the effects; after every switch.
  void findStiffness();
  /// Linearizes at the state y with the derivative dydt, both in lane order. outside: e, and F where forces
  /// act, of this state.
  void linearize(double t, const double* y, const double* dydt, const Outside& outside);
  /// The state of the last linearize(), in chain order. Only where an effect has power or acts with forces.
  const ChainState& state() const { return at_; }
  /// Finds the velocities of the inner pins that forces need.
  void findPinVelocities();

  ode::LinearCosts costs() const;
  /// s·1 − J, and x = (s·1 − J)⁻¹ rhs; see ode::LinearizedSystem.
  void factor(double s);
  void solve(const double* rhs, double* x);
  void reserve(int complexCount);
  void factorComplex(int k, std::complex<double> s);
  void solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x);

 private:
  template <class Scalar>
  using Solver = std::variant<Linearized<Scalar>, LinearizedSegments<Scalar>>;

  /// Keeps what later calls need of the state, and takes what J has of it. Returns Σ X·F of the bodies in
  /// lane order, or nullptr where no force acts.
  const double* keep(double t, const double* y);
  void setJoints(const std::vector<double>& k, const std::vector<double>& d);
  /// How the powers change along (u, v), in lane order; and that of the effects that need chain order.
  Powers powersAlong(const double* uv) {
    Powers change = effects_.powersAlongInLanes(omegaInLanes_.data(), uv + places_);
    if (!stateAt_.empty()) change += powersAlongInOrder(uv);
    return change;
  }
  Powers powersAlongInOrder(const double* uv);

  const Mechanism& mechanism_;
  Effects& effects_;
  int n_, places_;
  bool hasPower_, isNonlinear_, keepsState_;
  Solver<double> solver_;
  std::vector<Solver<std::complex<double>>> complexSolvers_;
  double s_ = 0;
  std::vector<std::complex<double>> complexS_;

  // The state of the last linearize(): all of it in chain order; the rates in lane order.
  ChainState at_{};
  std::vector<double> stateAt_, omegaInLanes_;
  std::vector<Rotation<double>> eAt_;
  std::vector<Vec2d> pinVelocity_;

  std::vector<double> k_, d_, tangentK_, tangentD_, XF_, part_, inOrder_;
  CacheLines room_;
};

// Inline: for two links a call would cost as much as what it does.

inline void ExactSolve::linearize(double t, const double* y, const double* dydt, const Outside& outside) {
  // Forces keep their direction when a body turns, so their moments change.
  const double* XF = keepsState_ ? keep(t, y) : nullptr;
  const Vec2d* F = XF ? outside.F : nullptr;
  std::visit([&](auto& solver) { solver.linearize(outside.e, y + places_, dydt + places_, F, XF); }, solver_);
}

inline void ExactSolve::factor(double s) {
  s_ = s;
  std::visit([s](auto& solver) { solver.factor(s); }, solver_);
}

inline void ExactSolve::solve(const double* rhs, double* x) {
  std::visit([&](auto& solver) { solver.solve(rhs, rhs + places_, x, x + places_); }, solver_);
  if (!hasPower_) return;
  const Powers change = powersAlong(x);
  x[2 * places_] = (rhs[2 * places_] + change.supplied) / s_;
  x[2 * places_ + 1] = (rhs[2 * places_ + 1] + change.dissipated) / s_;
}

}  // namespace planar_chain
