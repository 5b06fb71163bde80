#include "effects/friction.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planar_chain {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double slack = 1e-12;  // of a torque or an acceleration: less is rounding

double breakawayOf(const Joint& joint) {
  return std::max(joint.other("breakaway"), joint.other("friction"));
}

/// Where the parabola through g0, gm, g1 at 0, ½, 1 has a top above 0 while its ends are not, 0 < s < 1; 1:
/// nowhere. A curve may rise twice as far above its ends as the parabola.
double passing(double g0, double gm, double g1) {
  const double bend = 2 * (g0 - 2 * gm + g1), slope = 4 * gm - 3 * g0 - g1;
  const double end = std::max(g0, g1);
  if (!(bend < 0 && end <= 0)) return 1;
  const double s = -slope / (2 * bend);
  if (!(s > 0 && s < 1)) return 1;
  const double top = g0 + s * (slope + s * bend);
  return end + 2 * (top - end) > 0 ? s : 1;
}

}  // namespace

Friction::Friction(const Chain& chain) : n_(chain.size()) {
  for (int i = 0; i < n_; ++i) {
    const Joint& joint = chain.joints()[index(i)];
    if (!(joint.other("friction") > 0)) continue;
    rubs_.push_back({i, joint.other("friction"), breakawayOf(joint)});
    isBreakaway_ = isBreakaway_ || breakawayOf(joint) > joint.other("friction");
  }
  middle_.resize(2 * index(n_));
  moments_.resize(2 * index(n_));
}

bool Friction::anySticks() const {
  return std::any_of(rubs_.begin(), rubs_.end(), [](const Rub& rub) { return rub.direction == 0; });
}

// ---- What it does --------------------------------------------------------------------------------

Powers Friction::apply(const ChainState& at, const Actions& to) {
  double dissipated = 0;
  for (const Rub& rub : rubs_) {
    if (rub.direction == 0) continue;
    addJointTorque(-rub.direction * rub.sliding, rub.joint, to.N);
    dissipated += rub.direction * rub.sliding * relative(at.omega, rub.joint);
  }
  return {0, dissipated};
}

void Friction::addTorques(const ChainState& /*at*/, double* tau) {
  for (const Rub& rub : rubs_) tau[rub.joint] -= rub.direction * rub.sliding;
}

Powers Friction::powersAlong(const ChainState& /*at*/, const StateChange& along) {
  double change = 0;
  for (const Rub& rub : rubs_) change += rub.direction * rub.sliding * relative(along.v, rub.joint);
  return {0, change};
}

void Friction::couple(double /*t*/, int k, Couplings& to) const {
  for (const Rub& rub : rubs_) {
    if (rub.direction != 0) continue;
    to.joints[index(rub.joint)].isHeld = true;
    to.held[index(rub.joint)] = {k == 0 ? rub.angle : 0, 0, 0};
  }
}

// ---- Switches ------------------------------------------------------------------------------------

double Friction::Rub::slideDue(const double* omega) const {
  const double inner = joint > 0 ? std::abs(omega[joint - 1]) : 0;
  return -direction * relative(omega, joint) - 4 * epsilon * (std::abs(omega[joint]) + inner);
}

double Friction::Rub::stickDue(double mu) const {
  return std::abs(mu) - breakaway * (1 + slack);
}

double Friction::due(double t, const Eigen::VectorXd& y) const {
  double most = -std::numeric_limits<double>::infinity();
  const double* moments = anySticks() ? mechanics_->answer(t, y.data()).moments : nullptr;
  for (const Rub& rub : rubs_) {
    most =
        std::max(most, rub.direction != 0 ? rub.slideDue(y.data() + n_) : rub.stickDue(moments[rub.joint]));
  }
  return most;
}

double Friction::nearest(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& next, double h) const {
  // q̇ at the middle by Simpson's rule, from its mean.
  double first = 1;
  for (const Rub& rub : rubs_) {
    if (rub.direction == 0) continue;
    const double v0 = relative(y.data() + n_, rub.joint), v1 = relative(next.data() + n_, rub.joint);
    const double turned = relative(next.data(), rub.joint) - relative(y.data(), rub.joint);
    const double vm = 1.5 * turned / h - (v0 + v1) / 4;
    first = std::min(first, passing(-rub.direction * v0, -rub.direction * vm, -rub.direction * v1));
  }
  if (!anySticks()) return first < 1 ? first * h : -1;

  // μ at the start, at the middle, and at the end; the middle state by Hermite's cubic.
  for (int i = 0; i < n_; ++i) {
    const double v0 = y[n_ + i], v1 = next[n_ + i];
    middle_[index(i)] = (y[i] + next[i]) / 2 + h * (v0 - v1) / 8;
    middle_[index(n_ + i)] = 1.5 * (next[i] - y[i]) / h - (v0 + v1) / 4;
  }
  std::copy_n(mechanics_->answer(t, y.data()).moments, n_, moments_.begin());
  std::copy_n(mechanics_->answer(t + h / 2, middle_.data()).moments, n_, moments_.begin() + n_);
  const double* end = mechanics_->answer(t + h, next.data()).moments;
  for (const Rub& rub : rubs_) {
    if (rub.direction != 0) continue;
    for (const double sign : {-1.0, 1.0}) {
      const auto over = [&](double mu) { return sign * mu - rub.breakaway * (1 + slack); };
      first = std::min(first, passing(over(moments_[index(rub.joint)]), over(moments_[index(n_ + rub.joint)]),
                                      over(end[rub.joint])));
    }
  }
  return first < 1 ? first * h : -1;
}

