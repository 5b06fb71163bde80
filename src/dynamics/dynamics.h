#pragma once

/// The chain as an initial value problem, in ABSOLUTE angles, which the recursion speaks natively and in
/// which rounding does not add up along the chain:
///
///     y = [ θ_1…θ_n  ω_1…ω_n  (W_s  W_d) ]     θ̇ = ω     ω̇ = α(θ, ω, t)     Ẇ_s = power of loads and
///     commands
///                                                                            Ẇ_d = Σ d_i q̇_i²
///
/// The two works stand there only if something may supply or dissipate. Arranged, angles and rates stand as
/// the segments of a long chain are gone through (arrangement.h), the works behind them.
///
/// What runs is chosen when the chain is given, by its length and by what it has, and again when something
/// starts or stops to act: rates() goes through a list of the effects there are, or knows that there are
/// none.

#include <complex>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "effects/loads.h"
#include "effects/springs.h"
#include "effects/stops.h"
#include "lanes/arrangement.h"
#include "lanes/linearized_segments.h"
#include "lanes/motion_series.h"
#include "lanes/segments.h"
#include "lanes/short_chain.h"
#include "ode/system.h"
#include "planar_chain/motion.h"
#include "planar_chain/scene.h"
#include "recursion/acting.h"
#include "recursion/articulated.h"
#include "recursion/linearized.h"
#include "simd/cache_lines.h"

namespace planar_chain {

class Dynamics : public ode::SeriesSystem, private SeriesLoads {
 public:
  /// Both must outlive this object.
  Dynamics(const Chain& chain, Loads& loads);
  Dynamics(const Dynamics&) = delete;
  Dynamics& operator=(const Dynamics&) = delete;

  /// Chooses what of the loads acts in [t, loads.until()). Allocates nothing.
  void enter(double t);

  int size() const override { return 2 * n_ + works_; }
  /// How many components are works, behind the angles and rates: 0 or 2.
  int works() const { return works_; }
  /// See simulation.h.
  std::string recursion() const;
  void derivative(double t, const double* y, double* dydt) override;
  int arrangedSize() const override { return 2 * places_ + works_; }
  void arrange(const double* y, double* arranged) const override;
  void restore(const double* arranged, double* y) const override;
  /// None for short chains, which compute all in one go.
  int positions() const override { return positions_; }
  void rates(double t, const double* y, double* out) override;
  /// In segments the row is run on the way out of the recursion.
  void ratesAndRow(double t, const double* y, double* out, const ode::RowAhead& ahead) override;
  void linearize(double t, const double* y, double* dydt) override;
  bool timeDerivative(double* ft) override;
  ode::LinearCosts linearCosts() const override;
  void factor(double s) override;
  void solve(const double* rhs, double* x) override;
  void reserve(int complexCount) override;
  void factorComplex(int k, std::complex<double> s) override;
  void solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) override;
  bool seriesAreWorthwhile() const override { return MotionSeries::areWorthwhile(n_); }
  void reserveSeries(int order) override;
  int driving() const override { return 2 * n_; }
  void series(double t, const double* y, int order, double* c) override;
  bool hasIntegrands() const override { return !effects_.empty(); }
  void integrands(double t, const double* y, double* rates) override;
  double seriesCost(int order) const override;
  /// Of f; each order of a series counts as one.
  long long evaluations() const { return evaluations_; }

  /// Joint limits: f is that of where its stops are now.
  const Stops& stops() const { return stops_; }
  /// Every stop to where the state says; or those whose change is due. Allocate nothing.
  void enterStops(const double* y);
  void changeStops(const double* y);

  /// See simulation.h; y and dydt = f(t, y).
  void linkMotions(double t, const double* y, LinkMotion* motions);
  void jointTorques(double t, const double* y, double* tau);

 private:
  void findOrder(int k, const double* theta, const double* omega) override;

