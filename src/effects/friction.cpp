#include "effects/friction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "effects/complementarity.h"
#include "effects/friction_events.h"
#include "effects/stick_slip.h"

namespace planar_chain {

namespace {

class Friction : public Effect, public JointConstraint, public Events, private RestingChain {
 public:
  /// tolerance: of rates, per second; 0 without error control. isClosed: the tip is held.
  Friction(const Chain& chain, double tolerance, bool isClosed)
      : coordinates_(chain.coordinates()),
        isClosed_(isClosed),
        n_(chain.size()),
        joints_(chain, tolerance),
        remembered_(joints_),
        slips_(joints_, n_),
        stuck_(joints_) {
    yield_.setZero(n_);
    rememberedYield_ = yield_;
    remembered_.reserve();
    atRest_.reserve(joints_.joints().size());
    others_.reserve(joints_.joints().size());
  }
  bool empty() const { return joints_.joints().empty(); }

  LoadKind mostActing() const override { return LoadKind::moments; }
  Powers apply(const ChainState& at, const Actions& to) override {
    const Eigen::VectorXd& moments = joints_.moments();
    if (to.N) Eigen::Map<Eigen::VectorXd>(to.N, n_) += moments;
    return {0, -moments.dot(Eigen::Map<const Eigen::VectorXd>(at.omega, n_))};
  }
  bool hasConstantMoments() const override { return true; }
  void addTorques(const ChainState& /*at*/, double* tau) override {
    Eigen::Map<Eigen::ArrayXd>(tau, n_) += joints_.torques();
  }
  Powers powersAlong(const ChainState& /*at*/, const StateChange& along) override {
    double change = 0;
    for (const int i : joints_.joints()) {
      change -= joints_.torques()[i] * coordinates_.relative(along.v, i);
    }
    return {0, change};
  }
  void remember() override {
    remembered_ = joints_;
    rememberedYield_ = yield_;
  }
  void recall() override {
    joints_ = remembered_;
    yield_ = rememberedYield_;
  }
  void saveOrRestore(Snapshot& snapshot) override { snapshot(joints_, yield_); }
  JointConstraint* jointConstraint() override { return this; }
  void couple(double /*t*/, int k, Couplings& to) const override {
    for (const int i : joints_.stuck()) {
      to.joints[index(i)].isPrescribed = true;
      to.prescribed[index(i)] = {k == 0 ? joints_.angle(i) : 0, 0, 0};
    }
  }
  bool onlyHolds() const override { return true; }
  void attach(Mechanics& mechanics) override {
    mechanics_ = &mechanics;
    stuck_.attach(mechanics);
  }

  Events* events() override { return this; }
  void addEvents(ode::EventList& to) const override { to.insert(to.end(), {&slips_, &stuck_}); }

  void enterState(double t, const double* y) override {
    yield_.setZero();
    arrival_ = {};
    atRest_.clear();
    for (const int i : joints_.joints()) {
      joints_.enter(i, y);
      // The projection onto a held tip gives a joint at rest a rate of rounding.
      if (isClosed_ && joints_.looseDue(i, y + n_) <= 0) joints_.start(i, 0);
      if (!joints_.slips(i)) atRest_.push_back({i});
    }
    take();
    decide(t, y);
  }
  void takeFrom(const Events& other) override {
    joints_.takeFrom(static_cast<const Friction&>(other).joints_);
    take();
  }
  void fire(double t, double* y, const ode::LocatedEvent& located) override {
    const int arrived = located.by == &slips_ ? located.which : -1;
    atRest_.clear();
    arrival_ = {};
    bool anyChanges = false;
    for (const int i : joints_.joints()) {
      if (joints_.isLoose(i)) {
        if (joints_.looseDue(i, y + n_) <= 0) continue;
        joints_.slip(i, y + n_);
        anyChanges = true;
        continue;
      }
      RestingJoint one{i};
      if (joints_.slips(i) && coordinates_.relative(y + n_, i) == 0) {
        // It has started here and has not moved, or it comes to rest exactly: what acts now may hold it.
        joints_.stay(i, y);
        anyChanges = true;
      } else if (joints_.slips(i)) {
        if (joints_.slipPastRest(i, y + n_) <= 0) continue;
        anyChanges = true;
        if (i == arrived) arrival_ = {i, joints_.direction(i), located.slope};
        one.release = -joints_.direction(i);
        joints_.rest(i, y, i == arrived && mayPass(i, located.slope));
      }
      one.direction = joints_.direction(i);
      atRest_.push_back(one);
    }
    if (anyChanges) take();
    if (isClosed_ && anyChanges) passDeadCentres(t, y);
    // To hold all resting joints takes more near a pose in which they let no motion pass, and energy.
    constexpr double rounding = 1e-10, any = std::numeric_limits<double>::infinity();
    mechanics_->snapPrescribed(t, y, rounding);
    decide(t, y);
    if (!isClosed_) return;
    do {
      // Joints that stick set the rates of the others.
      const auto moves = [&](int joint) { return !joints_.isAtRest(joint, y + n_); };
      if (std::any_of(joints_.stuck().begin(), joints_.stuck().end(), moves))
        mechanics_->snapPrescribed(t, y, any);
    } while (followRates(t, y));
  }

