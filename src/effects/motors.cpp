#include "effects/motors.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "effects/motor.h"

namespace planar_chain {

namespace {

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
  double shareOfLag(int joint, double since) const override {
    const Motor* motor = motorOf(joint);
    return motor ? motor->shareLeft(since) : 0;
  }
  double motorTorque(double t, int joint) const override {
    const Motor* motor = motorOf(joint);
    return motor && motor->hasLag() ? motor->lagged(t) : CommandEffect::motorTorque(t, joint);
  }
  void setMotorTorque(double t, int joint, double torque) override {
    for (Motor& motor : motors_) {
      if (motor.q.joint == joint && motor.hasLag()) motor.set(t, torque);
    }
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
    const Motor* motor = motorOf(joint);
    return motor ? motor->share(acting) : 1;
  }
  /// nullptr: the joint has none.
  const Motor* motorOf(int joint) const {
    const auto is = [joint](const Motor& motor) { return motor.q.joint == joint; };
    const auto motor = std::find_if(motors_.begin(), motors_.end(), is);
    return motor == motors_.end() ? nullptr : &*motor;
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
