#pragma once

/// The services that tell the equations: ~equations and ~linearize. They look, and change nothing.

#include <planar_chain/Equations.h>
#include <planar_chain/Linearize.h>
#include <ros/node_handle.h>
#include <ros/service_server.h>

#include <vector>

#include "planar_chain/simulation.h"

namespace planar_chain {

/// The longest chain that is answered: the matrices are dense, and nothing moves while they are made.
constexpr int mostLinksInMatrices = 200;

// Each fills the response: the matrices, or no success and every fault. Refused are a q or qd that has not
// one finite number a joint (both empty: the present state), chains that are too long, and states whose
// matrices are not finite.
void answer(const Simulation& simulation, const Equations::Request& request, Equations::Response& response);
void answer(const Simulation& simulation, const Linearize::Request& request, Linearize::Response& response);

/// Offers both services under `node`, about `simulation`, which must outlive this object.
class Queries {
 public:
  Queries(ros::NodeHandle& node, const Simulation& simulation);

 private:
  std::vector<ros::ServiceServer> services_;
};

}  // namespace planar_chain
