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
  const double end = std::max(g0, g1);
  const bool risesAndFalls = 4 * gm > 3 * g0 + g1 && 4 * gm > g0 + 3 * g1;
  if (!risesAndFalls || end > 0) return 1;
  const double bend = 2 * (g0 - 2 * gm + g1), slope = 4 * gm - 3 * g0 - g1;
  const double s = -slope / (2 * bend);
  const double top = g0 + s * (slope + s * bend);
  return end + 2 * (top - end) > 0 ? s : 1;
}

/// The polynomial through some points (x, g), by Newton's divided differences.
class Interpolation {
 public:
  static constexpr std::size_t most = 10;

  bool isFull() const { return size_ == most; }
  void add(double x, double g) {
    for (std::size_t k = 0; k < size_; ++k) g = (g - c_[k]) / (x - x_[k]);
    x_[size_] = x;
    c_[size_++] = g;
  }
  /// A zero in (low, high), where the polynomial rises from below 0 to above, by Newton's method.
  double zero(double low, double high) const {
    double x = (low + high) / 2;
    for (int k = 0; k < 50; ++k) {
      double value = 0, slope = 0;
      for (std::size_t j = size_; j-- > 0;) {
        slope = value + slope * (x - x_[j]);
        value = c_[j] + value * (x - x_[j]);
      }
      const double before = x;
      (value > 0 ? high : low) = x;
      x -= value / slope;
      if (!(x > low && x < high)) x = (low + high) / 2;
      if (std::abs(x - before) < 1e-15) break;
    }
    return x;
  }

 private:
  std::array<double, most> x_, c_;
  std::size_t size_ = 0;
};

}  // namespace

Friction::Friction(const Chain& chain) : n_(chain.size()) {
  for (int i = 0; i < n_; ++i) {
    const Joint& joint = chain.joints()[index(i)];
    if (!(joint.other("friction") > 0)) continue;
    rubs_.push_back({i, joint.other("friction"), breakawayOf(joint)});
    isBreakaway_ = isBreakaway_ || breakawayOf(joint) > joint.other("friction");
  }
  moments_.setZero(n_);
  dueAtEnd_.resize(rubs_.size());
  for (Seen& seen : seen_) seen = {std::numeric_limits<double>::quiet_NaN(), Eigen::VectorXd(n_)};
}

bool Friction::anySticks() const {
  return std::any_of(rubs_.begin(), rubs_.end(), [](const Rub& rub) { return rub.direction == 0; });
}

// ---- What it does --------------------------------------------------------------------------------

Powers Friction::apply(const ChainState& at, const Actions& to) {
  Eigen::Map<Eigen::VectorXd>(to.N, n_) += moments_;
  return {0, -moments_.dot(Eigen::Map<const Eigen::VectorXd>(at.omega, n_))};
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

inline double Friction::Rub::slideDue(const double* omega) const {
  const double outer = omega[joint], inner = joint > 0 ? omega[joint - 1] : 0;
  return -direction * (outer - inner) - 4 * epsilon * (std::abs(outer) + std::abs(inner));
}

inline double Friction::Rub::stickDue(double mu) const {
  return std::abs(mu) - breakaway * (1 + slack);
}

double Friction::due(double t, const Eigen::VectorXd& y) const {
  double most = -std::numeric_limits<double>::infinity();
  const double *omega = y.data() + n_, *moments = anySticks() ? momentsAt(t, y.data()) : nullptr;
  for (const Rub& rub : rubs_) most = std::max(most, rub.due(omega, moments));
  return most;
}

const double* Friction::momentsAt(double t, const double* y) const {
  for (const Seen& seen : seen_) {
    if (seen.t == t) return seen.moments.data();
  }
  Seen& to = seen_[oldest_];
  oldest_ = (oldest_ + 1) % seen_.size();
  to.t = t;
  std::copy_n(mechanics_->answer(t, y).moments, n_, to.moments.data());
  return to.moments.data();
}

double Friction::nearest(const ode::Stretch& of) const {
  const double middle = of.t + of.h / 2;
  const Eigen::VectorXd& between = of.course->at(middle);
  double first = 1;
  const double *begin = of.y.data() + n_, *half = between.data() + n_, *end = of.next.data() + n_;
  for (const Rub& rub : rubs_) {
    if (rub.direction == 0) continue;
    first = std::min(first, passing(rub.slideDue(begin), rub.slideDue(half), rub.slideDue(end)));
  }
  if (anySticks()) {
    begin = momentsAt(of.t, of.y.data());
    half = momentsAt(middle, between.data());
    end = momentsAt(of.t + of.h, of.next.data());
    for (const Rub& rub : rubs_) {
      if (rub.direction != 0) continue;
      for (const double sign : {-1.0, 1.0}) {
        const auto over = [&](const double* mu) {
          return sign * mu[rub.joint] - rub.breakaway * (1 + slack);
        };
        first = std::min(first, passing(over(begin), over(half), over(end)));
      }
    }
  }
  return first < 1 ? first * of.h : -1;
}

double Friction::dueAt(const Rub& rub, double t, const ode::Stretch& of) const {
  const Eigen::VectorXd& y = t == of.t ? of.y : t == of.t + of.h ? of.next : of.course->at(t);
  return rub.due(y.data() + n_, rub.direction == 0 ? momentsAt(t, y.data()) : nullptr);
}

std::optional<double> Friction::crossing(const ode::Stretch& of) const {
  // The joint that changes first along the chord, then those that change before.
  const double end = of.t + of.h;
  const double* moments = anySticks() ? momentsAt(end, of.next.data()) : nullptr;
  std::size_t likely = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < rubs_.size(); ++k) {
    dueAtEnd_[k] = rubs_[k].due(of.next.data() + n_, moments);
    if (dueAtEnd_[k] <= 0) continue;
    const double ratio = -dueAt(rubs_[k], of.t, of) / dueAtEnd_[k];
    if (ratio < least) likely = k;
    least = std::min(least, ratio);
  }
  std::optional<double> first = crossingOf(rubs_[likely], of, end);
  for (std::size_t k = 0; k < rubs_.size() && first; ++k) {
    if (k == likely || dueAtEnd_[k] <= 0) continue;
    if (dueAt(rubs_[k], *first, of) > 0) first = crossingOf(rubs_[k], of, *first);
  }
  return first;
}

