#include "ros/node/services.h"

#include <planar_chain/SetState.h>
#include <planar_chain/Step.h>
#include <std_srvs/Trigger.h>

#include <string>
#include <utility>

#include "ros/messages/incoming.h"

namespace planar_chain {

namespace {

using std_srvs::Trigger;

template <class Response>
void respond(Node::Answer answer, Response& response) {
  response.success = answer.success;
  response.message = std::move(answer.message);
}

}  // namespace

std::vector<ros::ServiceServer> advertiseServices(Node& node) {
  ros::NodeHandle handle("~");
  const auto trigger = [&](const char* name, Node::Answer (Node::*action)()) {
    return advertise<Trigger, Trigger::Request>(
        handle, name, [&node, action](const Trigger::Request& /*empty*/, Trigger::Response& out) {
          respond((node.*action)(), out);
        });
  };
  const auto setState = [&node](const SetStateRequest_<Bounded<void>>& in, SetState::Response& out) {
    respond(node.setState(plain(in.q), plain(in.qd)), out);
  };
  const auto step = [&node](const StepRequest_<Bounded<void>>& in, Step::Response& out) {
    respond(node.step(plain(in.torques), in.n, out.states), out);
  };
  return {trigger("pause", &Node::pause),
          trigger("resume", &Node::resume),
          trigger("reset", &Node::reset),
          trigger("clear_commands", &Node::clearCommands),
          advertise<SetState, SetStateRequest_<Bounded<void>>>(handle, "set_state", setState),
          advertise<Step, StepRequest_<Bounded<void>>>(handle, "step", step)};
}

}  // namespace planar_chain
