#pragma once

/// (s·1 − J)⁻¹ of the chain with all its effects, for the stiff methods: the recursion of linearized.h, link
/// by link or in segments, and the rows of the works W = (W_s, W_d), which nothing depends on,
///
///     s x_W = rhs_W + the change of the powers along (u, v)

#include <complex>
#include <optional>
#include <vector>

#include "dynamics/mechanism.h"
#include "effects/effects.h"
#include "lanes/linearized_segments.h"
#include "ode/system.h"
#include "simd/cache_lines.h"

namespace planar_chain {

class ExactSolve {
 public:
  /// k and d: of the joints. All must outlive this object. Allocates; of the rest only reserve() does.
  ExactSolve(const Mechanism& mechanism, Effects& effects, const std::vector<double>& k,
             const std::vector<double>& d);

  /// Takes k and d again, after every switch.
  void takeStiffness() { setJoints(k_, d_); }
  /// Linearizes at the state y with the derivative dydt, both in lane order. outside: e, and F where forces
  /// act, of this state.
  void linearize(double t, const double* y, const double* dydt, const Outside& outside);
  /// The state of the last linearize(), in chain order. Only where an effect has power or acts with forces.
  const ChainState& state() const { return at_; }
  /// Finds the velocities of the inner pins that forces need.
  void findPinVelocities();

  ode::LinearCosts costs() const;
  /// s·1 − J, and x = (s·1 − J)⁻¹ rhs; see ode::LinearizedSystem.
  void factor(double s) { solver_.factor(s); }
  void solve(const double* rhs, double* x);
  void reserve(int complexCount);
  void factorComplex(int k, std::complex<double> s) { complexSolvers_[index(k)].factor(s); }
  void solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x);

 private:
  using Complex = std::complex<double>;
  /// s·1 − J, factored.
  template <class Scalar>
  struct Solver {
    LinearizedSegments<Scalar> inverse;
    Scalar s{};

    void factor(Scalar s_) {
      s = s_;
      inverse.factor(s_);
    }
    void solve(const Scalar* rhs, Scalar* x, int places) { inverse.solve(rhs, rhs + places, x, x + places); }
    /// The rows of the works, from the change of the powers.
    void solveWorks(const Scalar* rhs, Scalar supplied, Scalar dissipated, Scalar* x, int places) const {
      x[2 * places] = (rhs[2 * places] + supplied) / s;
      x[2 * places + 1] = (rhs[2 * places + 1] + dissipated) / s;
    }
  };

  /// Keeps what later calls need of the state, and takes what J has of it. Returns Σ X·F of the bodies in
  /// lane order, or nullptr where no force acts.
  const double* keep(double t, const double* y);
  void setJoints(const std::vector<double>& k, const std::vector<double>& d);
  /// How the powers change along (u, v), in lane order; and that of the effects that need chain order.
  Powers powersAlong(const double* uv) {
    Powers change;
    for (Effect* effect : effects_.activeInLanes()) {
      change += effect->powersAlongInLanes(omegaInLanes_.data(), uv + places_);
    }
    if (!stateAt_.empty()) change += powersAlongInOrder(uv);
    return change;
  }
  Powers powersAlongInOrder(const double* uv);

  const Mechanism& mechanism_;
  Effects& effects_;
  int n_, places_;
  bool hasPower_, isNonlinear_, keepsState_;
  Solver<double> solver_;
  std::vector<Solver<Complex>> complexSolvers_;

  // The state of the last linearize(): all of it in chain order; the rates in lane order.
  ChainState at_{};
  std::vector<double> stateAt_, omegaInLanes_;
  std::vector<Rotation<double>> eAt_;
  std::vector<Vec2d> pinVelocity_;

  const std::vector<double>&k_, &d_;
  std::vector<double> tangentK_, tangentD_, XF_, part_, inOrder_;
  CacheLines room_;
};

// Inline: for two links a call would cost as much as what it does.

inline void ExactSolve::linearize(double t, const double* y, const double* dydt, const Outside& outside) {
  // Forces keep their direction when a body turns, so their moments change.
  const double* XF = keepsState_ ? keep(t, y) : nullptr;
  const Vec2d* F = XF ? outside.F : nullptr;
  solver_.inverse.linearize(outside.e, y + places_, dydt + places_, F, XF);
}

inline void ExactSolve::solve(const double* rhs, double* x) {
  solver_.solve(rhs, x, places_);
  if (!hasPower_) return;
  const Powers change = powersAlong(x);
  solver_.solveWorks(rhs, change.supplied, change.dissipated, x, places_);
}

}  // namespace planar_chain
