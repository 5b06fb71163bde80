#pragma once

/// The chain as an initial value problem, in ABSOLUTE angles: the recursion is written in them, and rounding
/// does not add up along the chain.
///
///     y = [ θ_1…θ_n  ω_1…ω_n  (W_s  W_d) ]      θ̇ = ω      ω̇ = α(θ, ω, t)
///     Ẇ_s = power that the effects supply       Ẇ_d = power that they take
///
/// The two works are there only if an effect may have power. Long chains keep their states in lane order
/// (lanes/arrangement.h): angles and rates as the segments are gone through, the works behind them.
///
/// What runs is chosen when the scene is given, by the chain's length and its effects, and again when an
/// effect starts or stops to act. A chain on which nothing acts asks for nothing in the loop.

#include <complex>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/exact_solve.h"
#include "dynamics/mechanism.h"
#include "effects/effects.h"
#include "lanes/motion_series.h"
#include "ode/system.h"
#include "planar_chain/motion.h"
#include "planar_chain/scene.h"
#include "simd/cache_lines.h"

namespace planar_chain {

class Dynamics : public ode::SeriesSystem, private SeriesLoads {
 public:
  /// more: an effect that the scene does not say, such as the user's commands, or nullptr. The scene must
  /// outlive this object. Allocates, as do reserve() and reserveSeries(); nothing else does.
  /// @throws std::invalid_argument when a load names a body that the chain does not have
  explicit Dynamics(const Scene& scene, std::unique_ptr<Effect> more = nullptr);
  Dynamics(const Dynamics&) = delete;
  Dynamics& operator=(const Dynamics&) = delete;

  // ---- Effects --------------------------------------------------------------------------------------------

  const Effects& effects() const { return effects_; }
  /// Chooses what acts in [t, effects().until()).
  void enter(double t);
  /// Makes the switches for a state in chain order: as the state says, or those that are due.
  void enterState(const double* y);
  void change(const double* y);

  // ---- What others read; states in chain order
  // --------------------------------------------------------------

  /// The recursion in words, as "closed form for two".
  std::string recursion() const;
  /// The number of works behind angles and rates: 0 or 2.
  int works() const { return works_; }
  /// Evaluations of f; each order of a series counts as one.
  long long evaluations() const { return evaluations_; }
  /// n of each; see simulation.h.
  void linkMotions(double t, const double* y, LinkMotion* motions);
  void jointTorques(double t, const double* y, double* tau);

  // ---- ode::System
  // ------------------------------------------------------------------------------------------

  int size() const override { return 2 * mechanism_.size() + works_; }
  void derivative(double t, const double* y, double* dydt) override;
  int arrangedSize() const override { return 2 * places_ + works_; }
  void arrange(const double* y, double* arranged) const override;
  void restore(const double* arranged, double* y) const override;
  /// None for short chains, which compute all in one go.
  int positions() const override { return positions_; }
  void rates(double t, const double* y, double* out) override;

  // ---- ode::LinearizedSystem
  // ----------------------------------------------------------------------------------

  void reserve(int complexCount) override;
  void linearize(double t, const double* y, double* dydt) override;
  bool timeDerivative(double* ft) override;
  ode::LinearCosts linearCosts() const override { return solve_->costs(); }
  void factor(double s) override { solve_->factor(s); }
  void solve(const double* rhs, double* x) override { solve_->solve(rhs, x); }
  void factorComplex(int k, std::complex<double> s) override { solve_->factorComplex(k, s); }
  void solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) override {
    solve_->solveComplex(k, rhs, x);
  }

  // ---- ode::SeriesSystem
  // --------------------------------------------------------------------------------------

  bool seriesAreWorthwhile() const override { return MotionSeries::areWorthwhile(mechanism_.size()); }
  void reserveSeries(int order) override;
  int driving() const override { return 2 * mechanism_.size(); }
  void series(double t, const double* y, int order, double* c) override;
  bool hasIntegrands() const override { return effects_.act(); }
  void integrands(double t, const double* y, double* rates) override;
  double seriesCost(int order) const override { return series_->cost(order); }

 private:
  /// N and F that are added up, in chain order and in lane order.
  struct Workspace {
    std::vector<Rotation<double>> e;
    std::vector<double> N, state, derivative;
    std::vector<Vec2d> F, pinVelocity;
    AlignedArray<Rotation<double>> eInLanes;
    AlignedArray<Vec2d> FInLanes;
    CacheLines NInLanes, yInLanes, ratesInLanes;
  };

  void switched();
  void findSeriesStiffness();
  void findOrder(int k, const double* theta, const double* omega) override;

  /// All but positions() of [ω α], with what acts, in lane order.
  void run(Acting acting, const Outside& outside, const double* y, double* rates);
  /// The derivative of all but the positions, or of all, at a state in lane order.
  void evaluateRates(double t, const double* y, double* out);
  void evaluateEffects(double t, const double* y, double* out);
  void evaluate(double t, const double* y, double* dydt);
  /// All of it at a state in chain order.
  void evaluateInOrder(double t, const double* y, double* dydt);

  /// N and F of these effects at a state in chain order, and their powers.
  Powers apply(const std::vector<Effect*>& effects, double t, const double* theta, const double* omega);
  ChainState stateWithForces(double t, const double* theta, const double* omega);
  void loadsToLanes(Acting acting);

  const Mechanism mechanism_;
  Effects effects_;
  int n_, places_, works_, positions_;
  bool isBare_ = true;  ///< links, pins and gravity alone
  Recursion recursion_;
  Workspace room_;
  double* N_;        ///< the moments in lane order
  Outside outside_;  ///< where run() finds e, N and F
  long long evaluations_ = 0;

  std::optional<ExactSolve> solve_;     ///< once a method asks for it
  std::optional<MotionSeries> series_;  ///< likewise
  std::vector<double> seriesK_, seriesD_;
  Series known_{};
};

}  // namespace planar_chain