void Friction::enterState(double t, const double* y) {
  for (Rub& rub : rubs_) {
    const double rate = relative(y + n_, rub.joint);
    rub.mayStick = rate == 0;
    rub.direction = (rate > 0) - (rate < 0);
    rub.angle = relative(y, rub.joint);
  }
  decide(t, y);
}

void Friction::change(double t, const double* y) {
  for (Rub& rub : rubs_) {
    const bool comesToRest = rub.direction != 0 && rub.slideDue(y + n_) > 0;
    rub.mayStick = rub.direction == 0 || comesToRest;
    if (comesToRest) rub.angle = relative(y, rub.joint);
  }
  decide(t, y);
}

void Friction::decide(double t, const double* y) {
  // At first, all that are at rest stick.
  int atRest = 0;
  for (Rub& rub : rubs_) {
    if (!rub.mayStick) continue;
    ++atRest;
    rub.direction = 0;
  }
  const int most = 10 * atRest + 50;
  for (int round = 0; atRest > 0 && round < most; ++round) {
    const JointAnswer answer = mechanics_->answer(t, y);
    double largest = 0;
    for (int i = 0; i < n_; ++i) largest = std::max(largest, std::abs(answer.accelerations[i]));
    // Those that would move against their friction stick again.
    bool changes = false;
    for (Rub& rub : rubs_) {
      if (!rub.mayStick || rub.direction * answer.accelerations[rub.joint] >= -slack * largest) continue;
      rub.direction = 0;
      changes = true;
    }
    // Of those that break loose, all; or the one with the most torque for its breakaway torque, for its start
    // may let others hold.
    const bool oneByOne = isBreakaway_ || round > atRest + 5;
    Rub* first = nullptr;
    for (Rub& rub : rubs_) {
      const double mu = answer.moments[rub.joint];
      if (!rub.mayStick || rub.direction != 0 || rub.stickDue(mu) <= 0) continue;
      if (oneByOne) {
        const auto ratio = [&](const Rub& of) { return std::abs(answer.moments[of.joint]) / of.breakaway; };
        if (!first || ratio(rub) > ratio(*first)) first = &rub;
      } else {
        rub.direction = mu > 0 ? -1 : 1;
        changes = true;
      }
    }
    if (first) first->direction = answer.moments[first->joint] > 0 ? -1 : 1;
    if (!changes && !first) return;
  }
}

// ---- The kind --------------------------------------------------------------------------------------

namespace {

class FrictionKind : public EffectKind {
 public:
  std::vector<JointKey> jointKeys() const override {
    return {{"friction", nullptr, NumberRule::from(0, "N m")},
            {"breakaway", nullptr, NumberRule::from(0, "N m, the friction")}};
  }
  void judge(const Joint& joint, std::vector<Fault>& faults) const override {
    const double friction = joint.other("friction");
    NumberRule::from(0, "N m").check(faults, "joint/friction", friction);
    if (joint.has("breakaway")) {
      NumberRule::from(friction, "N m, the friction")
          .check(faults, "joint/breakaway", joint.other("breakaway"));
    }
  }

  std::unique_ptr<Effect> make(const Scene& scene, const Arrangement* /*lanes*/) const override {
    auto effect = std::make_unique<Friction>(scene.chain);
    return effect->empty() ? nullptr : std::move(effect);
  }

  /// Friction at rest is not a function of the state: kane.h takes it from the recursion.
  void addDense(const Scene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&,
                const DenseActions&) const override {}

  void summarize(const Scene& scene, SceneWords& words) const override {
    int rubs = 0;
    for (const Joint& joint : scene.chain.joints()) rubs += joint.other("friction") > 0;
    if (rubs > 0) words.count(rubs, "rubbing joint");
  }
};

}  // namespace

const EffectKind& frictionKind() {
  static const FrictionKind kind;
  return kind;
}

}  // namespace planar_chain
