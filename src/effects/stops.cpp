#include "effects/stops.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "effects/first_due.h"
#include "effects/passing.h"

namespace planar_chain {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

enum class Place { free, pushing, parted };

struct Stop {
  Coordinate q;  ///< of the joint
  double limit;
  double sign;  ///< + upper, − lower
  double k, d;
  Place place = Place::free;

  double depth(const double* theta) const { return sign * (q(theta) - limit); }
  double speed(const double* omega) const { return sign * q(omega); }
  /// Bounds the rounding error of depth(), rad.
  double rounding(const double* theta) const {
    return 4 * epsilon * (sumOfSizes(theta, q) + std::abs(limit));
  }
  /// How far the change to another place is due, rad; ≤ 0: it is not. A push must be wrong by more than
  /// rounding: in an overdamped stop k x and d ẋ cancel, and s is below the rounding of either.
  double due(const double* theta, const double* omega) const {
    const double x = depth(theta);
    if (place == Place::free) return x;
    const double push = x + d / k * speed(omega);
    const double noise = this->noise(theta, omega);
    return place == Place::pushing ? -push - noise : std::max(-x, push - noise);
  }
  /// Bounds the rounding error of x + (d/k) ẋ, rad.
  double noise(const double* theta, const double* omega) const {
    return rounding(theta) + d / k * 4 * epsilon * sumOfSizes(omega, q);
  }
  /// The same of due().
  double noiseOfDue(const double* theta, const double* omega) const {
    const bool isOfDepth = place == Place::free || (place == Place::parted && depth(theta) < 0);
    return isOfDepth ? rounding(theta) : noise(theta, omega);
  }
  Place next(double x, double xd) const {
    if (!(x > 0)) return Place::free;
    return k * x + d * xd > 0 ? Place::pushing : Place::parted;
  }
};

std::array<double, 4> operator-(const std::array<double, 4>& g) {
  return {-g[0], -g[1], -g[2], -g[3]};
}

class Stops : public Effect, public Switching {
 public:
  explicit Stops(const Chain& chain) : coordinates_(chain.coordinates()), n_(chain.size()) {
    for (int i = 0; i < n_; ++i) {
      const Joint& joint = chain.joints()[static_cast<std::size_t>(i)];
      for (const double sign : {-1.0, 1.0}) {
        const double limit = sign > 0 ? joint.upper : joint.lower;
        if (std::isfinite(limit))
          stops_.push_back({{coordinates_, i}, limit, sign, joint.stopStiffness, joint.stopDamping});
      }
    }
    active_.reserve(stops_.size());
  }
  bool empty() const { return stops_.empty(); }

  LoadKind mostActing() const override { return LoadKind::moments; }
  LoadKind acting() const override { return active_.empty() ? LoadKind::nothing : LoadKind::moments; }
  bool hasPower() const override {
    return std::any_of(stops_.begin(), stops_.end(), [](const Stop& stop) { return stop.d > 0; });
  }
  Powers apply(const ChainState& at, const Actions& to) override {
    return {0, addUp(at.theta, at.omega,
                     [&](int joint, double torque) { coordinates_.addTorque(torque, joint, to.N); })};
  }
  void addTorques(const ChainState& at, double* tau) override {
    addUp(at.theta, at.omega, [&](int joint, double torque) { tau[joint] += torque; });
  }
  void addStiffness(double* k, double* d) const override {
    for (const Stop* stop : active_) {
      if (stop->place != Place::pushing) continue;
      k[stop->q.joint] += stop->k;
      d[stop->q.joint] += stop->d;
    }
  }
  Powers powersAlong(const ChainState& at, const StateChange& along) override {
    double change = 0;
    for (const Stop* stop : active_) {
      const double x = stop->depth(at.theta), xd = stop->speed(at.omega);
      const double du = stop->sign * stop->q(along.u);
      const double dv = stop->sign * stop->q(along.v);
      change += stop->place == Place::pushing ? 2 * stop->d * xd * dv : -stop->k * (x * dv + xd * du);
    }
    return {0, change};
  }

