#include "effects/springs.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planar_chain {

namespace {

constexpr std::size_t parts = 8;  // sums in as many parts do not wait for each other

/// A number of the outer body less that of the inner one, which is 0 if there is none.
struct Difference {
  std::size_t outer, inner;
  bool hasInner;
  double operator()(const double* x) const { return hasInner ? x[outer] - x[inner] : x[outer]; }
};

}  // namespace

/// Calls f(i, l, difference) for the first `count` joints. l is less than `parts`, and not that of a
/// neighbour.
template <class F>
void Springs::forJoints(std::size_t count, F f) const {
  if (count == 0) return;
  f(0, 0, Difference{first_, first_ - 1, first_ > 0});
  const std::size_t lastRow = count - row_;
  for (std::size_t i = 1; i < row_; ++i) {  // what a lane begins with hangs on the last of the lane before
    f(i, 0, Difference{i, lastRow + i - 1, true});
  }
  const auto next = [&](std::size_t i, std::size_t l) {
    f(i, l, Difference{first_ + i, first_ + i - row_, true});
  };
  std::size_t i = row_;
  for (; i + parts <= count; i += parts) {
    for (std::size_t l = 0; l < parts; ++l) next(i + l, l);
  }
#ifndef __clang__
#pragma GCC ivdep  // or GCC 9 makes more instructions to find that out than for the joints that are left
#endif
  for (; i < count; ++i) next(i, 0);
}

/// Returns Σ term(i, difference) over the first `count` joints.
template <class Term>
double Springs::sumOver(std::size_t count, Term term) const {
  double sum = 0;
  if (count < row_ + parts) {
    forJoints(count, [&](std::size_t i, std::size_t, const Difference& of) { sum += term(i, of); });
    return sum;
  }
  double sums[parts] = {};
  forJoints(count, [&](std::size_t i, std::size_t l, const Difference& of) { sums[l] += term(i, of); });
  for (const double part : sums) sum += part;
  return sum;
}

Springs::Springs(const Chain& chain, const LaneOrder* lanes) {
  bool dissipates = false;
  std::size_t end = 0;
  for (std::size_t i = 0; i < chain.joints().size(); ++i) {
    const Joint& joint = chain.joints()[i];
    if (!(joint.stiffness > 0 || joint.damping > 0)) continue;
    if (end == 0) first_ = i;
    end = i + 1;
    dissipates = dissipates || joint.damping > 0;
  }
  if (end == 0) return;
  if (lanes) {
    first_ = 0;
    end = chain.joints().size();
    row_ = static_cast<std::size_t>(lanes->lanes());
  }
  k_.resize(lanes ? static_cast<std::size_t>(lanes->paddedSize()) : end - first_);
  rest_.resize(size());
  torque_.resize(size());
  if (dissipates) d_.resize(size());
  for (std::size_t i = first_; i < end; ++i) {
    const Joint& joint = chain.joints()[i];
    const std::size_t laneIndex = lanes ? lanes->laneIndexOf(i) : i - first_;
    k_[laneIndex] = joint.stiffness;
    rest_[laneIndex] = joint.restAngle;
    if (dissipates) d_[laneIndex] = joint.damping;
  }
}

double Springs::findTorques(const double* theta, const double* omega) {
  const double *k = k_.data(), *rest = rest_.data(), *d = d_.data();
  double* __restrict torque = torque_.data();
  forJoints(size(), [=](std::size_t i, std::size_t, const Difference& difference) {
    torque[i] = -k[i] * (difference(theta) - rest[i]);
  });
  return sumOver(d_.size(), [=](std::size_t i, const Difference& difference) {
    const double qd = difference(omega), damping = d[i] * qd;
    torque[i] -= damping;
    return damping * qd;
  });
}

double Springs::apply(const double* theta, const double* omega, double* N) {
  const double lost = findTorques(theta, omega);
  const double* torque = torque_.data();
  double* own = N + first_;
  const std::size_t last = size() - 1, lastRow = size() - row_;
  for (std::size_t i = 0; i < lastRow; ++i) own[i] += torque[i] - torque[i + row_];
  for (std::size_t i = lastRow; i < last; ++i) own[i] += torque[i] - torque[i - lastRow + 1];
  own[last] += torque[last];
  if (first_ > 0) N[first_ - 1] -= torque[0];
  return lost;
}

void Springs::addTorques(const double* theta, const double* omega, double* tau) {
  findTorques(theta, omega);
  for (std::size_t i = 0; i < size(); ++i) tau[first_ + i] += torque_[i];
}

void Springs::addStiffness(double* k, double* d) const {
  for (std::size_t i = 0; i < size(); ++i) k[first_ + i] += k_[i];
  for (std::size_t i = 0; i < d_.size(); ++i) d[first_ + i] += d_[i];
}

double Springs::dissipationAlong(const double* omega, const double* v) const {
  const double* d = d_.data();
  return sumOver(d_.size(), [=](std::size_t i, const Difference& difference) {
    return 2 * d[i] * difference(omega) * difference(v);
  });
}

// ---- The effect ------------------------------------------------------------------------------------

namespace {

/// Springs of chains whose joints are all revolute.
class SpringEffect : public Effect, public InLanes {
 public:
  explicit SpringEffect(const Chain& chain) : chain_(chain), inOrder_(chain), inLanes_(chain) {}
  bool empty() const { return inOrder_.empty(); }