 private:
  /// Call it when joints stick or slip otherwise.
  void take() { mechanics_->forget(joints_.take()); }
  /// True if a joint that comes to rest with this |q̈| is likely to reverse without sticking.
  bool mayPass(int joint, double slope) const {
    return !joints_.hasBreakaway() && yield_[joint] > 0 &&
           slope > 2 * joints_.friction(joint) * yield_[joint];
  }
  /// Computes Y of the joint that has come to rest.
  void learn(const JointAnswer& answer) {
    const auto [joint, direction, slope] = arrival_;
    if (joint < 0) return;
    const double friction = joints_.friction(joint);
    const double more = direction * answer.moments[joint] + friction;
    const double after = direction * coordinates_.relative(answer.accelerations, joint);
    yield_[joint] = joints_.slips(joint) ? (slope + after) / (2 * friction) : slope / more;
    arrival_.joint = -1;
  }
  /// In a closed chain a joint may come to rest in a dead centre, where no torque in it can hold it. Joints
  /// that would leave the motion undetermined slip on. release: their direction.
  void passDeadCentres(double t, const double* y) {
    if (joints_.stuck().empty() || !mechanics_->isStretched(t, y)) return;
    for (RestingJoint& one : atRest_) {
      if (one.release == 0 || joints_.slips(one.joint)) continue;
      one.direction = one.release;
      joints_.start(one.joint, one.direction);
    }
    take();
  }
  /// The joints that start against the rates that they have slip as they move, until they rest again.
  /// Returns false if there are none; else decides for the others.
  bool followRates(double t, const double* y) {
    const std::size_t before = atRest_.size();
    const auto isAgainst = [&](const RestingJoint& one) {
      if (!joints_.slips(one.joint) || joints_.slipPastRest(one.joint, y + n_) <= 0) return false;
      joints_.slip(one.joint, y + n_);
      return true;
    };
    atRest_.erase(std::remove_if(atRest_.begin(), atRest_.end(), isAgainst), atRest_.end());
    if (atRest_.size() == before) return false;
    take();
    decide(t, y);
    return true;
  }
  /// Decides for all joints at rest.
  void decide(double t, const double* y) {
    t_ = t;
    y_ = y;
    if (!atRest_.empty()) findWhatSticks(*this, atRest_, joints_.hasBreakaway());
    if (isClosed_ && !joints_.stuck().empty()) loosenDeadCentres();
    if (joints_.stuck().empty()) return;
    const double* moments = mechanics_->answer(t, y).moments;
    for (const RestingJoint& one : atRest_) {
      // Any other that bears too much is due at once.
      if (one.mustStick && one.excess > 0) joints_.holdAt(one.joint, moments[one.joint], one.widening);
    }
  }
  /// Loosens one of the stuck joints, if they leave the motion undetermined.
  void loosenDeadCentres() {
    if (!mechanics_->isStretched(t_, y_)) return;
    for (std::size_t k = 0; k < atRest_.size(); ++k) {
      const int joint = atRest_[k].joint;
      if (joints_.slips(joint)) continue;
      if (loosen(k)) {
        atRest_ = others_;
        return;
      }
      joints_.start(joint, 0);
      take();
    }
  }
  /// Loosens a joint, and decides for the others_. In a dead centre it does not start, whatever it bears. If
  /// it starts, others could hold it with it: then it bears its friction, if it does not start with that.
  bool loosen(std::size_t which) {
    const int joint = atRest_[which].joint;
    for (const double push : {0., 1., -1., 0.}) {
      joints_.loosen(joint, push);
      take();
      if (mechanics_->isStretched(t_, y_)) return false;
      others_ = atRest_;
      others_.erase(others_.begin() + static_cast<std::ptrdiff_t>(which));
      if (others_.empty()) return true;
      findWhatSticks(*this, others_, joints_.hasBreakaway());
      const double start = coordinates_.relative(mechanics_->answer(t_, y_).accelerations, joint);
      if (std::abs(start) <= joints_.leastStart(joint)) break;
    }
    return true;
  }
  void solve(std::vector<RestingJoint>& joints) override {
    // Take the guess.
    bool anyChanges = false;
    for (const RestingJoint& one : joints) {
      if (one.direction == joints_.direction(one.joint)) continue;
      joints_.start(one.joint, one.direction);
      anyChanges = true;
    }
    if (anyChanges) take();
    const JointAnswer answer = mechanics_->answer(t_, y_);
    learn(answer);

    // Find the joints whose guess is wrong.
    double most = 0;
    for (int i = 0; i < n_; ++i)
      most = std::max(most, std::abs(coordinates_.relative(answer.accelerations, i)));
    const double least = StickSlip::rounding * most;
    for (RestingJoint& one : joints) {
      if (one.direction == 0) {
        const double moment = answer.moments[one.joint];
        one.excess = joints_.stickDue(one.joint, answer.moments);
        one.load = std::abs(moment) / joints_.breakaway(one.joint);
        one.release = moment > 0 ? -1 : 1;
      } else {
        const double start = one.direction * coordinates_.relative(answer.accelerations, one.joint);
        one.wrong = -start - least;
        one.start = start / joints_.leastStart(one.joint);
        joints_.startWith(one.joint, start, least);
      }
    }
  }

