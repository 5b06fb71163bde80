#include "effects/commands.h"

#include <algorithm>
#include <cmath>

namespace planar_chain {

CommandEffect::CommandEffect(const Chain& chain, int capacity)
    : TimedTerms(2 * chain.joints().size() + index(capacity), 0),
      capacity_(index(capacity)),
      held_(2 * chain.joints().size()),
      isCutOff_(chain.joints().size()),
      cutOffs_(chain.joints().size()) {
  for (const Joint& joint : chain.joints()) {
    limits_.push_back(joint.has("effort_limit") ? joint.other("effort_limit")
                                                : std::numeric_limits<double>::infinity());
  }
  waiting_.reserve(capacity_);
  timed_.reserve(capacity_);
}

// ---- Giving commands -----------------------------------------------------------------------------

Command& CommandEffect::placeOf(const Command& command) {
  return held_[command.joint != Load::none ? index(command.joint) : held_.size() / 2 + index(command.link)];
}

bool CommandEffect::hold(const Command& command, double now) {
  if (command.start <= now) {
    placeOf(command) = command;
    return true;
  }
  if (!hasRoom()) return false;
  const auto startsLater = [](const Command& one, const Command& other) { return one.start < other.start; };
  waiting_.insert(std::upper_bound(waiting_.begin(), waiting_.end(), command, startsLater), command);
  endBy(command.start);
  return true;
}

bool CommandEffect::add(const Command& command, double now) {
  if (!hasRoom()) return false;
  timed_.push_back(command);
  if (command.start > now) endBy(command.start);
  return true;
}

void CommandEffect::clear() {
  waiting_.clear();
  timed_.clear();
  std::fill(held_.begin(), held_.end(), Command{});
}

// ---- What acts -------------------------------------------------------------------------------------

void CommandEffect::list(double t) {
  // Hold what starts by t, and forget what is over by t.
  const auto due = std::find_if(waiting_.begin(), waiting_.end(),
                                [t](const Command& command) { return command.start > t; });
  for (auto command = waiting_.begin(); command != due; ++command) placeOf(*command) = *command;
  waiting_.erase(waiting_.begin(), due);
  if (!waiting_.empty()) endBy(waiting_.front().start);
  const auto isOver = [t](const Command& command) { return command.stop <= t; };
  timed_.erase(std::remove_if(timed_.begin(), timed_.end(), isOver), timed_.end());

  for (const auto* commands : {&held_, &timed_}) {
    for (const Command& command : *commands) addWithin(command, Constant{}, t);
  }
  cutOff(t);
}

double CommandEffect::overAt(double t, std::size_t joint) const {
  double sum = 0;
  const auto add = [&](const Command& command) {
    if (command.joint == static_cast<int>(joint) && command.start <= t && t < command.stop)
      sum += command.torque;
  };
  add(held_[joint]);
  std::for_each(timed_.begin(), timed_.end(), add);
  return sum - std::clamp(sum, -limits_[joint], limits_[joint]);
}

void CommandEffect::cutOff(double t) {
  for (std::size_t i = 0; i < limits_.size(); ++i) {
    if (std::isinf(limits_[i])) continue;
    const double over = overAt(t, i);
    cutOffs_[i] += over != 0 && !isCutOff_[i];
    isCutOff_[i] = over != 0;
    if (over == 0) continue;
    Command less;
    less.joint = static_cast<int>(i);
    less.torque = -over;
    less.stop = std::numeric_limits<double>::infinity();
    addWithin(less, Constant{}, t);
  }
}

std::vector<Load> CommandEffect::inForce(double t) const {
  std::vector<Load> loads;
  for (const auto* commands : {&held_, &timed_}) {
    for (const auto& [link, force, point, moment, joint, torque, start, stop] : *commands) {
      if (!(start <= t && t < stop)) continue;
      loads.push_back({"command", link, force, point, moment, joint, torque, Constant{}, start, stop});
    }
  }
  // What an effort limit takes off.
  for (std::size_t i = 0; i < limits_.size(); ++i) {
    const double over = std::isinf(limits_[i]) ? 0 : overAt(t, i);
    if (over != 0) loads.push_back({"limit", Load::none, {}, {}, 0, static_cast<int>(i), -over});
  }
  return loads;
}

// ---- The limit -------------------------------------------------------------------------------------

namespace {

class EffortKind : public EffectKind {
 public:
  std::vector<JointKey> jointKeys() const override {
    return {{"effort_limit", nullptr, NumberRule::above(0, "N m"), false, true},
            {"velocity_limit", nullptr, NumberRule::above(0, "rad/s"), false, true}};
  }
  void judge(const Joint& joint, std::vector<Fault>& faults) const override {
    for (const JointKey& key : jointKeys()) {
      if (joint.has(key.name)) key.range.check(faults, std::string("joint/") + key.name, key.of(joint));
    }
  }
  std::unique_ptr<Effect> make(const Scene&) const override { return nullptr; }
  void addDense(const Scene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&,
                const DenseActions&) const override {}
  void summarize(const Scene& scene, SceneWords& words) const override {
    int limits = 0;
    for (const Joint& joint : scene.chain.joints()) limits += joint.has("effort_limit");
    if (limits > 0) words.count(limits, "effort limit");
  }
};

}  // namespace

const EffectKind& effortKind() {
  static const EffortKind kind;
  return kind;
}

}  // namespace planar_chain
