#include "planar_chain/ros/services.h"

#include <boost/function.hpp>

namespace planar_chain {

namespace {

/// Every request is answered: roscpp's own failure says nothing.
template <class Response>
bool answer(Node::Answer from, Response& response) {
  response.success = from.success;
  response.message = std::move(from.message);
  return true;
}

}  // namespace

Services::Services(Node& node) : node_(node) {
  advertise("pause", &Node::pause);
  advertise("resume", &Node::resume);
  advertise("reset", &Node::reset);
  advertise("clear_commands", &Node::clearCommands);

  const boost::function<bool(SetState::Request&, SetState::Response&)> setState =
      [this](SetState::Request& in, SetState::Response& out) {
        return answer(node_.setState(in.q, in.qd), out);
      };
  servers_.push_back(handle_.advertiseService("set_state", setState));

  const boost::function<bool(Step::Request&, Step::Response&)> step = [this](Step::Request& in,
                                                                             Step::Response& out) {
    return answer(node_.step(in.torques, in.n, out.states), out);
  };
  servers_.push_back(handle_.advertiseService("step", step));
}

void Services::advertise(const char* name, Node::Answer (Node::*action)()) {
  using std_srvs::Trigger;
  const boost::function<bool(Trigger::Request&, Trigger::Response&)> serve =
      [this, action](Trigger::Request&, Trigger::Response& out) { return answer((node_.*action)(), out); };
  servers_.push_back(handle_.advertiseService(name, serve));
}

}  // namespace planar_chain
