#include "effects/motors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "simd/elementary.h"

namespace planar_chain {

namespace {

/// While a torque lags, steps are so short that its series has no cancellation: in a joint that is held it
/// moves nothing, and no error estimate sees it. It lags no longer when x differs from u by less than a
/// rounding of what it was.
constexpr double longestByLags = 3, lagsToTheEnd = 39;

// ---- One motor -------------------------------------------------------------------------------------

class Motor {
 public:
  Motor(const Coordinates& coordinates, int joint, const Joint& values)
      : q(coordinates, joint),
        limit_(values.other("effort_limit")),
        slope_(values.has(noLoadSpeed) ? limit_ / values.other(noLoadSpeed) : 0),
        lag_(values.other(timeConstant)) {}

  Coordinate q;  ///< of the joint

  /// u from t on.
  void command(double t, double u) {
    if (lagged(t) == u_) x0_ = u_;  // it has arrived, and stays for times before t too
    if (u == u_) return;
    x0_ = lagged(t);
    t0_ = t;
    u_ = u;
    isNew_ = true;
  }
  void finish() {
    x0_ = u_;
    isNew_ = true;
  }
  /// x at t, N m.
  double lagged(double t) const {
    const bool isOver = !(t - t0_ < lagsToTheEnd * lag_);
    return lag_ == 0 || isOver ? u_ : u_ + (x0_ - u_) * simd::exp(-(t - t0_) / lag_);
  }
  double rate(double t) const { return lag_ > 0 ? (u_ - lagged(t)) / lag_ : 0; }
  /// True if x changes from t on.
  bool isLagging(double t) const { return lag_ > 0 && lagged(t) != u_; }
  bool hasLag() const { return lag_ > 0; }
  double lag() const { return lag_; }
  /// Returns the coefficient k > 0 of the Taylor series of x around t, x_k = (x − u) (−1/T)^k / k!. Call it
  /// for 1, 2, … in turn.
  double order(int k, double t) {
    if (k == 1) coefficient_ = lag_ > 0 ? lagged(t) - u_ : 0;
    if (lag_ > 0) coefficient_ /= -lag_ * k;
    return coefficient_;
  }

  bool hasLine() const { return slope_ > 0; }
  /// The torque for x at the rate q̇, in any regime.
  double torqueOf(double x, double rate) const {
    if (!hasLine()) return x;
    const double side = signOf(x);
    return side * std::min(side * x, std::max(0.0, limitAt(side, rate)));
  }
  /// The torque in the present regime.
  double torque(double t, const double* omega) const {
    if (regime_ == Regime::free) return lagged(t);
    return regime_ == Regime::line ? side_ * limitAt(side_, q(omega)) : 0;
  }
  /// −∂τ/∂q̇ in the present regime.
  double damping() const { return regime_ == Regime::line ? slope_ : 0; }
  bool isFree() const { return regime_ == Regime::free; }
  /// ∂τ/∂u in the present regime, so many s after u changed.
  double share(double acting) const {
    return !isFree() ? 0 : lag_ == 0 ? 1 : 1 - simd::exp(-std::min(acting / lag_, lagsToTheEnd));
  }

  /// Chooses the regime. At its edge, the line acts.
  void choose(double t, const double* omega) {
    isNew_ = false;
    if (!hasLine()) return;
    const double x = lagged(t);
    side_ = signOf(x);
    const double limit = limitAt(side_, q(omega));
    const bool isWithin = side_ * x < limit || (x == 0 && u_ == 0);
    regime_ = isWithin ? Regime::free : limit > 0 ? Regime::line : Regime::idle;
  }
  /// Two event functions, N m: one of them is above 0 if another regime is due.
  void events(double t, const double* omega, double* g) const;
  /// Their derivatives; a: q̈ of the joints.
  void slopes(double t, const double* omega, const double* a, double* slope) const;
  double noise(const double* omega) const {
    constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
    return rounding * (limit_ + slope_ * sumOfSizes(omega, q));
  }
  bool isDue(double t, const double* omega) const {
    double g[2];
    events(t, omega, g);
    return isNew_ || g[0] > 0 || g[1] > 0;
  }

