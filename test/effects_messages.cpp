/// The node's messages, for effects.cpp.

#include <planar_chain/SimStatus.h>
#include <ros/serialization.h>

#include <memory>

#include "effects.h"
#include "planar_chain/simulation.h"
#include "ros/messages/frames.h"
#include "ros/messages/messages.h"

namespace planar_chain::test {

namespace {

struct Published {
  explicit Published(const Scene& scene) : simulation(scene), messages(scene, framesOf(scene, "")) {}
  Simulation simulation;
  Messages messages;
  SimStatus status;
};

}  // namespace

std::vector<Operation> messagesOf(const Scene& scene) {
  const auto published = std::make_shared<Published>(scene);
  const ros::Time stamp(1, 0);
  std::vector<Operation> operations;
  const auto add = [&](const char* name, auto serialized) {
    operations.push_back({"message", name, [] {}, [published, serialized] { serialized(*published); }});
  };
  using ros::serialization::serializeMessage;
  add("joint_states", [=](Published& p) { serializeMessage(p.messages.jointStates(p.simulation, stamp)); });
  add("tf", [=](Published& p) { serializeMessage(p.messages.transforms(p.simulation, stamp)); });
  add("link_states", [=](Published& p) { serializeMessage(p.messages.linkStates(p.simulation, stamp)); });
  add("status", [](Published& p) {
    describe(p.simulation, p.status);
    serializeMessage(p.status);
  });
  return operations;
}

}  // namespace planar_chain::test
