#include "effects/commands.h"

#include <algorithm>

namespace planar_chain {

CommandEffect::CommandEffect(int n, int capacity)
    : TimedTerms(index(n) + index(capacity), 0), capacity_(index(capacity)) {
  torques_.held.resize(index(n));
  forces_.held.resize(index(n));
  for (auto* waiting : {&torques_.waiting, &torques_.timed}) waiting->reserve(capacity_);
  for (auto* waiting : {&forces_.waiting, &forces_.timed}) waiting->reserve(capacity_);
}

// ---- Giving commands -----------------------------------------------------------------------------

bool CommandEffect::hasRoom() const {
  return torques_.waiting.size() + torques_.timed.size() + forces_.waiting.size() + forces_.timed.size() <
         capacity_;
}

template <class Command>
bool CommandEffect::hold(Lists<Command>& commands, const Command& command, double now) {
  if (command.window.start <= now) {
    commands.held[index(command.index)] = command;
    return true;
  }
  if (!hasRoom()) return false;
  const auto startsLater = [](const Command& one, const Command& other) {
    return one.window.start < other.window.start;
  };
  const auto place = std::upper_bound(commands.waiting.begin(), commands.waiting.end(), command, startsLater);
  commands.waiting.insert(place, command);
  endBy(command.window.start);
  return true;
}

template <class Command>
bool CommandEffect::add(Lists<Command>& commands, const Command& command, double now) {
  if (!hasRoom()) return false;
  commands.timed.push_back(command);
  if (command.window.start > now) endBy(command.window.start);
  return true;
}

template bool CommandEffect::hold(Lists<Torque>&, const Torque&, double);
template bool CommandEffect::hold(Lists<Force>&, const Force&, double);
template bool CommandEffect::add(Lists<Torque>&, const Torque&, double);
template bool CommandEffect::add(Lists<Force>&, const Force&, double);

void CommandEffect::clear() {
  torques_.waiting.clear();
  forces_.waiting.clear();
  torques_.timed.clear();
  forces_.timed.clear();
  std::fill(torques_.held.begin(), torques_.held.end(), Torque{});
  std::fill(forces_.held.begin(), forces_.held.end(), Force{});
}

// ---- What acts -------------------------------------------------------------------------------------

/// Holds what starts by t, and forgets what is over by t.
template <class Command>
void CommandEffect::bringForward(Lists<Command>& commands, double t) {
  auto& waiting = commands.waiting;
  const auto due = std::find_if(waiting.begin(), waiting.end(),
                                [t](const Command& command) { return command.window.start > t; });
  for (auto command = waiting.begin(); command != due; ++command) {
    commands.held[index(command->index)] = *command;
  }
  waiting.erase(waiting.begin(), due);
  if (!waiting.empty()) endBy(waiting.front().window.start);

  const auto over = [t](const Command& command) { return command.window.stop <= t; };
  commands.timed.erase(std::remove_if(commands.timed.begin(), commands.timed.end(), over),
                       commands.timed.end());
}

void CommandEffect::list(double t) {
  bringForward(torques_, t);
  bringForward(forces_, t);
  for (const auto* commands : {&torques_.held, &torques_.timed}) {
    for (const auto& [joint, torque, window] : *commands) {
      if (acts(window, t)) addJointTerm(joint, torque);
    }
  }
  for (const auto* commands : {&forces_.held, &forces_.timed}) {
    for (const auto& [link, point, force, moment, window] : *commands) {
      if (acts(window, t)) addBodyTerm(link, force, point, moment);
    }
  }
}

std::vector<Load> CommandEffect::inForce(double t) const {
  std::vector<Load> loads;
  const auto isInForce = [t](const Window& window) { return window.start <= t && t < window.stop; };
  for (const auto* commands : {&torques_.held, &torques_.timed}) {
    for (const auto& [joint, torque, window] : *commands) {
      if (!isInForce(window)) continue;
      loads.push_back(
          {"command", Load::none, {}, {}, 0, joint, torque, Constant{}, window.start, window.stop});
    }
  }
  for (const auto* commands : {&forces_.held, &forces_.timed}) {
    for (const auto& [link, point, force, moment, window] : *commands) {
      if (!isInForce(window)) continue;
      loads.push_back(
          {"command", link, force, point, moment, Load::none, 0, Constant{}, window.start, window.stop});
    }
  }
  return loads;
}

}  // namespace planar_chain