  Coordinates coordinates_;
  bool isClosed_;
  int n_;
  StickSlip joints_, remembered_;
  SlipEvents slips_;
  StuckEvents stuck_;
  Mechanics* mechanics_ = nullptr;
  Eigen::ArrayXd yield_;  ///< Y of each joint when it last came to rest, 1/(kg m²); 0: unknown
  Eigen::ArrayXd rememberedYield_;

  // The present change:
  double t_ = 0;
  const double* y_ = nullptr;
  std::vector<RestingJoint> atRest_, others_;
  struct Arrival {
    int joint = -1;
    double direction = 0, slope = 0;  ///< until then: the sign of q̇, and |q̈|
  } arrival_;
};

// ---- The kind --------------------------------------------------------------------------------------

class FrictionKind : public EffectKind {
 public:
  const std::vector<JointKey>& jointKeys() const override {
    static const std::vector<JointKey> keys{
        {"friction", nullptr, NumberRule::from(0, "N m"), false, false, "friction"},
        {"breakaway", nullptr, NumberRule::from(0, "N m, the friction")}};
    return keys;
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
    const std::vector<Joint>& joints = scene.chain.joints();
    if (std::none_of(joints.begin(), joints.end(), mayStick)) return nullptr;
    return makeUnlessEmpty<Friction>(scene.chain, toleranceOfRates(scene.integrator), scene.tip.has_value());
  }

  double dryFrictionIn(const Joint& joint) const override { return joint.other("friction"); }
  /// It has no energy.
  bool isInEquilibrium() const override { return false; }
  Symbol symbolOf(const Joint& joint) const override {
    return mayStick(joint) ? Symbol::brake : Symbol::none;
  }
  void summarize(const Scene& scene, SceneWords& words) const override {
    words.countJoints(scene.chain, mayStick, "rubbing joint");
  }
};

}  // namespace

const EffectKind& frictionKind() {
  static const FrictionKind kind;
  return kind;
}

}  // namespace planar_chain
