#pragma once

/// The dynamics of a chain whose joints couple accelerations, or whose base moves: rotors, driven joints,
/// friction (recursion/coupled.h). A road of its own: other chains run dynamics.h alone.
///
/// If the base turns by φ(t), y holds ψ = θ − φ and ψ̇, so that ψ_1 = q_1. The recursion has θ.
///
///     Ẇ_s also = Σ (μ_i + J_i q̈_i) q̇_i of driven joints + F_pin·v_base + (μ_1 + τ_1) φ̇
///
/// States are in chain order, whatever the length.

#include "dynamics/dynamics.h"
#include "dynamics/welded_chain.h"
#include "lanes/coupled_chain.h"
#include "recursion/coupled_linearized.h"
#include "recursion/coupled_series.h"

namespace planar_chain {

/// True if a scene needs CoupledDynamics.
bool isCoupled(const Scene& scene);

/// The dynamics of a scene, of either kind.
std::unique_ptr<Dynamics> makeDynamics(const Scene& scene, std::unique_ptr<Effect> more = nullptr);

class CoupledDynamics : public Dynamics, private Mechanics {
 public:
  /// As Dynamics.
  explicit CoupledDynamics(const Scene& scene, std::unique_ptr<Effect> more = nullptr);

  // Dynamics
  void enter(double t) override;
  void enterState(double t, const double* y) override;
  void change(double t, double* y, const ode::Crossing& found = {}) override;
  void reconsider(double t, double* y) override;
  void followBase(const BaseLaws& laws) override;
  bool hold(double t, double* y) override;
  void hold(double t, double* q, double* qd) override;
  std::string recursion() const override { return welded_ ? welded_->name() : recursion_.name(); }
  Energy energy(double t, const double* y) const override;
  void accelerations(double t, const double* y, double* alpha) override;
  void linkMotions(double t, const double* y, LinkMotion* motions) override;
  void jointTorques(double t, const double* y, double* tau) override;

  // For those who compute once.
  const Couplings& couplings() const { return now_.couplings; }
  Eigen::Map<const Eigen::VectorXd> rotors() const { return {rotors_.data(), n_}; }
  /// The torques of drives and friction, n values.
  void couplingTorques(double t, const double* y, double* tau);
  /// The state of the last linearize(), and the moments N there.
  CoupledState linearized() const;
  const std::vector<double>& moments() const { return then_.N; }
  /// The torques that besides all that acts give q̈ = qdd; friction is that of the motion, or of its start.
  void inverse(double t, const double* y, const double* qdd, double* tau);

  // ode::System
  void derivative(double t, const double* y, double* dydt) override;
  int positions() const override { return n_; }
  void rates(double t, const double* y, double* out) override;

  // ode::LinearizedSystem
  void reserve(int complexCount) override;
  void linearize(double t, const double* y, double* dydt) override;
  bool timeDerivative(double* ft) override;
  ode::LinearCosts linearCosts() const override { return {2.9, 1, 3.2, 2.8}; }
  void factor(double s) override { solver_.factor(s); }
  void solve(const double* rhs, double* x) override;
  void factorComplex(int k, std::complex<double> s) override { complexSolvers_[index(k)].factor(s); }
  void solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) override;

  // ode::SeriesSystem
  bool jumpsOften() const override { return welded_.has_value(); }
  bool seriesAreWorthwhile() const override { return MotionSeries::areWorthwhile(n_); }
  void reserveSeries(int order) override;
  void series(double t, const double* y, const double* carry, int order, double* c) override;
  bool hasIntegrands() const override { return works_ > 0; }
  void integrands(double t, const double* y, double* rates) override;
  double seriesCost(int order) const override { return 4.5 * order; }

 private:
  template <class Scalar>
  struct Solver {
    CoupledLinearized<Scalar> of;
    Scalar s{};

    void factor(Scalar s_) {
      s = s_;
      of.factor(s_);
    }
  };

  enum class Known { nothing, rates, moments, all };
  /// A state, and the results of the recursion there. `rates` are y, slopes and powers. `moments` are those
  /// and `moments`.
  struct Evaluation {
    explicit Evaluation(int n);
    bool isAt(const double* state) const;
    ChainState state() const {
      return {t, y.data(), y.data() + N.size(), e.data(), pinVelocity.data(), base.rate};
    }
    /// The rates against the ground, and ω̇ of y.
    const double* omega() const { return turning.empty() ? y.data() + N.size() : turning.data(); }
    const double* slopes() const { return slopesOnBase.empty() ? alpha.data() : slopesOnBase.data(); }

    Known known = Known::nothing;
    bool hasConstantMoments = false;  ///< N is that of effects with constant moments
    double t = 0;
    std::vector<double> y;  ///< angles and rates
    bool hasCouplings = false;
    Couplings couplings;
    BaseState base;
    Vec2d ground, pinForce;
    std::vector<Rotation<double>> e;
    std::vector<double> N, alpha, moments;
    std::vector<double> turning, slopesOnBase;  ///< if the base moves
    std::vector<Vec2d> F, pinVelocity;
    Powers powers;  ///< of the effects
  };

  JointAnswer answer(double t, const double* y) override;
  void forget(bool holds) override {
    now_.known = Known::nothing;
    now_.hasConstantMoments = false;
    if (!holds) return;
    now_.hasCouplings = aside_.hasCouplings = false;
    isWelded_ = false;
  }
  void forget() { forget(true); }
  /// What was computed for a query comes from another recursion than the motion's, if that is welded_: it
  /// must not become part of the motion.
  void forgetQuery() {
    if (welded_) now_.known = Known::nothing;
  }
  BaseState baseAt(double t) const;
  void collect(double t, int order, Couplings& to) const;
  void takeCouplings(Evaluation& to);
  /// Takes couplings, moments and forces at a state, and runs the recursion. What is known of the state is
  /// not computed again.
  void run(double t, const double* y) { run(t, y, Known::all, now_); }
  void run(double t, const double* y, Known wanted, Evaluation& to);
  void runCoupled(Evaluation& to);
  void runWelded(Known wanted, Evaluation& to);
  void applyEffects(Evaluation& to);
  double torqueIn(int i);
  double couplingPower();
  template <class Scalar>
  void solveWith(Solver<Scalar>& solver, const Scalar* rhs, Scalar* x);
  Powers powersAlong(const double* x);

  std::optional<BaseLaws> base_;
  std::vector<Effect*> coupling_, varying_;  ///< varying_: those that couple otherwise at another time
  std::vector<double> rotors_;               ///< J, kg m²
  CoupledChain recursion_;
  std::optional<WeldedChain> welded_;  ///< a faster recursion, if the scene allows it
  bool isWelded_ = false;              ///< welded_ has the joints that stick now
  Evaluation now_, aside_, then_;      ///< then_: of the last linearize()
  std::vector<double> torques_, tangentK_, tangentD_, XF_, part_, rates_;
  std::vector<Vec2d> pinVelocityAlong_;
  CoupledBodies bodies_;
  Solver<double> solver_;
  std::optional<CoupledSeries> series_;  ///< made when a method first needs it
  std::vector<Solver<std::complex<double>>> complexSolvers_;
};

}  // namespace planar_chain
