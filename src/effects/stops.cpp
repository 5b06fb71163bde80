#include "effects/stops.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planar_chain {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

enum class Contact { free, pushing, parted };

struct Stop {
  Coordinate q;  ///< of the joint
  double limit;
  double sign;  ///< + upper, − lower
  double k, d;
  Contact contact = Contact::free;

  double depth(const double* theta) const { return sign * (q(theta) - limit); }
  double speed(const double* omega) const { return sign * q(omega); }
  /// Bounds the rounding error of depth(), rad.
  double rounding(const double* theta) const {
    return 4 * epsilon * (sumOfSizes(theta, q) + std::abs(limit));
  }
  /// Bounds the rounding error of x + (d/k) ẋ, rad.
  double noise(const double* theta, const double* omega) const {
    return rounding(theta) + d / k * 4 * epsilon * sumOfSizes(omega, q);
  }
  /// The signs of the two event functions, of x and of x + (d/k) ẋ, rad; 0: it cannot happen. A change must
  /// be due by more than rounding: in an overdamped stop k x and d ẋ cancel, and s is below the rounding of
  /// either.
  double depthSign() const { return contact == Contact::free ? 1 : contact == Contact::parted ? -1 : 0; }
  double pushSign() const { return contact == Contact::pushing ? -1 : contact == Contact::parted ? 1 : 0; }
  void events(const double* theta, const double* omega, double* g) const {
    const double x = depth(theta), push = x + d / k * speed(omega);
    g[0] = depthSign() == 0 ? ode::never : depthSign() * x - rounding(theta);
    g[1] = pushSign() == 0 ? ode::never : pushSign() * push - noise(theta, omega);
  }
  bool isDue(const double* theta, const double* omega) const {
    double g[2];
    events(theta, omega, g);
    return g[0] > 0 || g[1] > 0;
  }
  Contact next(double x, double xd) const {
    if (!(x > 0)) return Contact::free;
    return k * x + d * xd > 0 ? Contact::pushing : Contact::parted;
  }
};

class Stops : public Effect, public Events, private ode::EventFunctions {
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
      if (stop->contact != Contact::pushing) continue;
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
      change += stop->contact == Contact::pushing ? 2 * stop->d * xd * dv : -stop->k * (x * dv + xd * du);
    }
    return {0, change};
  }

  void saveOrRestore(Snapshot& snapshot) override {
    for (Stop& stop : stops_) snapshot(stop.contact);
    listActive();
  }

  Events* events() override { return this; }
  void enterState(double /*t*/, const double* y) override {
    for (Stop& stop : stops_) stop.contact = stop.next(stop.depth(y), stop.speed(y + n_));
    listActive();
  }
  void takeFrom(const Events& other) override {
    const std::vector<Stop>& theirs = static_cast<const Stops&>(other).stops_;
    for (std::size_t k = 0; k < stops_.size(); ++k) stops_[k].contact = theirs[k].contact;
    listActive();
  }
  void fire(double /*t*/, double* y, const ode::LocatedEvent& /*located*/) override {
    for (Stop& stop : stops_) {
      if (stop.isDue(y, y + n_)) stop.contact = stop.next(stop.depth(y), stop.speed(y + n_));
    }
    listActive();
  }
  void addEvents(ode::EventList& to) const override { to.push_back(this); }

 private:
  // Two event functions of each stop.
  int most() const override { return 2 * static_cast<int>(stops_.size()); }
  void values(double /*t*/, const double* y, double* g) const override {
    for (std::size_t k = 0; k < stops_.size(); ++k) stops_[k].events(y, y + n_, g + 2 * k);
  }
  void noise(double /*t*/, const double* y, double* of) const override {
    for (std::size_t k = 0; k < stops_.size(); ++k) {
      of[2 * k] = 2 * stops_[k].rounding(y);
      of[2 * k + 1] = 2 * stops_[k].noise(y, y + n_);
    }
  }
  bool haveSlopes() const override { return true; }
  void slopes(double /*t*/, const double* y, const double* accelerations, double* slope) const override {
    for (std::size_t k = 0; k < stops_.size(); ++k) {
      const Stop& stop = stops_[k];
      const double xd = stop.speed(y + n_), xdd = stop.speed(accelerations);
      slope[2 * k] = stop.depthSign() * xd;
      slope[2 * k + 1] = stop.pushSign() * (xd + stop.d / stop.k * xdd);
    }
  }
  bool changeStiffness() const override { return true; }

  /// Lists those that do something now.
  void listActive() {
    active_.clear();
    for (const Stop& stop : stops_) {
      if (stop.contact != Contact::free) active_.push_back(&stop);
    }
  }
  /// Calls add(joint, torque) for each that pushes, + on the joint's own link. Returns P_d, W.
  template <class Add>
  double addUp(const double* theta, const double* omega, Add&& add) const {
    double dissipated = 0;
    for (const Stop* stop : active_) {
      const double x = stop->depth(theta);
      const double xd = stop->speed(omega);
      if (stop->contact == Contact::pushing) {
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
  const std::vector<JointKey>& jointKeys() const override { return keys_; }
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
  const std::vector<JointKey> keys_{{"lower", &Joint::lower, angle_},
                                    {"upper", &Joint::upper, angle_},
                                    {"stop_stiffness", &Joint::stopStiffness, stiffness_},
                                    {"stop_damping", &Joint::stopDamping, damping_}};
};

}  // namespace

const EffectKind& stopKind() {
  static const StopKind kind;
  return kind;
}

}  // namespace planar_chain
