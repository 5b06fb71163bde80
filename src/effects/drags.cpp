#include "effects/drags.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/first_due.h"
#include "effects/passing.h"

namespace planar_chain {

namespace {

/// A drag keeps its sign until q̇ is wrong by this much, rad/s: a small share of the tolerance, of a slide
/// times the chain's reach. At 0, rounding of q̇ would switch the drag of a joint at rest or stuck in each
/// step; `leftOver` is more than the rate that the projection onto a held tip gives it.
constexpr double largest = 1e-9, shareOfTolerance = 0.1, ofFixedSteps = 1e-13, leftOver = 1e-11;
double leastRateOf(const Scene& scene, const Joint& joint) {
  const double tolerance = toleranceOfRates(scene.integrator),
               unit = joint.isPrismatic ? scene.chain.reach() : 1;
  const double least = tolerance > 0 ? std::min(largest, shareOfTolerance * tolerance) : ofFixedSteps;
  return unit * (scene.tip ? std::max(least, leftOver) : least);
}

class Drags : public Effect, public Switching {
 public:
  explicit Drags(const Scene& scene) : coordinates_(scene.chain.coordinates()), n_(scene.chain.size()) {
    for (int i = 0; i < n_; ++i) {
      const Joint& joint = scene.chain.joints()[index(i)];
      const double c = joint.other("drag");
      if (c > 0) drags_.push_back({{coordinates_, i}, c, 1, leastRateOf(scene, joint)});
    }
  }
  bool empty() const { return drags_.empty(); }

  LoadKind mostActing() const override { return LoadKind::moments; }

  /// τ = −c s q̇²; takes c s q̇³.
  Powers apply(const ChainState& at, const Actions& to) override {
    Powers powers;
    for (const Drag& drag : drags_) {
      const double rate = drag.q(at.omega), torque = -drag.c * drag.sign * rate * rate;
      coordinates_.addTorque(torque, drag.q.joint, to.N);
      powers.dissipated -= torque * rate;
    }
    return powers;
  }
  void addTorques(const ChainState& at, double* tau) override {
    for (const Drag& drag : drags_) {
      const double rate = drag.q(at.omega);
      tau[drag.q.joint] -= drag.c * drag.sign * rate * rate;
    }
  }

  // The exact derivative.
  bool isNonlinear() const override { return true; }
  void addTangents(const ChainState& at, double* /*k*/, double* d) const override {
    for (const Drag& drag : drags_) d[drag.q.joint] += 2 * drag.c * drag.sign * drag.q(at.omega);
  }
  Powers powersAlong(const ChainState& at, const StateChange& along) override {
    double change = 0;
    for (const Drag& drag : drags_) {
      const double rate = drag.q(at.omega);
      change += 3 * drag.c * drag.sign * rate * rate * drag.q(along.v);
    }
    return {0, change};
  }

  /// (q̇²)_k = Σ_j q̇_j q̇_{k−j}
  void addOrder(int k, const Series& known, const Actions& to) override {
    for (const Drag& drag : drags_) {
      double square = 0;
      for (int j = 0; j <= k; ++j) {
        square += drag.q(known.omega(j)) * drag.q(known.omega(k - j));
      }
      coordinates_.addTorque(-drag.c * drag.sign * square, drag.q.joint, to.N);
    }
  }

  // The sign of q̇ is a switch.
  Switching* switching() override { return this; }
  void enterState(double /*t*/, const double* y) override {
    for (Drag& drag : drags_) drag.sign = drag.q(y + n_) < 0 ? -1 : 1;
  }
  void takeFrom(const Switching& other) override {
    const std::vector<Drag>& theirs = static_cast<const Drags&>(other).drags_;
    for (std::size_t k = 0; k < drags_.size(); ++k) drags_[k].sign = theirs[k].sign;
  }
  void change(double /*t*/, double* y, const ode::Crossing& /*found*/) override {
    for (Drag& drag : drags_) {
      if (dueOf(drag, y) > 0) drag.sign = -drag.sign;
    }
  }
  double due(double /*t*/, const Eigen::VectorXd& y) const override {
    double most = -std::numeric_limits<double>::infinity();
    for (const Drag& drag : drags_) most = std::max(most, dueOf(drag, y.data()));
    return most;
  }
  /// The turning point of q̇ is where a change of sign may hide. Most are far from it by the cubic through
  /// both ends, which has the rounding of angles in it; the others are asked of the course.
  double nearest(const ode::Stretch& of) const override {
    const double *y = of.y.data(), *next = of.next.data();
    double first = 1;
    for (const Drag& drag : drags_) {
      const double v0 = drag.q(y + n_), v1 = drag.q(next + n_), turn = drag.q(next) - drag.q(y);
      const double middle = 1.5 * turn / of.h - (v0 + v1) / 4;
      if (!mayBeAbove(dueAt(drag, v0), dueAt(drag, middle), dueAt(drag, v1))) continue;
      const auto dueOn = [&](double t) {
        const double rate = drag.q(stateAt(t, of).data() + n_);
        return Due{dueAt(drag, rate), -drag.sign * of.h * drag.q(of.course->accelerationsAt(t).data())};
      };
      first = std::min(first, passing(dueOn(of.t), dueOn(of.t + of.h / 2), dueOn(of.t + of.h)));
    }
    return first < 1 ? first * of.h : -1;
  }
  bool mayHide(const ode::Stretch& /*of*/, bool isLong) const override { return isLong; }
  std::optional<ode::Crossing> crossing(const ode::Stretch& of) const override {
    return firstDueOf(
        drags_, of, [this](const Drag& drag, const double* y) { return dueOf(drag, y); },
        [](const Drag& drag) { return drag.least; });
  }

 private:
  struct Drag {
    Coordinate q;
    double c, sign, least;
  };
  static double dueAt(const Drag& drag, double rate) { return -drag.sign * rate - drag.least; }
  double dueOf(const Drag& drag, const double* y) const {
    constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
    return dueAt(drag, drag.q(y + n_)) - rounding * sumOfSizes(y + n_, drag.q);
  }

  Coordinates coordinates_;
  int n_;
  std::vector<Drag> drags_;
};

class DragKind : public EffectKind {
 public:
  std::vector<JointKey> jointKeys() const override {
    return {{"drag", nullptr, NumberRule::coefficient("N m s²/rad²")}};
  }

  std::unique_ptr<Effect> make(const Scene& scene) const override { return makeUnlessEmpty<Drags>(scene); }
  void addDense(const Scene& scene, double /*t*/, const Eigen::VectorXd& /*q*/, const Eigen::VectorXd& qd,
                const DenseActions& to) const override {
    for (int i = 0; i < scene.chain.size(); ++i) {
      to.tau(i) -= scene.chain.joints()[index(i)].other("drag") * std::abs(qd(i)) * qd(i);
    }
  }
  void summarize(const Scene& scene, SceneWords& words) const override {
    words.countJoints(
        scene.chain, [](const Joint& joint) { return joint.other("drag") > 0; }, "drag");
  }
};

}  // namespace

const EffectKind& dragKind() {
  static const DragKind kind;
  return kind;
}

}  // namespace planar_chain