  LoadKind mostActing() const override { return LoadKind::moments; }
  bool hasPower() const override { return inOrder_.dissipate(); }
  Powers apply(const ChainState& at, const Actions& to) override {
    return {0, inOrder_.apply(at.theta, at.omega, to.N)};
  }
  void addTorques(const ChainState& at, double* tau) override {
    inOrder_.addTorques(at.theta, at.omega, tau);
  }
  InLanes* inLanes() override { return this; }
  void takeLaneOrder(const LaneOrder* lanes) override { inLanes_ = Springs(chain_, lanes); }
  Powers applyInLanes(const double* theta, const double* omega, double* N) override {
    return {0, inLanes_.apply(theta, omega, N)};
  }
  void addStiffness(double* k, double* d) const override { inOrder_.addStiffness(k, d); }
  Powers powersAlong(const ChainState& at, const StateChange& along) override {
    return {0, inOrder_.dissipationAlong(at.omega, along.v)};
  }
  Powers powersAlongInLanes(const double* omega, const double* v) override {
    return {0, inLanes_.dissipationAlong(omega, v)};
  }

 private:
  const Chain& chain_;
  Springs inOrder_, inLanes_;
};

/// Springs of chains with prismatic joints, joint by joint.
class MixedSprings : public Effect {
 public:
  explicit MixedSprings(const Chain& chain) : coordinates_(chain.coordinates()) {
    for (int i = 0; i < chain.size(); ++i) {
      const Joint& joint = chain.joints()[index(i)];
      if (joint.stiffness > 0 || joint.damping > 0)
        springs_.push_back({{coordinates_, i}, joint.stiffness, joint.restAngle, joint.damping});
    }
  }
  bool empty() const { return springs_.empty(); }

  LoadKind mostActing() const override { return LoadKind::moments; }
  bool hasPower() const override {
    return std::any_of(springs_.begin(), springs_.end(), [](const Spring& spring) { return spring.d > 0; });
  }
  Powers apply(const ChainState& at, const Actions& to) override {
    Powers powers;
    for (const Spring& spring : springs_) {
      const double rate = spring.q(at.omega);
      coordinates_.addTorque(spring.torque(at), spring.q.joint, to.N);
      powers.dissipated += spring.d * rate * rate;
    }
    return powers;
  }
  void addTorques(const ChainState& at, double* tau) override {
    for (const Spring& spring : springs_) tau[spring.q.joint] += spring.torque(at);
  }
  void addStiffness(double* k, double* d) const override {
    for (const Spring& spring : springs_) {
      k[spring.q.joint] += spring.k;
      d[spring.q.joint] += spring.d;
    }
  }
  Powers powersAlong(const ChainState& at, const StateChange& along) override {
    double change = 0;
    for (const Spring& spring : springs_) change += 2 * spring.d * spring.q(at.omega) * spring.q(along.v);
    return {0, change};
  }

 private:
  struct Spring {
    Coordinate q;
    double k, rest, d;

    double torque(const ChainState& at) const { return -k * (q(at.theta) - rest) - d * q(at.omega); }
  };
  const Coordinates coordinates_;
  std::vector<Spring> springs_;
};

class SpringKind : public EffectKind {
 public:
  const std::vector<JointKey>& jointKeys() const override {
    constexpr double most = 1e6;  // rad or m, as initial angles of a joint with a spring
    static const std::vector<JointKey> keys{
        {"damping", &Joint::damping, NumberRule::coefficient("N m s/rad"), true, false, "damping"},
        {"stiffness", &Joint::stiffness, NumberRule::coefficient("N m/rad")},
        {"rest_angle", &Joint::restAngle, {" from -1e6 to 1e6 rad", -most, most, true}}};
    return keys;
  }

  std::unique_ptr<Effect> make(const Scene& scene) const override {
    if (scene.chain.coordinates().anyIsPrismatic()) return makeUnlessEmpty<MixedSprings>(scene.chain);
    return makeUnlessEmpty<SpringEffect>(scene.chain);
  }

  bool runsInLanes(const Scene& /*scene*/) const override { return true; }

  /// τ_i = −k_i (q_i − q0_i) − d_i q̇_i
  void addDense(const Scene& scene, double /*t*/, const Eigen::VectorXd& q, const Eigen::VectorXd& qd,
                const DenseActions& to) const override {
    for (int i = 0; i < scene.chain.size(); ++i) {
      const Joint& joint = scene.chain.joints()[static_cast<std::size_t>(i)];
      to.tau(i) += -joint.stiffness * (q(i) - joint.restAngle) - joint.damping * qd(i);
    }
  }

  /// V = ½ k (q − q0)²
  double energyIn(const Joint& joint, double q) const override {
    const double stretch = q - joint.restAngle;
    return 0.5 * (joint.stiffness * stretch * stretch);
  }
  double stiffnessOf(const Joint& joint) const override { return joint.stiffness; }
  double momentOf(const Joint& joint) const override {
    return joint.stiffness * (1 + std::abs(joint.restAngle));
  }

  Symbol symbolOf(const Joint& joint) const override {
    return joint.stiffness > 0 ? Symbol::coil : Symbol::none;
  }
  void summarize(const Scene& scene, SceneWords& words) const override {
    int springs = 0, dampers = 0;
    for (const Joint& joint : scene.chain.joints()) {
      springs += joint.stiffness > 0;
      dampers += joint.damping > 0;
    }
    // Beside dampers, missing springs run along at 0 N m/rad: they are not left out.
    if (springs > 0 || dampers == 0) words.count(springs, "spring");
    words.count(dampers, "damper");
  }
};

}  // namespace

const EffectKind& springKind() {
  static const SpringKind kind;
  return kind;
}

}  // namespace planar_chain