 private:
  enum class Regime { free, line, idle };

  /// l
  double limitAt(double side, double rate) const { return limitAt(side, rate, limit_); }
  double limitAt(double side, double rate, double atRest) const { return atRest - side * slope_ * rate; }
  double signOf(double x) const { return x < 0 || (x == 0 && u_ < 0) ? -1 : 1; }
  /// Two functions of x and q̇, N m. A change is due where one is positive; from `free` only if s x is, too.
  double gap(int which, double x, double rate) const { return gap(which, x, rate, limit_); }
  /// That function for this limit at rest; for 0, with the derivatives of x and q̇, its derivative.
  double gap(int which, double x, double rate, double limitAtRest) const {
    if (regime_ == Regime::free) {
      const double side = which == 0 ? 1 : -1;
      return side * x - limitAt(side, rate, limitAtRest);
    }
    const double limit = limitAt(side_, rate, limitAtRest);
    if (regime_ == Regime::line) return which == 0 ? limit - side_ * x : -limit;
    return which == 0 ? limit : -side_ * x;
  }

  double limit_, slope_, lag_;  ///< L, N m; L/ω_0, N m s/rad, 0: no line; T, s, 0: no lag
  double u_ = 0, x0_ = 0, t0_ = 0;
  double coefficient_ = 0;  ///< of the last order
  Regime regime_ = Regime::free;
  double side_ = 1;     ///< s, unless it is free
  bool isNew_ = false;  ///< u has changed since choose()
};

void Motor::events(double t, const double* omega, double* g) const {
  const double x = lagged(t), rate = q(omega), noise = this->noise(omega);
  g[0] = gap(0, x, rate) - noise;
  g[1] = gap(1, x, rate) - noise;
  if (regime_ != Regime::free) return;
  g[0] = std::min(g[0], x - noise);
  g[1] = std::min(g[1], -x - noise);
}

void Motor::slopes(double t, const double* omega, const double* a, double* slope) const {
  const double x = lagged(t), rate = q(omega), xd = this->rate(t);
  slope[0] = gap(0, xd, q(a), 0);
  slope[1] = gap(1, xd, q(a), 0);
  if (regime_ != Regime::free) return;
  if (x < gap(0, x, rate)) slope[0] = xd;
  if (-x < gap(1, x, rate)) slope[1] = -xd;
}

bool isMoved(const Joint& joint) {
  return joint.has(noLoadSpeed) || joint.other(timeConstant) > 0;
}

bool isDelayed(const Joint& joint) {
  return joint.other("command_delay") > 0;
}

// ---- All of a chain ---------------------------------------------------------------------------------

/// Commands in a chain with motors.
class MotorCommands final : public CommandEffect, public Events, private ode::EventFunctions {
 public:
  MotorCommands(const Chain& chain, int capacity)
      : CommandEffect(chain, capacity), coordinates_(chain.coordinates()), n_(chain.size()) {
    for (int i = 0; i < n_; ++i) {
      const Joint& joint = chain.joints()[index(i)];
      has_.push_back(isMoved(joint));
      if (has_.back()) motors_.emplace_back(coordinates_, i, joint);
    }
    remembered_ = motors_;
    forLines([this](const Motor&) { ++lines_; });
  }

  std::vector<Load> inForce(double t, const double* omega) const override {
    std::vector<Load> loads = CommandEffect::inForce(t, omega);
    for (const Motor& motor : motors_) {
      const double commanded = torqueAt(t, index(motor.q.joint));
      const double x = omega && motor.hasLag() ? motor.lagged(t) : commanded;
      const double torque = omega ? motor.torqueOf(x, motor.q(omega)) : x;
      if (torque != 0) loads.push_back({"motor", Load::none, {}, {}, 0, motor.q.joint, torque});
    }
    return loads;
  }
  std::vector<LinearMotor> motorsAt(double t, const double* omega) const override {
    std::vector<LinearMotor> all = CommandEffect::motorsAt(t, omega);
    auto one = all.begin();
    for (Motor motor : motors_) {
      motor.command(t, torqueAt(t, index(motor.q.joint)));
      motor.choose(t, omega);
      while (one->joint != motor.q.joint) ++one;
      *one = {one->joint, motor.lag(), one->isCutOff, motor.isFree(), motor.damping()};
    }
    return all;
  }
  void remember() override {
    CommandEffect::remember();
    remembered_ = motors_;
  }
  void recall() override {
    CommandEffect::recall();
    motors_ = remembered_;
  }
  void saveOrRestore(Snapshot& snapshot) override {
    CommandEffect::saveOrRestore(snapshot);
    for (Motor& motor : motors_) snapshot(motor);
    snapshot(isLagging_, act_);
  }
  void finish(double t) override {
    for (Motor& motor : motors_) {
      motor.command(t, torqueAt(t, index(motor.q.joint)));
      motor.finish();
    }
  }

