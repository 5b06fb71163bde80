#include "ros/node/services.h"

#include <string>
#include <utility>

#include "ros/messages/bounded.h"

namespace planar_chain {

namespace {

/// Every request is answered: roscpp's own failure says nothing.
template <class Response>
void give(Node::Answer answer, Response& response) {
  response.success = answer.success;
  response.message = std::move(answer.message);
}

using SetStateIn = SetStateRequest_<Bounded<void>>;
using StepIn = StepRequest_<Bounded<void>>;

}  // namespace

Services::Services(Node& node) : node_(node) {
  offer("pause", &Node::pause);
  offer("resume", &Node::resume);
  offer("reset", &Node::reset);
  offer("clear_commands", &Node::clearCommands);
  servers_.push_back(advertise<SetState, SetStateIn>(handle_, "set_state",
                                                     [this](const SetStateIn& in, SetState::Response& out) {
                                                       give(node_.setState(plain(in.q), plain(in.qd)), out);
                                                     }));
  servers_.push_back(advertise<Step, StepIn>(handle_, "step", [this](const StepIn& in, Step::Response& out) {
    give(node_.step(plain(in.torques), in.n, out.states), out);
  }));
}

void Services::offer(const char* name, Node::Answer (Node::*action)()) {
  using std_srvs::Trigger;
  servers_.push_back(advertise<Trigger, Trigger::Request>(
      handle_, name, [this, action](const Trigger::Request& /*empty*/, Trigger::Response& out) {
        give((node_.*action)(), out);
      }));
}

}  // namespace planar_chain
