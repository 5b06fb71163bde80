/// The services of Node that change the motion.

#include <planar_chain/SetState.h>
#include <std_srvs/Trigger.h>

#include <string>

#include "dynamics/given_state.h"
#include "ros/messages/incoming.h"
#include "ros/node/node.h"
#include "ros/node/queries.h"

namespace planar_chain {

namespace {

constexpr const char* longTick = "a long tick is running; ~reset aborts it";

}  // namespace

void Node::advertiseServices() {
  const auto trigger = [this](const char* name, Answer (Node::*action)()) {
    return advertise<std_srvs::Trigger, std_srvs::TriggerRequest_>(
        inner_, name, [this, action](auto& /*empty*/, auto& /*answer*/) { return (this->*action)(); });
  };
  const auto query = [this](auto& in, auto& out) {
    return answer(*simulation_, plain(in.q), plain(in.qd), out);
  };
  servers_ = {
      trigger("pause", &Node::pause),
      trigger("resume", &Node::resume),
      trigger("reset", &Node::reset),
      trigger("clear_commands", &Node::clearCommands),
      trigger("settle", &Node::settle),
      advertise<SetState, SetStateRequest_>(
          inner_, "set_state",
          [this](auto& in, auto& /*out*/) { return setState(plain(in.q), plain(in.qd)); }),
      advertise<Step, StepRequest_>(
          inner_, "step", [this](auto& in, auto& out) { return step(plainOf<StepRequest>(in), out); }),
      advertise<Equations, EquationsRequest_>(inner_, "equations", query),
      advertise<Linearize, LinearizeRequest_>(inner_, "linearize", [this](auto& in, auto& out) {
        return answer(*simulation_, plain(in.q), plain(in.qd), plain(in.torques), out);
      })};
}

/// Samples the times for the real-time factor. A pause does not count, and neither do steps during it.
void Node::sampleTimes() {
  const std::pair present{ticks_.simTime(simulation_->time()), steadyTime()};
  if (paused_) {
    skipped_.first += present.first - sampledAt_.first;
    skipped_.second += present.second - sampledAt_.second;
  } else {
    times_.push_back({present.first - skipped_.first, present.second - skipped_.second});
  }
  sampledAt_ = present;
}

void Node::setPaused(bool paused) {
  sampleTimes();
  paused_ = paused;
}

Answer Node::pause() {
  if (paused_) return {true, "already paused"};
  setPaused(true);
  return {true, "paused"};
}

Answer Node::resume() {
  if (!simulation_->fault().empty())
    return {false, simulation_->fault() + "; call ~reset, ~settle or ~set_state"};
  if (!paused_) return {true, "already running"};
  if (inTick_ && !isClockRunning_) return {false, longTick};  // within a step
  setPaused(false);
  return {true, "running"};
}

/// Takes an input that waited for the end of a tick. `done`: the message if it is accepted.
Answer Node::take(const CommandTaken& input, const char* done) {
  commands_.serve();
  const std::string refusal = commands_.take(input);
  return refusal.empty() ? Answer{true, done} : Answer{false, refusal};
}

Answer Node::reset() {
  // Read the scene again.
  std::optional<Scene> changed;
  try {
    if (changedScene_) changed = changedScene_();
  } catch (const Refused& refused) {
    return {false, "the changed parameters are refused: " + toString(refused.faults())};
  }

  // Commands that have arrived belong to the time before the reset.
  if (inTick_) commands_.dropWaiting();
  commands_.serve();
  if (changed) load(*changed);
  commands_.take(inputOf(CommandTaken::RESET));
  allowYielding();
  ++resets_;
  return {true, std::string("reset to the initial state") +
                    (changed ? " of the scene in the changed parameters" : "") + (paused_ ? "; paused" : "")};
}

Answer Node::clearCommands() {
  if (inTick_) return {false, longTick};
  return take(inputOf(CommandTaken::CLEAR_COMMANDS), "all commands are cleared");
}

Answer Node::settle() {
  if (inTick_) return {false, longTick};
  return take(inputOf(CommandTaken::SETTLE), "at rest in the equilibrium");
}

Answer Node::setState(const std::vector<double>& q, const std::vector<double>& qd) {
  if (inTick_) return {false, longTick};
  CommandTaken input = inputOf(CommandTaken::SET_STATE);
  input.q = q;
  input.qd = qd;
  Answer answer = take(input, "the state is set");
  if (!answer.success) return answer;
  answer.message += movedWords("; ", simulation_->scene().chain, q.data(), simulation_->q().data());
  return answer;
}

Answer Node::step(const StepRequest& request, StepResponse& response) {
  // Check the request.
  if (!simulation_->fault().empty())
    return {false, simulation_->fault() + "; call ~reset, ~settle or ~set_state"};
  if (inTick_) return {false, longTick};
  if (!clock_->hasBegun()) return {false, clock_->haltedBy()};
  CommandTaken input = inputOf(CommandTaken::STEP);
  input.joint_torques = request.torques;
  input.n = request.n;
  input.base_pose = request.base_pose;
  input.base_twist = request.base_twist;
  const std::vector<Fault> faults = commands_.faultsOf(input);
  if (!faults.empty()) return {false, toString(faults)};

  // Pause, hold the torques, move the base, and tick.
  const bool ran = !paused_;
  setPaused(true);
  isClockRunning_ = false;
  began_ = served_ = steadyTime();
  const Answer done =
      take(input, ran ? "done; the simulation was paused, ~resume continues it" : "done; it is paused");
  response.states.reserve(request.n);
  for (std::uint32_t k = 0; done.success && k < request.n; ++k) {
    restForRecorder();
    if (!tick()) {
      if (!keepGoing_()) return {false, "the node is ending"};
      return {false, simulation_->fault().empty() ? "~reset aborted the tick" : simulation_->fault()};
    }
    const ros::Time stamp = clock_->stampOf(ticks_.next - 1);
    response.states.push_back(messages_->jointStates(stamp));
    if (simulation_->scene().base) response.base_wrenches.push_back(messages_->baseWrench(stamp));
    if (simulation_->scene().tip) response.tip_wrenches.push_back(messages_->tipWrench(stamp));
  }
  response.motor_torques = simulation_->motorTorques();
  return done;
}

}  // namespace planar_chain