  LoadKind acting() const override {
    return std::max(CommandEffect::acting(), act_ ? LoadKind::moments : LoadKind::nothing);
  }
  bool variesWithTime() const override { return isLagging_ || CommandEffect::variesWithTime(); }
  Powers apply(const ChainState& at, const Actions& to) override {
    Powers powers = CommandEffect::apply(at, to);
    for (const Motor& motor : motors_) {
      const double torque = motor.torque(at.t, at.omega);
      coordinates_.addTorque(torque, motor.q.joint, to.N);
      powers.supplied += torque * motor.q(at.omega);
    }
    return powers;
  }
  void addTorques(const ChainState& at, double* tau) override {
    CommandEffect::addTorques(at, tau);
    for (const Motor& motor : motors_) tau[motor.q.joint] += motor.torque(at.t, at.omega);
  }
  void addStiffness(double* /*k*/, double* d) const override {
    for (const Motor& motor : motors_) d[motor.q.joint] += motor.damping();
  }
  Powers powersAlong(const ChainState& at, const StateChange& along) override {
    Powers change = CommandEffect::powersAlong(at, along);
    for (const Motor& motor : motors_) {
      const double byRate = motor.torque(at.t, at.omega) - motor.damping() * motor.q(at.omega);
      change.supplied += byRate * motor.q(along.v);
    }
    return change;
  }
  Powers applyRates(const ChainState& at, const Actions& to) override {
    Powers rates = CommandEffect::applyRates(at, to);
    for (const Motor& motor : motors_) {
      if (!motor.isFree()) continue;
      const double rate = motor.rate(at.t);
      coordinates_.addTorque(rate, motor.q.joint, to.N);
      rates.supplied += rate * motor.q(at.omega);
    }
    return rates;
  }
  void addOrder(int k, const Series& known, const Actions& to) override {
    CommandEffect::addOrder(k, known, to);
    for (Motor& motor : motors_) {
      if (motor.isFree()) coordinates_.addTorque(motor.order(k, known.t), motor.q.joint, to.N);
    }
  }

  Events* events() override { return lines_ > 0 ? this : nullptr; }
  void enterState(double t, const double* y) override {
    for (Motor& motor : motors_) motor.choose(t, y + n_);
  }
  void fire(double t, double* y, const ode::LocatedEvent& /*located*/) override {
    for (Motor& motor : motors_) {
      if (motor.isDue(t, y + n_)) motor.choose(t, y + n_);
    }
  }
  void addEvents(ode::EventList& to) const override { to.push_back(this); }

 private:
  // Two event functions of each motor with a line.
  template <class Visit>
  void forLines(const Visit& visit) const {
    for (const Motor& motor : motors_) {
      if (motor.hasLine()) visit(motor);
    }
  }
  int most() const override { return 2 * lines_; }
  void values(double t, const double* y, double* g) const override {
    forLines([&](const Motor& motor) { motor.events(t, y + n_, std::exchange(g, g + 2)); });
  }
  void noise(double /*t*/, const double* y, double* of) const override {
    forLines([&](const Motor& motor) { of = std::fill_n(of, 2, motor.noise(y + n_)); });
  }
  bool haveSlopes() const override { return true; }
  void slopes(double t, const double* y, const double* accelerations, double* slope) const override {
    forLines(
        [&](const Motor& motor) { motor.slopes(t, y + n_, accelerations, std::exchange(slope, slope + 2)); });
  }
  /// The line is a damper.
  bool changeStiffness() const override { return true; }

