#pragma once

/// The services that compute the equations: ~equations and ~linearize. They change nothing.

#include <planar_chain/Equations.h>
#include <planar_chain/Linearize.h>

#include <vector>

#include "planar_chain/simulation.h"
#include "ros/messages/incoming.h"

namespace planar_chain {

/// The longest chain that is answered. The matrices are dense, and the simulation waits for them.
constexpr int mostLinksInMatrices = 200;

// Each sets the response to the matrices at a state, with the loads and commands of the present time. Empty q
// and qd stand for the present state. On a fault the answer has every fault, and the response is empty.
// Faults are: not one finite number per joint, a chain that is too long, and matrices that are not finite.
Answer answer(const Simulation& simulation, const std::vector<double>& q, const std::vector<double>& qd,
              Equations::Response& response);
/// torques: held in the joints in place of those that are commanded; empty: the commanded ones.
Answer answer(const Simulation& simulation, const std::vector<double>& q, const std::vector<double>& qd,
              const std::vector<double>& torques, Linearize::Response& response);

}  // namespace planar_chain