  struct Powers {
    double supplied = 0, dissipated = 0;
  };
  /// Adds what it is to N_ and F_, or to those arranged, and returns its powers.
  using Effect = Powers (Dynamics::*)(double t, const double* theta, const double* omega);
  Powers clearMoments(double t, const double* theta, const double* omega);
  Powers clearArrangedMoments(double t, const double* theta, const double* omega);
  Powers applyInOrder(double t, const double* y, const double* omega);
  Powers applyArrangedSprings(double t, const double* theta, const double* omega);
  Powers applyForces(double t, const double* theta, const double* omega);
  Powers applyTorques(double t, const double* theta, const double* omega);
  Powers applySprings(double t, const double* theta, const double* omega);
  Powers applyStops(double t, const double* theta, const double* omega);
  /// After a change of what acts.
  void findLoads();
  void listEffects();
  void changedStops();

  /// All but positions() of [ω α], with what acts, arranged. Link by link, e is read where forces act.
  void run(Acting acting, const Outside& outside, const double* y, double* rates,
           const simd::NystromSums* ahead = nullptr);
  Powers applyEffects(const std::vector<Effect>& effects, double t, const double* theta, const double* omega);
  /// N_ and F_ of what acts at a state in the order of the chain.
  Powers findLoadsInOrder(double t, const double* y);
  /// Of an arranged y.
  void evaluateRates(double t, const double* y, double* out, const simd::NystromSums* ahead = nullptr);
  void evaluateEffects(double t, const double* y, double* out, const simd::NystromSums* ahead);
  void evaluate(double t, const double* y, double* dydt);
  /// Of one in the order of the chain.
  void evaluateInOrder(double t, const double* y, double* dydt);
  /// Angles and rates of an arranged y in their order along the chain.
  const double* inOrder(const double* y);
  /// N_ and F_ to where `outside_` has them.
  void arrangeLoads(Acting acting);
  /// What powersAlong() and timeDerivative() need of the arranged state that is linearized at.
  void keep(const double* y);
  /// A number of each body: to `room`, which is returned; or as it stands, where that makes no difference.
  const double* arranged(const double* values, double* room) const;
  void findPinVelocities(const Rotation<double>* e, const double* omega);
  /// k and d of each joint, of its spring, damper and stops together.
  void findStiffness();
  /// How both change along (u, v), arranged, at the last linearize().
  Powers powersAlong(const double* uv);
  const Vec2d* forces() const { return loads_.reach() > 0 ? F_.data() : nullptr; }

  const Chain& chain_;
  Loads& loads_;
  int n_;
  int works_;
  Stops stops_;
  std::variant<ShortChain, Articulated<double>, Segments> recursion_;
  std::optional<Arrangement> arrangement_;
  Springs springs_, arrangedSprings_;
  int places_, positions_;
  Acting loadsAct_ = Acting::nothing, acting_ = Acting::nothing;
  bool varies_ = false;  ///< f, with time
  bool isBare_ = true;   ///< nothing but links, pins and gravity, so that even the list need not be asked
  std::vector<Effect> effects_;         ///< of rates()
  std::vector<Effect> effectsInOrder_;  ///< in the order of the chain: of the series, or without springs
  std::vector<Rotation<double>> e_;
  std::vector<double> N_, motion_;
  std::vector<Vec2d> F_, pinVelocity_;
  // The same arranged, for a chain in segments; and a state with its derivative; and in the chain's order.
  AlignedArray<Rotation<double>> arrangedE_;
  AlignedArray<Vec2d> arrangedF_;
  CacheLines arrangedN_, arrangedY_, arrangedRates_;
  std::vector<double> inOrder_;
  Outside outside_;  ///< what run() is given
  long long evaluations_ = 0;

  // For the exact solve, once there is room for it: link by link or in segments, whichever is faster for this
  // chain; the state of the last linearize() and what J holds there.
  template <class Scalar>
  using Solver = std::variant<Linearized<Scalar>, LinearizedSegments<Scalar>>;
  std::optional<Solver<double>> linearized_;
  std::vector<Solver<std::complex<double>>> complexLinearized_;
  double tAt_ = 0, s_ = 0;
  std::vector<std::complex<double>> complexS_;
  std::vector<double> part_;
  std::vector<double> thetaAt_, omegaAt_, arrangedOmegaAt_, kAt_, dAt_, XF_;
  std::vector<Rotation<double>> eAt_;

  std::optional<MotionSeries> series_;  ///< once there is room for it
};

}  // namespace planar_chain
