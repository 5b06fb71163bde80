#include "effects/commands.h"

#include <algorithm>
#include <cmath>

namespace planar_chain {

CommandEffect::CommandEffect(const Chain& chain, int capacity)
    : TimedTerms(chain.coordinates(), 2 * chain.joints().size() + index(capacity), 0),
      capacity_(index(capacity)),
      held_(2 * chain.joints().size()),
      cut_{std::vector<int>(chain.joints().size()), std::vector<long long>(chain.joints().size())},
      remembered_(cut_) {
  for (const Joint& joint : chain.joints()) {
    limits_.push_back(joint.has("effort_limit") ? joint.other("effort_limit")
                                                : std::numeric_limits<double>::infinity());
    delays_.push_back(joint.other("command_delay"));
  }
  waiting_.reserve(capacity_);
  timed_.reserve(capacity_);
}

// ---- Giving commands -----------------------------------------------------------------------------

std::size_t CommandEffect::slotOf(const Command& command) const {
  return command.joint != Load::none ? index(command.joint) : held_.size() / 2 + index(command.link);
}

bool CommandEffect::hasRoom(double now) const {
  const auto waits = [&](const Command& command) { return command.start - delayOf(command.joint) > now; };
  const auto waiting = std::count_if(waiting_.begin(), waiting_.end(), waits);
  return static_cast<std::size_t>(waiting) + timed_.size() < capacity_;
}

Command CommandEffect::delayed(Command command, double now) const {
  const double delay = delayOf(command.joint);
  if (delay == 0) return command;
  command.start = std::max(command.start, now) + delay;
  command.stop += delay;
  return command;
}

bool CommandEffect::hold(const Command& given, double now) {
  const Command command = delayed(given, now);
  if (command.start <= now) {
    held_[slotOf(command)] = command;
    return true;
  }
  if (given.start > now && !hasRoom(now)) return false;
  const auto startsLater = [](const Command& one, const Command& other) { return one.start < other.start; };
  const auto behind = std::upper_bound(waiting_.begin(), waiting_.end(), command, startsLater);
  // One that would be replaced at once is replaced now.
  for (auto same = behind; same != waiting_.begin() && (--same)->start == command.start;) {
    if (slotOf(*same) != slotOf(command)) continue;
    *same = command;
    return true;
  }
  waiting_.insert(behind, command);
  endBy(command.start);
  return true;
}

bool CommandEffect::add(const Command& given, double now) {
  if (!hasRoom(now)) return false;
  const Command command = delayed(given, now);
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
  for (auto command = waiting_.begin(); command != due; ++command) held_[slotOf(*command)] = *command;
  waiting_.erase(waiting_.begin(), due);
  if (!waiting_.empty()) endBy(waiting_.front().start);
  const auto isOver = [t](const Command& command) { return command.stop <= t; };
  timed_.erase(std::remove_if(timed_.begin(), timed_.end(), isOver), timed_.end());

  cutOff(t);
  for (const auto* commands : {&held_, &timed_}) {
    for (const Command& command : *commands) {
      Command listed = command;
      // Only its start and stop count.
      if (hasMotor(command.joint) || isCutOff(command.joint)) listed.joint = Load::none;
      addWithin(listed, Constant{}, t);
    }
  }
}

double CommandEffect::sumAt(double t, std::size_t joint) const {
  long double sum = 0;  // rounded once
  const auto add = [&](const Command& command) {
    if (command.joint == static_cast<int>(joint) && command.start <= t && t < command.stop)
      sum += command.torque;
  };
  add(held_[joint]);
  std::for_each(timed_.begin(), timed_.end(), add);
  return static_cast<double>(sum);
}

double CommandEffect::torqueAt(double t, std::size_t joint) const {
  return std::clamp(sumAt(t, joint), -limits_[joint], limits_[joint]);
}

int CommandEffect::sideAt(double t, std::size_t joint) const {
  const double sum = sumAt(t, joint);
  return sum > limits_[joint] ? 1 : sum < -limits_[joint] ? -1 : 0;
}

void CommandEffect::cutOff(double t) {
  for (std::size_t i = 0; i < limits_.size(); ++i) {
    if (std::isinf(limits_[i])) continue;
    const int side = sideAt(t, i);
    cut_.counts[i] += side != 0 && side != cut_.sides[i];
    cut_.sides[i] = side;
    if (side == 0 || hasMotor(static_cast<int>(i))) continue;
    Command limit;
    limit.joint = static_cast<int>(i);
    limit.torque = side * limits_[i];
    limit.stop = std::numeric_limits<double>::infinity();
    addWithin(limit, Constant{}, t);
  }
}

std::vector<Load> CommandEffect::inForce(double t, const double* /*omega*/) const {
  std::vector<Load> loads;
  const auto isOfLimit = [&](int joint) { return joint != Load::none && sideAt(t, index(joint)) != 0; };
  for (const auto* commands : {&held_, &timed_}) {
    for (const auto& [link, force, point, moment, joint, torque, start, stop] : *commands) {
      if (!(start <= t && t < stop) || hasMotor(joint) || isOfLimit(joint)) continue;
      loads.push_back({"command", link, force, point, moment, joint, torque, Constant{}, start, stop});
    }
  }
  for (int i = 0; i < static_cast<int>(limits_.size()); ++i) {
    if (!hasMotor(i) && isOfLimit(i))
      loads.push_back({"limit", Load::none, {}, {}, 0, i, torqueAt(t, index(i))});
  }
  return loads;
}

std::vector<LinearMotor> CommandEffect::motorsAt(double t, const double* /*omega*/) const {
  std::vector<LinearMotor> motors;
  for (int i = 0; i < static_cast<int>(limits_.size()); ++i) {
    const bool isCutOff = sideAt(t, index(i)) != 0;
    if (isCutOff || hasMotor(i)) motors.push_back({i, 0, isCutOff});
  }
  return motors;
}

// ---- The limit -------------------------------------------------------------------------------------

namespace {

class EffortKind : public EffectKind {
 public:
  const std::vector<JointKey>& jointKeys() const override {
    static const std::vector<JointKey> keys{
        {"effort_limit", nullptr, NumberRule::above(0, "N m"), false, true},
        {"velocity_limit", nullptr, NumberRule::above(0, "rad/s"), false, true}};
    return keys;
  }
  std::unique_ptr<Effect> make(const Scene&) const override { return nullptr; }
  void summarize(const Scene& scene, SceneWords& words) const override {
    words.countJoints(
        scene.chain, [](const Joint& joint) { return joint.has("effort_limit"); }, "effort limit");
  }
};

}  // namespace

const EffectKind& effortKind() {
  static const EffortKind kind;
  return kind;
}

}  // namespace planar_chain
