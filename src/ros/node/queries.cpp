#include "ros/node/queries.h"

#include <Eigen/Core>
#include <string>
#include <utility>

#include "planar_chain/fault.h"
#include "planar_chain/kane.h"
#include "planar_chain/linear_model.h"
#include "ros/messages/incoming.h"

namespace planar_chain {

namespace {

using Eigen::VectorXd;

VectorXd vectorOf(const std::vector<double>& values) {
  return VectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size()));
}

/// The time and state of a request, and the scene with the present commands as loads.
struct Question {
  Scene scene;
  double t;
  VectorXd q, qd;

  /// @throws Refused
  template <class Request>
  Question(const Simulation& simulation, const Request& request)
      : scene(simulation.scene()), t(simulation.time()) {
    // Check the request.
    std::vector<Fault> faults;
    const int n = scene.chain.size();
    if (n > mostLinksInMatrices) {
      const std::string most = std::to_string(mostLinksInMatrices);
      faults.push_back({"chain", "at most " + most + " links (the matrices are dense)", std::to_string(n)});
    }
    const bool isPresent = request.q.empty() && request.qd.empty();
    if (!isPresent) {
      checkValues(faults, "q", "angles", "rad", request.q, simulation.q().size());
      checkValues(faults, "qd", "rates", "rad/s", request.qd, simulation.qd().size());
    }
    if (!faults.empty()) throw Refused(std::move(faults));

    // Copy the state and the commands.
    q = vectorOf(isPresent ? simulation.q() : request.q);
    qd = vectorOf(isPresent ? simulation.qd() : request.qd);
    for (const Load& command : simulation.commands()) scene.loads.push_back(command);
  }
};

/// @throws Refused if a number is not finite.
void copy(const VectorXd& from, std::vector<double>& to) {
  if (!from.allFinite()) throw Refused({{"state", "finite equations of motion", "numbers too large"}});
  to.assign(from.data(), from.data() + from.size());
}

void copy(const Eigen::MatrixXd& from, Matrix& to) {
  to.rows = static_cast<std::uint32_t>(from.rows());
  to.columns = static_cast<std::uint32_t>(from.cols());
  const Eigen::MatrixXd byRows = from.transpose();
  copy(VectorXd::Map(byRows.data(), byRows.size()), to.data);
}

template <class Request, class Response, class Fill>
void fill(const Simulation& simulation, const Request& request, Response& response, Fill&& make) {
  response = {};
  try {
    make(Question(simulation, request));
    response.success = true;
  } catch (const Refused& refused) {
    response = {};
    response.message = toString(refused.faults());
  }
}

}  // namespace

void answer(const Simulation& simulation, const Equations::Request& request, Equations::Response& response) {
  fill(simulation, request, response, [&](const Question& at) {
    const Kane k = kane(at.scene.chain, at.q, at.qd, activeForces(at.scene, at.t, at.q, at.qd));
    copy(k.q, response.q);
    copy(k.qd, response.qd);
    response.S.resize(k.S.size());
    for (std::size_t i = 0; i < k.S.size(); ++i) copy(k.S[i], response.S[i]);
    copy(k.T, response.T);
    copy(k.V_pd, response.V_pd);
    copy(k.W_pd, response.W_pd);
    copy(k.A_1, response.A_1);
    copy(k.A_2, response.A_2);
    copy(k.A_3, response.A_3);
    copy(k.f_ext, response.f_ext);
    copy(k.f, response.f);
    copy(k.M_q, response.M);
    copy(k.qdd, response.qdd);
  });
}

void answer(const Simulation& simulation, const Linearize::Request& request, Linearize::Response& response) {
  fill(simulation, request, response, [&](const Question& at) {
    const LinearModel model = linearModel(at.scene, at.t, at.q, at.qd);
    copy(model.A, response.A);
    copy(model.B, response.B);
  });
}

}  // namespace planar_chain
