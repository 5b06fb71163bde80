#include "effects/friction.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planar_chain {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double never = -1e300;

bool mayStick(const Joint& joint) {
  return joint.other("friction") > 0 || joint.other("breakaway") > 0;
}

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
  double value(double x, double& slope) const {
    double value = slope = 0;
    for (std::size_t j = size_; j-- > 0;) {
      slope = value + slope * (x - x_[j]);
      value = c_[j] + value * (x - x_[j]);
    }
    return value;
  }
  /// A zero in (low, high), where the polynomial rises from below 0 to above, by Newton's method.
  double zero(double low, double high) const {
    double x = (low + high) / 2;
    for (int k = 0; k < 50; ++k) {
      double slope;
      const double g = value(x, slope), before = x;
      (g > 0 ? high : low) = x;
      x -= g / slope;
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
  for (Numbers* numbers : {&sliding_, &breakaway_, &direction_, &angle_, &yield_}) numbers->setZero(n_);
  never_.setConstant(n_, never);
  for (int i = 0; i < n_; ++i) {
    const Joint& joint = chain.joints()[index(i)];
    if (!mayStick(joint)) continue;
    rubs_.push_back(i);
    sliding_[i] = joint.other("friction");
    breakaway_[i] = breakawayOf(joint);
    isBreakaway_ = isBreakaway_ || breakaway_[i] > sliding_[i];
  }
  for (std::vector<int>* joints : {&stuck_, &before_, &earlier_, &atRest_, &due_})
    joints->reserve(rubs_.size());
  moments_.setZero(n_);
  for (Seen& seen : seen_) seen.moments = seen.dues = Numbers(n_);
  forgetSeen();
}

// ---- What it does --------------------------------------------------------------------------------

Powers Friction::apply(const ChainState& at, const Actions& to) {
  if (to.N) Eigen::Map<Eigen::VectorXd>(to.N, n_) += moments_;
  return {0, -moments_.dot(Eigen::Map<const Eigen::VectorXd>(at.omega, n_))};
}

void Friction::addTorques(const ChainState& /*at*/, double* tau) {
  Eigen::Map<Numbers>(tau, n_) -= direction_ * sliding_;
}

Powers Friction::powersAlong(const ChainState& /*at*/, const StateChange& along) {
  double change = 0;
  for (const int i : rubs_) change += direction_[i] * sliding_[i] * relative(along.v, i);
  return {0, change};
}

void Friction::couple(double /*t*/, int k, Couplings& to) const {
  for (const int i : stuck_) {
    to.joints[index(i)].isHeld = true;
    to.held[index(i)] = {k == 0 ? angle_[i] : 0, 0, 0};
  }
}

// ---- Switches ------------------------------------------------------------------------------------

inline double Friction::slideDue(int joint, const double* omega) const {
  const double outer = omega[joint], inner = joint > 0 ? omega[joint - 1] : 0;
  return -direction_[joint] * (outer - inner) - 4 * epsilon * (std::abs(outer) + std::abs(inner)) +
         never_[joint];
}

void Friction::findSlidesDue(const double* omega, Numbers& due) const {
  due[0] = slideDue(0, omega);
  const Eigen::Index others = n_ - 1;
  const Eigen::Map<const Numbers> outer(omega + 1, others), inner(omega, others);
  due.tail(others) = -direction_.tail(others) * (outer - inner) - 4 * epsilon * (outer.abs() + inner.abs()) +
                     never_.tail(others);
}

double Friction::due(double t, const Eigen::VectorXd& y) const {
  return duesAt(t, y.data()).maxCoeff();
}

Friction::Seen& Friction::seen(double t) const {
  for (Seen& seen : seen_) {
    if (seen.t == t) return seen;
  }
  Seen& seen = seen_[oldest_];
  oldest_ = (oldest_ + 1) % seen_.size();
  seen.t = t;
  seen.hasMoments = seen.hasDues = false;
  return seen;
}

void Friction::forgetSeen() {
  for (Seen& seen : seen_) seen.t = std::numeric_limits<double>::quiet_NaN();
}

const double* Friction::momentsAt(double t, const double* y) const {
  Seen& seen = this->seen(t);
  if (!seen.hasMoments) std::copy_n(mechanics_->answer(t, y).moments, n_, seen.moments.data());
  seen.hasMoments = true;
  return seen.moments.data();
}

const Friction::Numbers& Friction::duesAt(double t, const double* y) const {
  Seen& seen = this->seen(t);
  if (seen.hasDues) return seen.dues;
  findSlidesDue(y + n_, seen.dues);
  for (const int i : stuck_) seen.dues[i] = stickDue(i, momentsAt(t, y));
  seen.hasDues = true;
  return seen.dues;
}

double Friction::nearest(const ode::Stretch& of) const {
  const double middle = of.t + of.h / 2;
  const Eigen::VectorXd& between = of.course->at(middle);
  double first = 1;

  // A parabola's top is at most so far above its ends that 2 g_m > min(g_0, g_1) where passing() finds one.
  const Numbers &atBegin = duesAt(of.t, of.y.data()), &atHalf = duesAt(middle, between.data()),
                &atEnd = duesAt(of.t + of.h, of.next.data());
  if ((2 * atHalf - atBegin.min(atEnd)).maxCoeff() > 0) {
    for (const int i : rubs_) {
      if (slides(i)) first = std::min(first, passing(atBegin[i], atHalf[i], atEnd[i]));
    }
  }

  if (!stuck_.empty()) {
    const double *begin = momentsAt(of.t, of.y.data()), *half = momentsAt(middle, between.data()),
                 *end = momentsAt(of.t + of.h, of.next.data());
    for (const int i : stuck_) {
      for (const double sign : {-1.0, 1.0}) {
        const auto over = [&](const double* mu) { return sign * mu[i] - breakaway_[i] * (1 + slack); };
        first = std::min(first, passing(over(begin), over(half), over(end)));
      }
    }
  }
  return first < 1 ? first * of.h : -1;
}

double Friction::dueAt(int joint, double t, const ode::Stretch& of) const {
  const Eigen::VectorXd& y = t == of.t ? of.y : t == of.t + of.h ? of.next : of.course->at(t);
  return slides(joint) ? slideDue(joint, y.data() + n_) : stickDue(joint, momentsAt(t, y.data()));
}

std::optional<double> Friction::crossing(const ode::Stretch& of) const {
  // The joint that changes first along the chord, then those that change before.
  const Numbers &atBegin = duesAt(of.t, of.y.data()), &atEnd = duesAt(of.t + of.h, of.next.data());
  int likely = 0;
  double least = std::numeric_limits<double>::infinity();
  due_.clear();
  for (const int i : rubs_) {
    if (atEnd[i] <= 0) continue;
    due_.push_back(i);
    const double ratio = -atBegin[i] / atEnd[i];
    if (ratio < least) likely = i;
    least = std::min(least, ratio);
  }
  std::optional<double> first = crossingOf(likely, of, of.t + of.h);
  for (std::size_t k = 0; k < due_.size() && first; ++k) {
    const int i = due_[k];
    if (i != likely && dueAt(i, *first, of) > 0) first = crossingOf(i, of, *first);
  }
  return first;
}

std::optional<double> Friction::crossingOf(int joint, const ode::Stretch& of, double last) const {
  // How far behind it the step may end. Where |μ| reaches the torque of sliding, f bends and does not jump: a
  // delay δ then changes a rate by δ² alone.
  const double *omega = of.next.data() + n_, inner = joint > 0 ? std::abs(omega[joint - 1]) : 0;
  const double begin = dueAt(joint, of.t, of), half = dueAt(joint, of.t + of.h / 2, of),
               end = dueAt(joint, of.t + of.h, of);
  const double narrow = 8 * epsilon * std::max(std::abs(of.t), of.h);
  const double most = breakaway_[joint], late = std::clamp(1e-5 * (end - begin), 1e-8 * most, 1e-6 * most);
  const double beyond = narrow / of.h * 2 * std::max(std::abs(half - begin), std::abs(end - half)) +
                        (slides(joint) ? 32 * epsilon * (std::abs(omega[joint]) + inner)
                                       : (isBreakaway_ ? 1e-11 * most : late));
  Interpolation due;
  due.add(0, begin - beyond / 2);
  due.add(0.5, half - beyond / 2);
  due.add(1, end - beyond / 2);
  double low = of.t, high = last;
  arrival_.joint = -1;
  while (high - low > narrow) {
    const double t = of.t + of.h * due.zero((low - of.t) / of.h, (high - of.t) / of.h);
    if (due.isFull() || !(t > low && t < high)) return {};
    const double value = dueAt(joint, t, of);
    due.add((t - of.t) / of.h, value - beyond / 2);
    if (value > 0 && value <= beyond) {
      arrival_ = {joint, direction_[joint], 0};
      due.value((t - of.t) / of.h, arrival_.slope);
      arrival_.slope /= of.h;
      return t;
    }
    (value > 0 ? high : low) = t;
  }
  return high;
}

void Friction::enterState(double t, const double* y) {
  atRest_.clear();
  yield_.setZero();
  arrival_.joint = -1;
  for (const int i : rubs_) {
    const double rate = relative(y + n_, i);
    if (rate == 0) atRest_.push_back(i);
    direction_[i] = (rate > 0) - (rate < 0);
    angle_[i] = relative(y, i);
  }
  takeDirections();
  decide(t, y);
}

void Friction::change(double t, double* y) {
  if (arrival_.joint >= 0 && slideDue(arrival_.joint, y + n_) <= 0) arrival_.joint = -1;
  atRest_.clear();
  bool anyComes = false;
  for (const int i : rubs_) {
    const bool comesToRest = slideDue(i, y + n_) > 0;
    if (comesToRest || !slides(i)) atRest_.push_back(i);
    if (!comesToRest) continue;
    direction_[i] = mayPass(i) ? -direction_[i] : 0;
    angle_[i] = relative(y, i);
    anyComes = true;
  }
  if (anyComes) takeDirections();
  mechanics_->hold(t, y);
  decide(t, y);
}

bool Friction::mayPass(int joint) const {
  return joint == arrival_.joint && !isBreakaway_ && yield_[joint] > 0 &&
         arrival_.slope > 2 * sliding_[joint] * yield_[joint];
}

void Friction::learn(const JointAnswer& answer) {
  const auto [joint, direction, slope] = arrival_;
  if (joint < 0) return;
  const double more = direction * answer.moments[joint] + sliding_[joint];
  const double after = direction * relative(answer.accelerations, joint);
  yield_[joint] = slides(joint) ? (slope + after) / (2 * sliding_[joint]) : slope / more;
  arrival_.joint = -1;
}

void Friction::takeDirections() {
  std::swap(before_, earlier_);
  std::swap(stuck_, before_);
  stuck_.clear();
  for (const int i : rubs_) {
    never_[i] = slides(i) ? 0 : never;
    if (!slides(i)) stuck_.push_back(i);
  }
  const Eigen::Index others = n_ - 1;
  moments_ = -(direction_ * sliding_).matrix();
  moments_.head(others) += (direction_.tail(others) * sliding_.tail(others)).matrix();
  mechanics_->forget(stuck_ != before_);
}

void Friction::decide(double t, const double* y) {
  // At first, all that are at rest stick.
  forgetSeen();
  const std::size_t most = 10 * atRest_.size() + 50;
  bool oneByOne = isBreakaway_;
  for (std::size_t round = 0; !atRest_.empty() && round < most; ++round) {
    const JointAnswer answer = mechanics_->answer(t, y);
    learn(answer);
    if (!correct(answer, oneByOne)) break;
    takeDirections();
    // A joint that breaks loose and sticks by turns, one by one, does so by rounding: it may slide.
    const bool comesBack = stuck_ == earlier_;
    if (comesBack && oneByOne && stuck_.size() < before_.size()) break;
    oneByOne = oneByOne || comesBack || round > atRest_.size() + 5;
  }
  if (!stuck_.empty()) momentsAt(t, y);
}

bool Friction::correct(const JointAnswer& answer, bool oneByOne) {
  const Eigen::Index others = n_ - 1;
  const Eigen::Map<const Numbers> alpha(answer.accelerations, n_);
  const double ofOthers = others > 0 ? (alpha.tail(others) - alpha.head(others)).abs().maxCoeff() : 0;
  const double largest = std::max(std::abs(alpha[0]), ofOthers);

  // Those that would move against their friction stick again.
  bool changes = false;
  for (const int i : atRest_) {
    if (direction_[i] * relative(answer.accelerations, i) >= -slack * largest) continue;
    direction_[i] = 0;
    changes = true;
  }
  // Of those that break loose, all; or the one with the most torque for its breakaway torque, for its start
  // may let others hold.
  const auto loosen = [&](int i) { direction_[i] = answer.moments[i] > 0 ? -1 : 1; };
  int first = -1;
  for (const int i : atRest_) {
    if (slides(i) || stickDue(i, answer.moments) <= 0) continue;
    if (oneByOne) {
      const auto ratio = [&](int of) { return std::abs(answer.moments[of]) / breakaway_[of]; };
      if (first < 0 || ratio(i) > ratio(first)) first = i;
    } else {
      loosen(i);
      changes = true;
    }
  }
  if (first >= 0) loosen(first);
  return changes || first >= 0;
}

// ---- The kind --------------------------------------------------------------------------------------

namespace {

class FrictionKind : public EffectKind {
 public:
  std::vector<JointKey> jointKeys() const override {
    return {{"friction", nullptr, NumberRule::from(0, "N m"), false, false, "friction"},
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

  std::unique_ptr<Effect> make(const Scene& scene) const override {
    auto effect = std::make_unique<Friction>(scene.chain);
    return effect->empty() ? nullptr : std::move(effect);
  }

  /// Friction at rest is not a function of the state: kane.h takes it from the recursion.
  void addDense(const Scene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&,
                const DenseActions&) const override {}

  double dryFrictionIn(const Joint& joint) const override { return joint.other("friction"); }
  /// It has no energy.
  bool isInEquilibrium() const override { return false; }
  Symbol symbolOf(const Joint& joint) const override {
    return mayStick(joint) ? Symbol::brake : Symbol::none;
  }
  void summarize(const Scene& scene, SceneWords& words) const override {
    int rubs = 0;
    for (const Joint& joint : scene.chain.joints()) rubs += mayStick(joint);
    if (rubs > 0) words.count(rubs, "rubbing joint");
  }
};

}  // namespace

const EffectKind& frictionKind() {
  static const FrictionKind kind;
  return kind;
}

}  // namespace planar_chain