std::optional<double> Friction::crossingOf(const Rub& rub, const ode::Stretch& of, double last) const {
  // How far behind it the step may end. Where |μ| reaches the torque of sliding, f bends and does not jump.
  const double *omega = of.next.data() + n_, inner = rub.joint > 0 ? std::abs(omega[rub.joint - 1]) : 0;
  const double begin = dueAt(rub, of.t, of), half = dueAt(rub, of.t + of.h / 2, of),
               end = dueAt(rub, of.t + of.h, of);
  const double narrow = 8 * epsilon * std::max(std::abs(of.t), of.h);
  const double beyond = narrow / of.h * 2 * std::max(std::abs(half - begin), std::abs(end - half)) +
                        (rub.direction != 0 ? 32 * epsilon * (std::abs(omega[rub.joint]) + inner)
                                            : (isBreakaway_ ? 1e-11 : 1e-8) * rub.breakaway);
  Interpolation due;
  due.add(0, begin - beyond / 2);
  due.add(0.5, half - beyond / 2);
  due.add(1, end - beyond / 2);
  double low = of.t, high = last;
  while (high - low > narrow) {
    const double t = of.t + of.h * due.zero((low - of.t) / of.h, (high - of.t) / of.h);
    if (due.isFull() || !(t > low && t < high)) return {};
    const double value = dueAt(rub, t, of);
    due.add((t - of.t) / of.h, value - beyond / 2);
    if (value > 0 && value <= beyond) return t;
    (value > 0 ? high : low) = t;
  }
  return high;
}

void Friction::enterState(double t, const double* y) {
  for (Rub& rub : rubs_) {
    const double rate = relative(y + n_, rub.joint);
    rub.mayStick = rate == 0;
    rub.direction = (rate > 0) - (rate < 0);
    rub.angle = relative(y, rub.joint);
  }
  takeMoments();
  decide(t, y);
}

void Friction::change(double t, double* y) {
  bool anyComes = false;
  for (Rub& rub : rubs_) {
    const bool comesToRest = rub.direction != 0 && rub.slideDue(y + n_) > 0;
    rub.mayStick = rub.direction == 0 || comesToRest;
    if (!comesToRest) continue;
    rub.direction = 0;
    rub.angle = relative(y, rub.joint);
    anyComes = true;
  }
  if (anyComes) {
    takeMoments();
    mechanics_->hold(t, y);
  }
  decide(t, y);
}

/// Call it when a joint sticks or slides from now on.
void Friction::takeMoments() {
  moments_.setZero();
  for (const Rub& rub : rubs_) addJointTorque(-rub.direction * rub.sliding, rub.joint, moments_.data());
  mechanics_->forget();
}

void Friction::decide(double t, const double* y) {
  // At first, all that are at rest stick.
  const auto atRest = std::count_if(rubs_.begin(), rubs_.end(), [](const Rub& rub) { return rub.mayStick; });
  for (Seen& seen : seen_) seen.t = std::numeric_limits<double>::quiet_NaN();
  const auto most = 10 * atRest + 50;
  for (int round = 0; atRest > 0 && round < most; ++round) {
    const JointAnswer answer = mechanics_->answer(t, y);
    double largest = 0;
    for (int i = 0; i < n_; ++i) largest = std::max(largest, std::abs(relative(answer.accelerations, i)));
    // Those that would move against their friction stick again.
    bool changes = false;
    for (Rub& rub : rubs_) {
      if (!rub.mayStick || rub.direction * relative(answer.accelerations, rub.joint) >= -slack * largest)
        continue;
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
    if (!changes && !first) break;
    takeMoments();
  }
  if (anySticks()) momentsAt(t, y);
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
