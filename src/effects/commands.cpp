#include "effects/commands.h"

#include <algorithm>

namespace planar_chain {

CommandEffect::CommandEffect(int n, int capacity)
    : TimedTerms(index(n) + index(capacity), 0), capacity_(index(capacity)), held_(2 * index(n)) {
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
}

std::vector<Load> CommandEffect::inForce(double t) const {
  std::vector<Load> loads;
  for (const auto* commands : {&held_, &timed_}) {
    for (const auto& [link, force, point, moment, joint, torque, start, stop] : *commands) {
      if (!(start <= t && t < stop)) continue;
      loads.push_back({"command", link, force, point, moment, joint, torque, Constant{}, start, stop});
    }
  }
  return loads;
}

}  // namespace planar_chain
