/// Any run of requests is done or refused, with its reason: what ~set_state and ~step take is sound, what
/// they answer is finite, and what they refuse has changed nothing. Needs a master: see own_master.py.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "bytes.h"
#include "planar_chain/scene_reader.h"
#include "ros/node/node.h"
#include "ros_begun.h"

namespace planar_chain {
namespace {

constexpr std::size_t links = 2;
constexpr std::uint32_t mostTicks = 10000;  // of one request

/// Huge rates take as many steps as they take: there a request is cut short, as a node is that ends.
int patience = 0;
bool goesOn() {
  return --patience > 0;
}

Node& node() {
  static const std::unique_ptr<Node> one = [] {
    beginRos("fuzz_services");
    auto made = std::make_unique<Node>(
        readSceneText("chain: [a, b]\n"
                      "links:\n"
                      "  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], initial: {velocity: 3}}\n"
                      "  b: {mass: 2, inertia: 0.1, com: [0.3, 0], pin: [0.4, 0.1],\n"
                      "      joint: {stiffness: 3, damping: 0.2, upper: 1, stop_stiffness: 40}}\n"
                      "integrator: {method: rk4, step: 0.01}\n"));
    made->run(goesOn);  // which ends at once, and knows then whom to ask
    return made;
  }();
  return *one;
}

/// As many as a byte says, or mostly as many as there are links.
std::vector<double> numbers(Bytes& bytes) {
  const auto many = bytes.take<std::uint8_t>();
  std::vector<double> taken(many < 200 ? links : many % 8);
  for (double& number : taken) number = bytes.take<double>();
  return taken;
}

bool isSound(const std::vector<double>& some) {
  return some.size() == links &&
         std::all_of(some.begin(), some.end(), [](double x) { return std::isfinite(x); });
}

using States = std::vector<sensor_msgs::JointState>;

Answer step(const std::vector<double>& torques, std::uint32_t ticks, States& states) {
  patience = 50;
  StepRequest request;
  request.torques = torques;
  request.n = ticks;
  StepResponse response;
  const Answer answer = node().step(request, response);
  states = response.states;
  require(!answer.message.empty());
  require(!answer.success || (ticks >= 1 && ticks <= mostTicks && states.size() == ticks));
  require(!answer.success || torques.empty() || isSound(torques));
  for (const auto& state : states) {
    require(isSound(state.position) && isSound(state.velocity) && state.effort.size() == links);
  }
  return answer;
}

/// Right after a reset, whatever was refused since.
void requireTheFirstMotion() {
  States states;
  require(step({}, 3, states).success);
  static const States first = states;
  for (std::size_t k = 0; k < states.size(); ++k) {
    require(states[k].position == first[k].position && states[k].velocity == first[k].velocity);
  }
}

void askOne(Bytes& bytes) {
  switch (bytes.take<std::uint8_t>() % 8) {
    case 0:
      require(node().pause().success);
      return;
    case 1:
      require(!node().resume().message.empty());
      return;
    case 2:
      require(node().clearCommands().success);
      return;
    case 3: {
      const std::vector<double> q = numbers(bytes), qd = numbers(bytes);
      const Answer answer = node().setState(q, qd);
      require(!answer.message.empty());
      require(!answer.success || (isSound(q) && isSound(qd)));
      return;
    }
    case 4: {
      require(node().reset().success);
      const Answer refused = node().setState(numbers(bytes), {});
      require(!refused.success);
      States states;
      require(!step({0, std::nan("")}, 1, states).success && states.empty());
      return requireTheFirstMotion();
    }
    default: {
      const std::vector<double> torques = numbers(bytes);
      const auto few = bytes.take<std::uint8_t>();
      States states;
      step(torques, few < 250 ? few % 16 : bytes.take<std::uint32_t>(), states);
      return;
    }
  }
}

}  // namespace
}  // namespace planar_chain

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planar_chain;
  require(node().reset().success);
  requireTheFirstMotion();
  Bytes bytes(data, size);
  while (!bytes.empty()) askOne(bytes);
  return 0;
}