  Switching* switching() override { return this; }
  void enterState(double /*t*/, const double* y) override {
    for (Stop& stop : stops_) stop.place = stop.next(stop.depth(y), stop.speed(y + n_));
    listActive();
  }
  void takeFrom(const Switching& other) override {
    const std::vector<Stop>& theirs = static_cast<const Stops&>(other).stops_;
    for (std::size_t k = 0; k < stops_.size(); ++k) stops_[k].place = theirs[k].place;
    listActive();
  }
  void change(double /*t*/, double* y, const ode::Crossing& /*found*/) override {
    for (Stop& stop : stops_) {
      if (stop.due(y, y + n_) > 0) stop.place = stop.next(stop.depth(y), stop.speed(y + n_));
    }
    listActive();
  }
  double due(double /*t*/, const Eigen::VectorXd& y) const override {
    double most = -std::numeric_limits<double>::infinity();
    for (const Stop& stop : stops_) {
      most = std::max(most, stop.due(y.data(), y.data() + n_));
    }
    return most;
  }
  double nearest(const ode::Stretch& of) const override {
    const Eigen::VectorXd &y = of.y, &next = of.next;
    const double h = of.h;
    double first = 1;
    for (const Stop& stop : stops_) {
      const double x0 = stop.depth(y.data()), x1 = stop.depth(next.data());
      const double v0 = stop.speed(y.data() + n_) * h, v1 = stop.speed(next.data() + n_) * h;
      // A cubic stays below its Bézier points, and most joints are far from their stops.
      const bool isNear = x0 > 0 || mayPass(std::max(x0, x1), std::max(x0 + v0 / 3, x1 - v1 / 3), 0);
      if (stop.place == Place::free && !isNear) continue;
      // through both ends: x = x0 + v0 s + b s² + c s³, and x + lag ẋ
      const std::array<double, 4> depth = cubic(x0, v0, x1, v1);
      const double lag = stop.d / (stop.k * h);
      const std::array<double, 4> push{x0 + lag * v0, v0 + 2 * lag * depth[2], depth[2] + 3 * lag * depth[3],
                                       depth[3]};
      const double noise = stop.rounding(y.data());
      const double pushNoise = noise * (1 + 5 * lag);
      // So both ends are not above 0: as in due(). Rounding since change() may have lifted the first one.
      const double allowed =
          std::max(stop.noise(y.data(), y.data() + n_), stop.noise(next.data(), next.data() + n_));
      const auto less = [](std::array<double, 4> g, double by) {
        g[0] -= std::max(by, g[0]);
        return g;
      };
      if (stop.place == Place::free) first = std::min(first, passing(less(depth, 0), noise));
      if (stop.place == Place::pushing) first = std::min(first, passing(less(-push, allowed), pushNoise));
      if (stop.place == Place::parted)
        first = std::min({first, passing(less(-depth, 0), noise), passing(less(push, allowed), pushNoise)});
    }
    return first < 1 ? first * h : -1;
  }
  /// A joint shakes on a spring, or beside others that are hit.
  bool mayHide(const ode::Stretch& of, bool isLong) const override {
    return isLong && std::any_of(stops_.begin(), stops_.end(), [&](const Stop& stop) {
             const double x0 = stop.depth(of.y.data()), x1 = stop.depth(of.next.data());
             const double v0 = stop.speed(of.y.data() + n_), v1 = stop.speed(of.next.data() + n_);
             return mayReach(x0, v0 * of.h, x1, v1 * of.h);
           });
  }
  double hidden(const ode::Stretch& step) const override {
    double first = 1;
    for (const Stop& stop : stops_) {
      const double noise = stop.rounding(step.y.data()), lag = stop.d / (stop.k * step.h);
      const double pushNoise = noise * (1 + 12 * lag);
      const double allowed = std::max(stop.noise(step.y.data(), step.y.data() + n_),
                                      stop.noise(step.next.data(), step.next.data() + n_));
      if (stop.place == Place::free) first = std::min(first, hidden(stop, step, 1, 0, 0, noise));
      if (stop.place == Place::pushing)
        first = std::min(first, hidden(stop, step, -1, lag, allowed, pushNoise));
      if (stop.place == Place::parted) {
        first = std::min(
            {first, hidden(stop, step, -1, 0, 0, noise), hidden(stop, step, 1, lag, allowed, pushNoise)});
      }
    }
    return first < 1 ? first * step.h : -1;
  }
  std::optional<ode::Crossing> crossing(const ode::Stretch& of) const override {
    const double* next = of.next.data();
    std::optional<ode::Crossing> first = firstDueOf(
        stops_, of, [this](const Stop& stop, const double* y) { return stop.due(y, y + n_); },
        [&](const Stop& stop) { return 2 * stop.noiseOfDue(next, next + n_); });
    if (first) first->changesStiffness = true;
    return first;
  }

