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

/// The quintic x(s), 0 ≤ s ≤ 1, x(0) = 0, through x(1), and ẋ and ẍ at both ends, s times a power of h.
class Quintic {
 public:
  Quintic(double x1, double v0, double v1, double a0, double a1)
      : c_{v0, a0 / 2, 10 * x1 - 6 * v0 - 4 * v1 - (3 * a0 - a1) / 2,
           -15 * x1 + 8 * v0 + 7 * v1 + (3 * a0 - 2 * a1) / 2, 6 * x1 - 3 * (v0 + v1) + (a1 - a0) / 2} {}

  double value(double s) const { return s * (c_[0] + s * (c_[1] + s * (c_[2] + s * (c_[3] + s * c_[4])))); }
  double rate(double s) const {
    return c_[0] + s * (2 * c_[1] + s * (3 * c_[2] + s * (4 * c_[3] + s * 5 * c_[4])));
  }
  double acceleration(double s) const {
    return 2 * c_[1] + s * (6 * c_[2] + s * (12 * c_[3] + s * 20 * c_[4]));
  }

 private:
  double c_[5];
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
  within_.resize(2 * n_);
  for (Seen& seen : seen_) {
    seen.moments.resize(n_);
    seen.accelerations.resize(n_);
  }
  forget();
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
  const Step step = stepOf(t, y, next, h);
  double first = 1;
  // q̇ at the middle by Hermite's cubic.
  for (const Rub& rub : rubs_) {
    if (rub.direction == 0) continue;
    const double v0 = rub.slideDue(y.data() + n_), v1 = rub.slideDue(next.data() + n_);
    const double bend = relative(step.begin.accelerations.data(), rub.joint) -
                        relative(step.end.accelerations.data(), rub.joint);
    first = std::min(first, passing(v0, (v0 + v1) / 2 - rub.direction * h * bend / 8, v1));
  }
  if (!anySticks()) return first < 1 ? first * h : -1;

  // μ at the start, at the middle, and at the end.
  const Seen& middle = middleOf(step);
  for (const Rub& rub : rubs_) {
    if (rub.direction != 0) continue;
    for (const double sign : {-1.0, 1.0}) {
      const auto over = [&](const Seen& at) {
        return sign * at.moments[rub.joint] - rub.breakaway * (1 + slack);
      };
      first = std::min(first, passing(over(step.begin), over(middle), over(step.end)));
    }
  }
  return first < 1 ? first * h : -1;
}

// ---- Within a step -------------------------------------------------------------------------------

void Friction::forget() {
  for (Seen& seen : seen_) seen.t = std::numeric_limits<double>::quiet_NaN();
  if (mechanics_) mechanics_->forget();
}

template <class Ask>
const Friction::Seen& Friction::seen(double t, Ask&& ask) const {
  for (const Seen& seen : seen_) {
    if (seen.t == t) return seen;
  }
  const JointAnswer answer = ask();
  Seen& to = seen_[oldest_];
  oldest_ = (oldest_ + 1) % seen_.size();
  to.t = t;
  std::copy_n(answer.moments, n_, to.moments.data());
  std::copy_n(answer.accelerations, n_, to.accelerations.data());
  return to;
}

Friction::Step Friction::stepOf(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& next,
                                double h) const {
  return {t, h, y, next, seen(t, [&] { return mechanics_->answerAside(t, y.data()); }), seen(t + h, [&] {
            return mechanics_->answer(t + h, next.data());
          })};
}

JointAnswer Friction::within(const Step& step, double s) const {
  // The quintic is linear in what it goes through.
  const double h = step.h;
  const Quintic ofTurn(1, 0, 0, 0, 0), ofV0(0, h, 0, 0, 0), ofV1(0, 0, h, 0, 0), ofA0(0, 0, 0, h * h, 0),
      ofA1(0, 0, 0, 0, h * h);
  const auto theta0 = step.y.head(n_), theta1 = step.next.head(n_), v0 = step.y.segment(n_, n_),
             v1 = step.next.segment(n_, n_);
  const auto along = [&](auto part) {
    return part(ofTurn) * (theta1 - theta0) + part(ofV0) * v0 + part(ofV1) * v1 +
           part(ofA0) * step.begin.accelerations + part(ofA1) * step.end.accelerations;
  };
  within_.head(n_) = theta0 + along([s](const Quintic& of) { return of.value(s); });
  within_.tail(n_) = along([s, h](const Quintic& of) { return of.rate(s) / h; });
  return mechanics_->answerAside(step.t + s * h, within_.data());
}

