#pragma once

/// The chain as an initial value problem in ABSOLUTE angles. The recursion uses them, and their rounding
/// errors do not add up along the chain.
///
///     y = [ θ_1…θ_n  ω_1…ω_n  (W_s  W_d) ]      θ̇ = ω      ω̇ = α(θ, ω, t)
///     Ẇ_s = power that the effects supply       Ẇ_d = power that they take from the chain
///
/// For prismatic joints θ and ω are the displacement s and its rate.
///
/// The two works W exist only if an effect may have power. Long chains store their states in lane order
/// (lanes/lane_order.h): angles and rates in the order of the segments, then the works.
///
/// It owns the mechanism, the effects, and a recursion for q̈. The constructor chooses the recursion, by the
/// length of the chain and by what the effects say of themselves: written out or in segments
/// (Recursion); or with joints of any kind, a moving base and welded bodies (GeneralMotion). If the base
/// turns, θ and ω are measured from it, and states are in chain order. The loop of a chain without effects
/// contains no test for them. Effects sums the powers; Dynamics integrates them, for all recursions.

#include <complex>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/exact_solve.h"
#include "dynamics/general_motion.h"
#include "dynamics/mechanism.h"
#include "dynamics/momenta.h"
#include "dynamics/stored_energy.h"
#include "effects/effects.h"
#include "lanes/motion_series.h"
#include "ode/system.h"
#include "planar_chain/energy.h"
#include "planar_chain/motion.h"
#include "planar_chain/scene.h"
#include "recursion/general_series.h"
#include "simd/cache_lines.h"

namespace planar_chain {

/// The Taylor series of a motion through its state at t: order k of (θ, ω) is row k of c. Nothing: no c.
struct MotionInSeries {
  double t = 0;
  const double* c = nullptr;
  int order = 0;
};

class Dynamics final : public ode::SeriesSystem, private SeriesLoads {
 public:
  /// more: an effect that is not in the scene, such as the user's commands, or nullptr. The scene must
  /// outlive this object. Only the constructor, reserve() and reserveSeries() allocate.
  /// @throws std::invalid_argument when a load names a body that the chain does not have
  explicit Dynamics(const Scene& scene, std::unique_ptr<Effect> more = nullptr);
  Dynamics(const Dynamics&) = delete;
  Dynamics& operator=(const Dynamics&) = delete;

  // ---- Effects -------------------------------------------------------------------------------------

  const Effects& effects() const { return effects_; }
  /// Chooses what acts in [t, effects().until()).
  void enter(double t);
  /// Enters at a state in chain order, after motions: joints that stick may break loose, and motors may be
  /// at their lines. As hold().
  bool enter(double t, double* y);
  /// Enters at a state that was set, whatever acted before. As hold().
  bool begin(double t, double* y);
  /// Call it if results for times to come are known that belong to other states.
  void reconsider(double t, double* y);
  /// See Effect. Call enter() after recall().
  void remember() { effects_.remember(); }
  void recall() { effects_.recall(); }
  /// Saves or restores what the effects and the counts are (simd/snapshot.h).
  void saveOrRestore(Snapshot& snapshot);
  /// Chooses what acts at a state in chain order.
  void enterState(double t, const double* y);
  /// Fires the events that have happened at a state in chain order. Joints that come to rest are held.
  /// located: as in Events::fire().
  void fire(double t, double* y, const ode::LocatedEvent& located = {});

  // ---- Prescribed joints: driven or stuck --------------------------------------------------------------

  /// Puts held joints where they are at t, exactly. Returns true if there are any.
  bool hold(double t, double* y) { return general_ && general_->hold(t, y); }
  /// hold() for relative angles and rates.
  void hold(double t, double* q, double* qd) {
    if (general_) general_->hold(t, q, qd);
  }

  // ---- A held tip ------------------------------------------------------------------------------------

  bool holdsTip() const { return effects_.holdTip(); }
  /// The distance of the tip from where it is held, m; 0 if it is free.
  double closureError(double t, const double* y) { return general_ ? general_->closureError(t, y) : 0; }
  /// See Closure::spread(); 1 if the tip is free.
  double closureMargin(double t, const double* y) { return general_ ? general_->spread(t, y) : 1; }
  /// The force on the tip, N.
  Vec2d tipForce(double t, const double* y) {
    return holdsTip() ? general_->query(t, y).ends.tip.force : Vec2d{};
  }

  // ---- Results; states in chain order ---------------------------------------------------------------

  /// A description of the recursion, such as "closed form for two".
  std::string recursion() const;
  /// The number of works behind angles and rates: 0 or 2.
  int works() const { return works_; }
  /// Evaluations of f; each order of a series counts as one.
  long long evaluations() const {
    return (general_ ? general_->evaluations() : evaluations_) + seriesOrders_;
  }
  Energy energy(double t, const double* y) const;
  /// Write n values each; see simulation.h.
  void accelerations(double t, const double* y, double* alpha);  ///< of the angles in y
  void linkMotions(double t, const double* y, LinkMotion* motions);
  void jointTorques(double t, const double* y, double* tau);

  // ---- ode::System ---------------------------------------------------------------------------------

