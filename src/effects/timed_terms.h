#pragma once

/// Forces, moments and torques that act in windows of time: what loads and commands have in common.
///
/// Between two instants at which something starts, stops or has a corner, what acts is a fixed list of smooth
/// terms: a force F at the point x of a body, a moment M on it, a torque τ in a joint, each times a factor
/// f(t),
///
///     N_k += f (M + X×F)     F_j += f F     X = e_j x          N_i += f τ, N_{i−1} −= f τ
///
/// k: the revolute joint with whose body the body j turns; nothing, if that is the base.
///
/// enter(t) makes that list for [t, until()). The integrator lands on until() and enters again, so no stage
/// asks whether a load is on, and every impulse ∫F dt is exact.

#include <algorithm>
#include <limits>
#include <vector>

#include "effects/effect.h"
#include "planar_chain/scene.h"

namespace planar_chain {

/// The straight piece of a ramp to the right of t: flat before the first corner and after the last one.
struct Line {
  double t0 = 0, value = 0, slope = 0;
  double end = std::numeric_limits<double>::infinity();

  double at(double t) const { return value + slope * (t - t0); }
};
Line lineAt(const Ramp& ramp, double t);

class TimedTerms : public Effect, public Forces {
 public:
  void enter(double t) final;
  double until() const final { return until_; }
  /// A quarter of the shortest period in force, or less by stepAtMost().
  double longestStep() const final { return longestStep_; }
  bool variesWithTime() const override { return !sines_.empty() || !lines_.empty(); }

  LoadKind mostActing() const final { return LoadKind::forces; }
  LoadKind acting() const override {
    if (!bodyTerms_.empty()) return LoadKind::forces;
    return jointTerms_.empty() ? LoadKind::nothing : LoadKind::moments;
  }
  Forces* forces() final { return this; }
  int reach() const final { return reach_; }
  Powers apply(const ChainState& at, const Actions& to) override { return applyFactors(at, to, false); }
  Powers applyRates(const ChainState& at, const Actions& to) override { return applyFactors(at, to, true); }
  void addTorques(const ChainState& at, double* tau) override;
  void addForceStiffness(const ChainState& at, double* XF) final;
  Powers powersAlong(const ChainState& at, const StateChange& along) override;
  void saveOrRestore(Snapshot& snapshot) override {
    snapshot(until_, longestStep_, reach_, factors_, sines_, lines_, jointTerms_, bodyTerms_);
  }
  void reserveSeries(int orders) final;
  void addOrder(int k, const Series& known, const Actions& to) override;

 protected:
  /// Room for so many terms, and factors that change with time. Allocates.
  TimedTerms(const Coordinates& coordinates, std::size_t terms, std::size_t factors);

  /// Lists what acts from t on, by addWithin().
  virtual void list(double t) = 0;
  /// Adds what a Load or Command does, times a factor with this law, if start ≤ t < stop. until() is at most
  /// the start or stop that comes next.
  template <class What>
  void addWithin(const What& what, const TimeLaw& law, double t) {
    if (what.start > t) return endBy(what.start);
    if (what.stop <= t) return;
    endBy(what.stop);
    const int factor = factorOf(law, t);
    if (what.joint != Load::none) jointTerms_.push_back({{coordinates_, what.joint}, what.torque, factor});
    if (what.link == Load::none) return;
    bodyTerms_.push_back({what.link, what.force, what.point, what.moment, factor});
    if (!(what.force == Vec2d{})) reach_ = std::max(reach_, what.link + 1);
  }
  /// Nothing that is listed now holds beyond t.
  void endBy(double t) { until_ = std::min(until_, t); }
  /// Until the next enter().
  void stepAtMost(double longest) { longestStep_ = std::min(longestStep_, longest); }

 private:
  struct SineFactor {
    double pulsation, phase;
    int factor;
  };
  struct LineFactor {
    Line line;
    int factor;
  };
  struct JointTerm {
    Coordinate q;
    double torque;
    int factor;
  };
  struct BodyTerm {
    int body;
    Vec2d force, point;
    double moment;
    int factor;
  };

  /// The number of a factor with this law, from t on.
  int factorOf(const TimeLaw& law, double t);
  /// Sets the factors at t, or their rates.
  void evaluate(double t, bool rates = false);
  /// Applies the terms with the factors, or with their rates.
  Powers applyFactors(const ChainState& at, const Actions& to, bool rates);
  double times(int factor, double value) const { return factors_[static_cast<std::size_t>(factor)] * value; }

  Coordinates coordinates_;
  double until_ = std::numeric_limits<double>::infinity();
  double longestStep_ = std::numeric_limits<double>::infinity();
  int reach_ = 0;
  // The factor of a term is factors_[term.factor]; factors_[0] is 1.
  std::vector<double> factors_, factorSeries_;
  std::vector<SineFactor> sines_;
  std::vector<LineFactor> lines_;
  std::vector<JointTerm> jointTerms_;
  std::vector<BodyTerm> bodyTerms_;
};

}  // namespace planar_chain