const Friction::Seen& Friction::middleOf(const Step& step) const {
  return seen(step.t + step.h / 2, [&] { return within(step, 0.5); });
}

ode::Crossing Friction::crossing(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& next,
                                 double h) const {
  const Step step = stepOf(t, y, next, h);
  ode::Crossing first;
  for (const Rub& rub : rubs_) {
    ode::Crossing own;
    if (rub.direction != 0) {
      if (rub.slideDue(next.data() + n_) > 0) own = slideCrossing(rub, step);
    } else if (rub.stickDue(step.end.moments[rub.joint]) > 0) {
      own = stickCrossing(rub, step);
    }
    if (own.slope > 0 && (!(first.slope > 0) || own.after < first.after)) first = own;
  }
  return first;
}

/// Where the joint's quintic stops.
ode::Crossing Friction::slideCrossing(const Rub& rub, const Step& step) const {
  const double h = step.h, way = -rub.direction;
  const auto of = [&](const double* absolute) { return way * relative(absolute, rub.joint); };
  const Quintic turn(of(step.next.data()) - of(step.y.data()), h * of(step.y.data() + n_),
                     h * of(step.next.data() + n_), h * h * of(step.begin.accelerations.data()),
                     h * h * of(step.end.accelerations.data()));
  // Newton's method, within a bracket.
  double low = 0, high = 1, s = turn.rate(0) / (turn.rate(0) - turn.rate(1));
  for (int k = 0; k < 50; ++k) {
    const double rate = turn.rate(s), before = s;
    (rate > 0 ? high : low) = s;
    s -= rate / turn.acceleration(s);
    if (!(s > low && s < high)) s = (low + high) / 2;
    if (std::abs(s - before) < 1e-14) break;
  }
  return {s * h, turn.acceleration(s) / (h * h)};
}

/// Where μ passes the breakaway torque: by the parabola through both ends and the middle, then by the
/// recursion.
ode::Crossing Friction::stickCrossing(const Rub& rub, const Step& step) const {
  const double sign = step.end.moments[rub.joint] > 0 ? 1 : -1;
  const auto over = [&](double mu) { return sign * mu - rub.breakaway * (1 + slack); };
  const double g0 = over(step.begin.moments[rub.joint]), g1 = over(step.end.moments[rub.joint]),
               gm = over(middleOf(step).moments[rub.joint]);
  const double bend = 2 * (g0 - 2 * gm + g1), start = 4 * gm - 3 * g0 - g1;  // g = g0 + start s + bend s²
  // The root that rises.
  const double rise = std::sqrt(std::max(0.0, start * start - 4 * bend * g0));
  double s = start > 0 ? -2 * g0 / (start + rise) : (rise - start) / (2 * bend), slope = rise;
  for (int k = 0; k < 2; ++k) {
    if (!(s > 0 && s < 1 && slope > 0)) return {};
    s -= over(within(step, s).moments[rub.joint]) / slope;
  }
  return {s * step.h, slope / step.h};
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

/// Call it when a joint sticks or slides from now on.
void Friction::takeMoments() {
  moments_.setZero();
  for (const Rub& rub : rubs_) addJointTorque(-rub.direction * rub.sliding, rub.joint, moments_.data());
  forget();
}

void Friction::decide(double t, const double* y) {
  // At first, all that are at rest stick.
  int atRest = 0;
  for (Rub& rub : rubs_) {
    if (!rub.mayStick) continue;
    ++atRest;
    rub.direction = 0;
  }
  takeMoments();
  const int most = 10 * atRest + 50;
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
    if (!changes && !first) {
      seen(t, [&] { return answer; });
      return;
    }
    takeMoments();
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