  int size() const override { return 2 * mechanism_.size() + works_; }
  int freedoms() const override { return size() - (holdsTip() ? 4 : 0); }
  void derivative(double t, const double* y, double* dydt) override;
  const simd::VectorKernel& vectors() const override { return simd::vectors(mechanism_.kernelChoice()); }
  int sizeInLaneOrder() const override { return 2 * firstRate_ + works_; }
  bool hasOneOrder() const override { return !mechanism_.lanes(); }
  void toLaneOrder(const double* y, double* laneOrdered) const override;
  void toChainOrder(const double* laneOrdered, double* y) const override;
  /// 0 for short chains, which compute all derivatives together.
  int positions() const override { return positions_; }
  int firstRate() const override { return firstRate_; }
  void rates(double t, const double* y, double* out) override;
  void endedAt(ode::State& state) override {
    if (general_) general_->endedAt(state);
  }
  /// True if project() moves states.
  bool keepsConditions() const { return holdsTip() || momenta_; }
  bool project(ode::State& state, const ode::State& before) override {
    if (momenta_) momenta_->keep(before.t, before.y.data(), state.t, state.y.data(), state.carry.data());
    return !holdsTip() || general_->project(state.t, state.y.data(), state.carry.data());
  }
  double margin() const override { return general_ ? general_->lastSpread() : 1; }

  // ---- ode::LinearizedSystem -----------------------------------------------------------------------

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

  // ---- ode::SeriesSystem ---------------------------------------------------------------------------

  /// True for many joints with dry friction: one soon sticks or slips.
  bool jumpsOften() const override { return effects_.onlyHold() && n_ > ShortChain::most; }
  /// True if the motion has a Taylor series.
  bool hasSeries() const;
  bool seriesAreWorthwhile() const override { return hasSeries() && MotionSeries::areWorthwhile(n_); }
  void reserveSeries(int order) override;
  int driving() const override { return 2 * mechanism_.size(); }
  void series(double t, const double* y, const double* carry, int order, double* c) override;
  /// The last one, in the memory of the method that asked for it.
  const MotionInSeries& lastSeries() const { return lastSeries_; }
  bool hasIntegrands() const override { return general_ && !series_ ? works_ > 0 : effects_.act(); }
  void integrands(double t, const double* y, double* rates) override;
  double seriesCost(int order) const override;

 private:
  /// A motion of the chain: of the base and its pin, and of each link. F: nullptr if no force acts.
  struct ChainMotion {
    PointAt<double> pin;
    Vec2d acceleration;
    double turning, angle;
    const double* y;  ///< angles from the base's angle
    const Rotation<double>* e;
    const double *omega, *xdd;
    const Displacement<double>* displaced;
    const Vec2d* F;
    Vec2d tipForce{};
  };
  /// Memory for states and for the sums N and F, in chain order and in lane order.
  struct Workspace {
    std::vector<Rotation<double>> e;
    std::vector<double> N, state, derivative;
    std::vector<Vec2d> F, pinVelocity;
    AlignedArray<Rotation<double>> eInLanes;
    AlignedArray<Vec2d> FInLanes;
    CacheLines NInLanes, yInLanes, ratesInLanes;
  };

  void switched();
  /// Call when another set of effects acts.
  void takeStiffness();
  void moveLinks(const ChainMotion& from, LinkMotion* motions) const;

  /// Computes [ω α] under these moments and forces, without the first positions() rates. Lane order.
  void run(LoadKind acting, const Loads& external, const double* y, double* rates);
  void runLong(LoadKind acting, const Loads& external, const double* y, double* rates);
  /// As rates(), at a state in lane order. evaluateEffects() does it when an effect acts.
  void evaluateRates(double t, const double* y, double* out);
  void evaluateEffects(double t, const double* y, double* out);
  Powers ratesUnderEffects(double t, const double* y, double* out);
  /// The whole derivative at a state in lane order.
  void evaluate(double t, const double* y, double* dydt);
  /// The whole derivative at a state in chain order.
  void evaluateInOrder(double t, const double* y, double* dydt);
  /// Also returns the forces on the links there, or nullptr.
  const Vec2d* evaluateWithForces(double t, const double* y, double* dydt);

  /// Writes N and F of these effects at a state in chain order. Returns their powers.
  Powers apply(const std::vector<Effect*>& effects, double t, const double* theta, const double* omega);
  ChainState stateWithForces(double t, const double* theta, const double* omega);
  void loadsToLanes(LoadKind acting);
  Powers timeDerivativeOfLoads(double* slopes);

  void findOrder(int k) override;
  void findGeneralSeries(double t, const double* y, int order, double* c);

  Effects effects_;
  const Mechanism mechanism_;
  std::optional<GeneralMotion> general_;  ///< nothing: recursion_ runs
  std::optional<Momenta> momenta_;        ///< of a free chain
  int n_, firstRate_, works_;
  const Stores stores_;
  long long evaluations_ = 0, seriesOrders_ = 0;

  int positions_;
  bool isBare_ = true;  ///< nothing acts but pins, gravity and inertia
  Recursion recursion_;
  Workspace room_;
  double* N_;       ///< the moments in lane order
  Loads external_;  ///< where run() finds e, N and F

  // Made when a method first needs them:
  std::optional<EffectTangents> tangents_;
  std::optional<ExactSolve> solve_;
  std::optional<MotionSeries> series_;
  std::optional<GeneralSeries> generalSeries_;
  std::optional<Couplings> orders_;  ///< of the general series
  Series known_{};                   ///< of the series in hand
  MotionInSeries lastSeries_;
};

}  // namespace planar_chain