 private:
  /// True if a joint may come to 0 between these places, with these rates. It may go farther than the rates
  /// take it: there and back, and more.
  static bool mayReach(double x0, double v0, double x1, double v1) {
    constexpr double farther = 4;
    return std::max(x0, x1) + farther * (std::abs(x1 - x0) + std::abs(v0) + std::abs(v1)) > 0;
  }
  /// A place within a step where g = sign (x + lag ẋ) − allowed may be above 0 by more than `noise`; 1: there
  /// is none. ẋ is that per step.
  double hidden(const Stop& stop, const ode::Stretch& step, double sign, double lag, double allowed,
                double noise) const {
    const double h = step.h;
    const double x0 = sign * stop.depth(step.y.data()), v0 = sign * stop.speed(step.y.data() + n_) * h;
    const double x1 = sign * stop.depth(step.next.data()), v1 = sign * stop.speed(step.next.data() + n_) * h;
    const std::array<double, 4> by = cubic(x0, v0, x1, v1);
    const double bend0 = 2 * by[2], bend1 = 2 * by[2] + 6 * by[3];
    if (!mayReach(x0 + lag * v0 - allowed, v0 + lag * bend0, x1 + lag * v1 - allowed, v1 + lag * bend1))
      return 1;

    // The quintic may be wrong by as much as it differs from the cubic.
    const auto bendAt = [&](double t) {
      return sign * stop.speed(step.course->accelerationsAt(t).data()) * (h * h);
    };
    const double a0 = bendAt(step.t), a1 = bendAt(step.t + h);
    const auto due = [&](double top) {
      Bezier x = bezier({x0, v0, a0}, {x1, v1, a1}, top);
      const Bezier slope = slopeOf(x);
      for (std::size_t k = 0; k < x.size(); ++k) x[k] += lag * slope[k];
      // So it is not above 0 at the start: rounding since change() may have lifted it.
      const double shift = std::max(allowed, x[0]);
      for (double& g : x) g -= shift;
      return x;
    };
    const Bezier quintic = due(0);
    const double apart = (1 + 12 * lag) * std::max(std::abs(a0 - bend0), std::abs(a1 - bend1)) / 20;
    if (*std::max_element(quintic.begin(), quintic.end()) + apart <= noise) return 1;
    const double top = sign * stop.speed(step.course->bend().data());
    return aboveBefore(due(top + std::abs(top)), noise);
  }
  /// Lists those that do something now.
  void listActive() {
    active_.clear();
    for (const Stop& stop : stops_) {
      if (stop.place != Place::free) active_.push_back(&stop);
    }
  }
  /// Calls add(joint, torque) for each that pushes, + on the joint's own link. Returns P_d, W.
  template <class Add>
  double addUp(const double* theta, const double* omega, Add&& add) const {
    double dissipated = 0;
    for (const Stop* stop : active_) {
      const double x = stop->depth(theta);
      const double xd = stop->speed(omega);
      if (stop->place == Place::pushing) {
        add(stop->q.joint, -stop->sign * (stop->k * x + stop->d * xd));
        dissipated += stop->d * xd * xd;
      } else {
        dissipated -= stop->k * x * xd;
      }
    }
    return dissipated;
  }

