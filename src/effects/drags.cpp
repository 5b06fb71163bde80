#include "effects/drags.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

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

class Drags : public Effect, public Events, private ode::EventFunctions {
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

  void saveOrRestore(Snapshot& snapshot) override {
    for (Drag& drag : drags_) snapshot(drag.sign);
  }

  // An event is a change of the sign of q̇.
  Events* events() override { return this; }
  void addEvents(ode::EventList& to) const override { to.push_back(this); }
  void enterState(double /*t*/, const double* y) override {
    for (Drag& drag : drags_) drag.sign = drag.q(y + n_) < 0 ? -1 : 1;
  }
  void takeFrom(const Events& other) override {
    const std::vector<Drag>& theirs = static_cast<const Drags&>(other).drags_;
    for (std::size_t k = 0; k < drags_.size(); ++k) drags_[k].sign = theirs[k].sign;
  }
  void fire(double /*t*/, double* y, const ode::LocatedEvent& /*located*/) override {
    for (Drag& drag : drags_) {
      if (valueOf(drag, y) > 0) drag.sign = -drag.sign;
    }
  }

 private:
  struct Drag {
    Coordinate q;
    double c, sign, least;
  };
  double valueOf(const Drag& drag, const double* y) const {
    constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
    return -drag.sign * drag.q(y + n_) - drag.least - rounding * sumOfSizes(y + n_, drag.q);
  }
  int most() const override { return static_cast<int>(drags_.size()); }
  void values(double /*t*/, const double* y, double* g) const override {
    for (const Drag& drag : drags_) *g++ = valueOf(drag, y);
  }
  void noise(double /*t*/, const double* /*y*/, double* of) const override {
    for (const Drag& drag : drags_) *of++ = drag.least;
  }
  bool haveSlopes() const override { return true; }
  void slopes(double /*t*/, const double* /*y*/, const double* accelerations, double* slope) const override {
    for (const Drag& drag : drags_) *slope++ = -drag.sign * drag.q(accelerations);
  }

  Coordinates coordinates_;
  int n_;
  std::vector<Drag> drags_;
};

class DragKind : public EffectKind {
 public:
  const std::vector<JointKey>& jointKeys() const override {
    static const std::vector<JointKey> keys{{"drag", nullptr, NumberRule::coefficient("N m s²/rad²")}};
    return keys;
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
