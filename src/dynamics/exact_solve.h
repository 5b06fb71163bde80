#pragma once

/// (s·1 − J)⁻¹ of the chain with all its effects, for the stiff methods, by one of two recursions:
///
///     linearized.h            bare chains, link by link or in segments, in the order of the mechanism
///     general_linearized.h    all others
///
/// and the rows of the works W = (W_s, W_d), which nothing depends on,
///
///     s x_W = rhs_W + the change of the powers along (u, v)
///
/// The power of prescribed joints, and of a base that moves with v_base and turns at φ̇, changes by
/// Σ δμ_i q̇_i + δF_0·v_base + δM_0 φ̇ + δλ·v_tip.

#include <complex>
#include <memory>
#include <optional>
#include <vector>

#include "dynamics/effect_tangents.h"
#include "dynamics/evaluation.h"
#include "dynamics/motion_change.h"
#include "lanes/linearized_segments.h"
#include "ode/system.h"
#include "recursion/general_bodies.h"
#include "recursion/general_solve.h"
#include "simd/cache_lines.h"

namespace planar_chain {

class ExactSolve {
 public:
  /// isBare: false if linearize() takes evaluations. The others must outlive this object. Allocates; of the
  /// rest only reserve() does.
  ExactSolve(const Mechanism& mechanism, const Effects& effects, EffectTangents& tangents, bool isBare);

  ExactSolve(const ExactSolve&) = delete;  // its solvers have pointers into it
  ExactSolve& operator=(const ExactSolve&) = delete;

  /// Takes the constant stiffness again, after every switch.
  void takeStiffness();
  /// Linearizes at the state y with the derivative dydt, both in lane order. external: e, and F where forces
  /// act, of this state.
  void linearize(double t, const double* y, const double* dydt, const Loads& external);
  /// Linearizes at an evaluation, which is copied.
  void linearize(const Evaluation& at);
  /// The state of the last linearize(), in chain order. Only where an effect has power or acts with forces.
  const ChainState& state() const { return at_; }
  /// Finds the velocities of the inner pins that forces need.
  void findPinVelocities();
  /// Writes ∂ÿ/∂t at the last linearize() of an evaluation, and returns that of the powers.
  Powers timeDerivative(double* slopes);

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
    std::optional<LinearizedSegments<Scalar>> plain;
    std::unique_ptr<GeneralSolve<Scalar>> general;  ///< or this
    Scalar s{};

    void factor(Scalar s_) {
      s = s_;
      plain ? plain->factor(s_) : general->factor(s_);
    }
    void solve(const Scalar* rhs, Scalar* x, int paddedSize) {
      if (plain) return plain->solve(rhs, rhs + paddedSize, x, x + paddedSize);
      general->solve(rhs, rhs + paddedSize, x, x + paddedSize);
    }
    /// The rows of the works, from the change of the powers.
    void solveWorks(const Scalar* rhs, Scalar supplied, Scalar dissipated, Scalar* x, int paddedSize) const {
      x[2 * paddedSize] = (rhs[2 * paddedSize] + supplied) / s;
      x[2 * paddedSize + 1] = (rhs[2 * paddedSize + 1] + dissipated) / s;
    }
  };
  /// The state at which chains that are not bare are linearized.
  struct General {
    General(const Mechanism& mechanism, const Effects& effects)
        : bodies(mechanism.chain()),
          at(mechanism, effects),
          couplings(mechanism.size()),
          rates(mechanism.size()),
          change(mechanism) {}

    GeneralBodies bodies;
    Evaluation at;
    Couplings couplings, rates;
    MotionChange change;
  };

  template <class Scalar>
  Solver<Scalar> makeSolver() const;
  /// Keeps what later calls need of the state, and takes what J has of it. Returns Σ X·F of the bodies in
  /// lane order, or nullptr where no force acts.
  const double* keep(double t, const double* y);
  void setJoints(const std::vector<double>& k, const std::vector<double>& d);
  /// How the powers change along (u, v), in lane order; and that of the effects that need chain order.
  Powers powersAlong(const double* uv) {
    Powers change;
    for (InLanes* effect : effects_.activeInLanes()) {
      change += effect->powersAlongInLanes(omegaInLanes_.data(), uv + paddedSize_);
    }
    if (at_.theta) change += powersAlongInOrder(uv);
    return change;
  }
  Powers powersAlongInOrder(const double* uv);
  void movePins(const double* u, const double* v);
  /// Returns the power of prescribed joints and the base, along the last solution.
  template <class Scalar>
  Scalar couplingPowerAlong(const Solver<Scalar>& solver) const;
  const Vec2d* forces() const {
    return effects_.acting() == LoadKind::forces ? general_->at.F.data() : nullptr;
  }
  double firstTorque(double t);
  double firstTorqueRate();

  const Mechanism& mechanism_;
  const Effects& effects_;
  EffectTangents& tangents_;
  int n_, paddedSize_;
  bool hasPower_, isNonlinear_, hasForces_, keepsState_;
  bool isPlain_;  ///< one solver does it all
  std::optional<General> general_;
  Solver<double> solver_;
  std::vector<Solver<Complex>> complexSolvers_;

  // The state of the last linearize(): all of it in chain order; the rates in lane order.
  ChainState at_{};
  std::vector<double> stateAt_, omegaInLanes_;
  std::vector<Rotation<double>> eAt_;
  std::vector<Vec2d> pinVelocity_, pin_;

  std::vector<double> part_, inOrder_;
  CacheLines room_;
};

// Inline: for two links a call would cost as much as what it does.

inline void ExactSolve::linearize(double t, const double* y, const double* dydt, const Loads& external) {
  // Forces keep their direction when a body turns, so their moments change.
  const double* XF = keepsState_ ? keep(t, y) : nullptr;
  const Vec2d* F = XF ? external.F : nullptr;
  solver_.plain->linearize(external.e, y + paddedSize_, dydt + paddedSize_, F, XF);
}

inline void ExactSolve::solve(const double* rhs, double* x) {
  if (isPlain_) return solver_.plain->solve(rhs, rhs + paddedSize_, x, x + paddedSize_);
  solver_.solve(rhs, x, paddedSize_);
  if (!hasPower_) return;
  Powers change = powersAlong(x);
  if (general_) change.supplied += couplingPowerAlong(solver_);
  solver_.solveWorks(rhs, change.supplied, change.dissipated, x, paddedSize_);
}

}  // namespace planar_chain
