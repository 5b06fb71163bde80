#pragma once

/// The services that compute the equations: ~equations and ~linearize. They change nothing.

#include <planar_chain/Equations.h>
#include <planar_chain/Linearize.h>
#include <ros/node_handle.h>
#include <ros/service_server.h>

#include <memory>

#include "planar_chain/simulation.h"
#include "ros/messages/incoming.h"

namespace planar_chain {

/// The longest chain that is answered. The matrices are dense, and the simulation waits for them.
constexpr int mostLinksInMatrices = 200;

// Each sets the response to the matrices at the requested state, with the loads and commands of the present
// time. An empty q and qd request the present state. On a fault `success` is false, `message` has every
// fault, and the rest is empty. Faults are: not one finite number per joint, a chain that is too long, and
// matrices that are not finite.
void answer(const Simulation& simulation, const Equations::Request& request, Equations::Response& response);
void answer(const Simulation& simulation, const Linearize::Request& request, Linearize::Response& response);

/// Advertises one of them under `node`. The pointer must outlive the server.
template <class Service, template <class> class Request>
ros::ServiceServer advertiseQuery(ros::NodeHandle& node, const char* name,
                                  const std::unique_ptr<Simulation>& simulation) {
  return advertise<Service, Request>(node, name, [&simulation](auto& in, auto& response) {
    typename Service::Request request;
    request.q = plain(in.q);
    request.qd = plain(in.qd);
    answer(*simulation, request, response);
    return Answer{bool(response.success), response.message};
  });
}

}  // namespace planar_chain
