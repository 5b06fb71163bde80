/// The services of Node that change the motion.

#include <planar_chain/SetState.h>
#include <planar_chain/Step.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "ros/messages/incoming.h"
#include "ros/node/node.h"
#include "ros/node/queries.h"

namespace planar_chain {

namespace {

using std_srvs::Trigger;

constexpr std::uint32_t mostSteps = 10000;       // of one call
constexpr std::size_t mostStepValues = 1000000;  // joints × ticks of one answer

constexpr const char* longTick = "a long tick is running; ~reset aborts it";

template <class Response>
void respond(Node::Answer answer, Response& response) {
  response.success = answer.success;
  response.message = std::move(answer.message);
}

}  // namespace

void Node::advertiseServices() {
  const auto trigger = [&](const char* name, Answer (Node::*action)()) {
    return advertise<Trigger, Trigger::Request>(
        inner_, name, [this, action](const Trigger::Request& /*empty*/, Trigger::Response& out) {
          respond((this->*action)(), out);
        });
  };
  const auto set = [this](const SetStateRequest_<Bounded<void>>& in, SetState::Response& out) {
    respond(setState(plain(in.q), plain(in.qd)), out);
  };
  const auto stepBy = [this](const StepRequest_<Bounded<void>>& in, Step::Response& out) {
    respond(step(plain(in.torques), in.n, out.states), out);
  };
  servers_ = advertiseQueries(inner_, simulation_);
  servers_.push_back(trigger("pause", &Node::pause));
  servers_.push_back(trigger("resume", &Node::resume));
  servers_.push_back(trigger("reset", &Node::reset));
  servers_.push_back(trigger("clear_commands", &Node::clearCommands));
  servers_.push_back(advertise<SetState, SetStateRequest_<Bounded<void>>>(inner_, "set_state", set));
  servers_.push_back(advertise<Step, StepRequest_<Bounded<void>>>(inner_, "step", stepBy));
}

Node::Answer Node::pause() {
  if (paused_) return {true, "already paused"};
  paused_ = true;
  return {true, "paused"};
}

Node::Answer Node::resume() {
  if (!simulation_.fault().empty()) return {false, simulation_.fault() + "; call ~reset or ~set_state"};
  if (!paused_) return {true, "already running"};
  paused_ = false;
  restartClock();
  return {true, "running"};
}

Node::Answer Node::reset() {
  const bool hadFailed = !simulation_.fault().empty();
  // Commands that have arrived belong to the time before the reset.
  if (inTick_) {
    commandQueue_.clear();
  } else {
    commandQueue_.callAvailable();
  }
  ++resets_;
  simulation_.reset();
  commands_.forget();
  log_.add(CommandTaken::RESET);
  origin_ = next_;
  if (hadFailed && !paused_) restartClock();
  return {true, paused_ ? "reset to the initial state; paused" : "reset to the initial state"};
}

Node::Answer Node::clearCommands() {
  if (inTick_) return {false, longTick};
  commandQueue_.callAvailable();
  simulation_.clearCommands();
  log_.add(CommandTaken::CLEAR_COMMANDS);
  return {true, "all commands are cleared"};
}

Node::Answer Node::setState(const std::vector<double>& q, const std::vector<double>& qd) {
  // Check the request.
  if (inTick_) return {false, longTick};
  std::vector<Fault> faults;
  checkValues(faults, "q", "angles", "rad", q, simulation_.q().size());
  checkValues(faults, "qd", "rates", "rad/s", qd, simulation_.qd().size());
  if (!faults.empty()) return {false, toString(faults)};

  // Set the state.
  commandQueue_.callAvailable();
  const bool hadFailed = !simulation_.fault().empty();
  try {
    simulation_.setState(q, qd);
  } catch (const std::invalid_argument& refusal) {
    return {false, refusal.what()};
  }
  log_.add(CommandTaken::SET_STATE, [&](CommandTaken& taken) {
    taken.q = q;
    taken.qd = qd;
  });
  if (hadFailed && !paused_) restartClock();
  return {true, "the state is set"};
}

Node::Answer Node::step(const std::vector<double>& torques, std::uint32_t ticks,
                        std::vector<sensor_msgs::JointState>& states) {
  // Check the request.
  if (!simulation_.fault().empty()) return {false, simulation_.fault() + "; call ~reset or ~set_state"};
  if (inTick_) return {false, longTick};
  if (!clock_->hasBegun()) return {false, clock_->haltedBy()};
  commandQueue_.callAvailable();
  const std::size_t joints = simulation_.q().size();
  const auto most = std::min<std::size_t>(mostSteps, std::max<std::size_t>(1, mostStepValues / joints));
  std::vector<Fault> faults;
  if (!torques.empty()) faults = commands_.faultsOf(torques, "torques");
  if (ticks < 1 || ticks > most) {
    faults.push_back({"n", "from 1 to " + std::to_string(most) + " ticks", std::to_string(ticks)});
  }
  if (!faults.empty()) return {false, toString(faults)};

  // Pause and hold the torques.
  const bool ran = !paused_;
  paused_ = true;
  if (!torques.empty()) commands_.hold(torques);
  log_.add(CommandTaken::STEP, [&](CommandTaken& taken) { taken.joint_torques = torques; });

  // Tick. If the state of scene time 0 has not been published, it belongs to the tick before.
  if (next_ == origin_) --origin_;
  states.reserve(ticks);
  for (std::uint32_t k = 0; k < ticks; ++k) {
    if (!tick()) {
      if (!keepGoing_()) return {false, "the node is ending"};
      return {false, simulation_.fault().empty() ? "~reset aborted the tick" : simulation_.fault()};
    }
    states.push_back(messages_.jointStates(simulation_, clock_->stampOf(next_ - 1)));
  }
  return {true, ran ? "done; the simulation was paused, ~resume continues it" : "done; it is paused"};
}

}  // namespace planar_chain