  void list(double t) override {
    CommandEffect::list(t);
    isLagging_ = act_ = false;
    for (Motor& motor : motors_) {
      motor.command(t, torqueAt(t, index(motor.q.joint)));
      const bool isLagging = motor.isLagging(t);
      if (isLagging) {
        isLagging_ = true;
        stepAtMost(longestByLags * motor.lag());
        const double end = t + (lagsToTheEnd + 1) * motor.lag();
        if (end > t) endBy(end);
      }
      act_ = act_ || isLagging || motor.lagged(t) != 0;
    }
  }
  double passedOn(int joint, double acting) const override {
    const auto is = [joint](const Motor& motor) { return motor.q.joint == joint; };
    const auto motor = std::find_if(motors_.begin(), motors_.end(), is);
    return motor == motors_.end() ? 1 : motor->share(acting);
  }
  bool hasMotor(int joint) const override { return joint != Load::none && has_[index(joint)]; }

  Coordinates coordinates_;
  int n_;
  std::vector<Motor> motors_, remembered_;
  std::vector<bool> has_;  ///< of each joint: a motor
  int lines_ = 0;
  bool isLagging_ = false, act_ = false;
};

}  // namespace

bool changesCommands(const Joint& joint) {
  return isMoved(joint) || isDelayed(joint);
}

std::unique_ptr<CommandEffect> makeCommands(const Chain& chain, int capacity) {
  if (capacity == 0) return nullptr;
  const std::vector<Joint>& joints = chain.joints();
  if (std::none_of(joints.begin(), joints.end(), isMoved))
    return std::make_unique<CommandEffect>(chain, capacity);
  return std::make_unique<MotorCommands>(chain, capacity);
}

std::vector<LinearMotor> steadyMotors(const Chain& chain, const double* tau, const double* omega) {
  constexpr double forever = std::numeric_limits<double>::infinity();
  const std::unique_ptr<CommandEffect> commands = makeCommands(chain, chain.size());
  for (int i = 0; i < chain.size(); ++i)
    commands->hold({Load::none, {}, {}, 0, i, tau[i], -forever, forever}, -commands->delayOf(i));
  commands->enter(0);
  commands->finish(0);
  return commands->motorsAt(0, omega);
}

// ---- The kind ----------------------------------------------------------------------------------------

namespace {

constexpr double leastLag = 1e-6;    // s; a step has to resolve it
constexpr double leastSpeed = 1e-6;  // rad/s; the torque falls by the effort limit within it

class MotorKind : public EffectKind {
 public:
  const std::vector<JointKey>& jointKeys() const override {
    constexpr double forever = std::numeric_limits<double>::infinity();
    const char* map = "motor";
    static const std::vector<JointKey> keys{
        {noLoadSpeed, nullptr, {" >= 1e-6 rad/s", leastSpeed, forever, true}, false, false, nullptr, map},
        {timeConstant, nullptr, {", 0 or >= 1e-6 s", leastLag, forever, true}, false, false, nullptr, map},
        {"command_delay", nullptr, NumberRule::from(0, "s")}};
    return keys;
  }
  void judge(const Joint& joint, std::vector<Fault>& faults) const override {
    for (const JointKey& key : jointKeys()) {
      if (key.of(joint) != 0 || (joint.has(key.name) && key.name == std::string(noLoadSpeed)))
        key.range.check(faults, std::string("joint/") + key.name, key.of(joint));
    }
    if (joint.has(noLoadSpeed) && !joint.has("effort_limit")) {
      faults.push_back({"joint/effort_limit",
                        "an effort_limit beside motor/no_load_speed, the torque at rest", "nothing"});
    }
  }
  /// Without commands no motor acts.
  std::unique_ptr<Effect> make(const Scene&) const override { return nullptr; }
  void summarize(const Scene& scene, SceneWords& words) const override {
    words.countJoints(scene.chain, isMoved, "motor");
    words.countJoints(scene.chain, isDelayed, "command delay");
  }
};

}  // namespace

const EffectKind& motorKind() {
  static const MotorKind kind;
  return kind;
}

}  // namespace planar_chain