  Coordinates coordinates_;
  int n_;
  std::vector<Stop> stops_;
  std::vector<const Stop*> active_;
};

// ---- Their kind --------------------------------------------------------------------------------

constexpr double none = std::numeric_limits<double>::infinity();

class StopKind : public EffectKind {
 public:
  std::vector<JointKey> jointKeys() const override {
    return {{"lower", &Joint::lower, angle_},
            {"upper", &Joint::upper, angle_},
            {"stop_stiffness", &Joint::stopStiffness, stiffness_},
            {"stop_damping", &Joint::stopDamping, damping_}};
  }
  /// −∞ and ∞ are no limits.
  void judge(const Joint& joint, std::vector<Fault>& faults) const override {
    if (joint.lower != -none) angle_.check(faults, "joint/lower", joint.lower);
    const NumberRule above{" > lower, in rad", joint.lower, none, false};
    if (joint.upper != none) {
      (joint.upper <= joint.lower ? above : angle_).check(faults, "joint/upper", joint.upper);
    }
    const NumberRule noStop{" only beside lower or upper", 0, 0, true};
    (joint.isLimited() ? stiffness_ : noStop).check(faults, "joint/stop_stiffness", joint.stopStiffness);
    (joint.isLimited() ? damping_ : noStop).check(faults, "joint/stop_damping", joint.stopDamping);
  }

  std::unique_ptr<Effect> make(const Scene& scene) const override {
    return makeUnlessEmpty<Stops>(scene.chain);
  }

  /// τ_i = s_lower − s_upper; s = k x + d ẋ where x > 0 and s > 0
  void addDense(const Scene& scene, double /*t*/, const Eigen::VectorXd& q, const Eigen::VectorXd& qd,
                const DenseActions& to) const override {
    for (int i = 0; i < scene.chain.size(); ++i) {
      const Joint& joint = scene.chain.joints()[static_cast<std::size_t>(i)];
      const auto push = [&](double x, double xd) {
        const double s = joint.stopStiffness * x + joint.stopDamping * xd;
        return x > 0 && s > 0 ? s : 0;
      };
      to.tau(i) += push(joint.lower - q(i), -qd(i)) - push(q(i) - joint.upper, qd(i));
    }
  }

  /// V = ½ k x²
  double energyIn(const Joint& joint, double q) const override {
    const double depth = std::max({0.0, q - joint.upper, joint.lower - q});
    return 0.5 * (joint.stopStiffness * depth * depth);
  }
  double stiffnessOf(const Joint& joint) const override { return joint.stopStiffness; }

  Symbol symbolOf(const Joint& joint) const override {
    return joint.isLimited() ? Symbol::coil : Symbol::none;
  }
  void summarize(const Scene& scene, SceneWords& words) const override {
    int limits = 0;
    for (const Joint& joint : scene.chain.joints()) {
      limits += std::isfinite(joint.lower) + std::isfinite(joint.upper);
    }
    words.count(limits, "joint limit");
  }

 private:
  const NumberRule angle_ = NumberRule::any("rad");
  const NumberRule stiffness_{" > 0 N m/rad, beside lower or upper", 0, 1e100, false, ", at most 1e100"};
  const NumberRule damping_ = NumberRule::coefficient("N m s/rad");
};

}  // namespace

const EffectKind& stopKind() {
  static const StopKind kind;
  return kind;
}

}  // namespace planar_chain
