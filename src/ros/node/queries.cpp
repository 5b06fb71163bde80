#include "ros/node/queries.h"

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <utility>

#include "dynamics/given_state.h"
#include "planar_chain/fault.h"
#include "planar_chain/kane.h"
#include "planar_chain/linear_model.h"

namespace planar_chain {

namespace {

using Eigen::VectorXd;

VectorXd vectorOf(const std::vector<double>& values) {
  return VectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size()));
}

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

/// Calls fill(scene, t, q, qd) with the scene that has the present commands as loads.
template <class Response, class Fill>
Answer answerBy(Fill fill, const Simulation& simulation, const std::vector<double>& q,
                const std::vector<double>& qd, Response& response) {
  try {
    // Check the request.
    std::vector<Fault> faults;
    Scene scene = simulation.scene();
    const int n = scene.chain.size();
    if (n > mostLinksInMatrices) {
      const std::string most = std::to_string(mostLinksInMatrices);
      faults.push_back({"chain", "at most " + most + " links (the matrices are dense)", std::to_string(n)});
    }
    const bool isPresent = q.empty() && qd.empty();
    GivenState state{vectorOf(isPresent ? simulation.q() : q), vectorOf(isPresent ? simulation.qd() : qd)};
    if (!isPresent) {
      checkValues(faults, "q", "angles", "rad", q, simulation.q().size());
      checkValues(faults, "qd", "rates", "rad/s", qd, simulation.qd().size());
      if (faults.empty()) state = stateOf(scene, simulation.time(), state.q, state.qd, faults);
    }
    if (!faults.empty()) throw Refused(std::move(faults));

    for (const Load& command : simulation.commands()) scene.loads.push_back(command);
    fill(scene, simulation.time(), state.q, state.qd);
    return {true, ""};
  } catch (const Refused& refused) {
    response = {};
    return {false, toString(refused.faults())};
  }
}

}  // namespace

Answer answer(const Simulation& simulation, const std::vector<double>& q, const std::vector<double>& qd,
              Equations::Response& response) {
  const auto fill = [&](const Scene& scene, double t, const VectorXd& at, const VectorXd& rates) {
    const Kane k = kane(scene.chain, at, rates, activeForces(scene, t, at, rates));
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
  };
  return answerBy(fill, simulation, q, qd, response);
}

Answer answer(const Simulation& simulation, const std::vector<double>& q, const std::vector<double>& qd,
              const std::vector<double>& torques, Linearize::Response& response) {
  const auto fill = [&](Scene& scene, double t, const VectorXd& at, const VectorXd& rates) {
    OperatingPoint about;
    if (!torques.empty()) {
      std::vector<Fault> faults;
      checkValues(faults, "torques", "torques", "N m", torques, simulation.q().size());
      if (!faults.empty()) throw Refused(std::move(faults));
      about.tau = vectorOf(torques);
      // The commands stand behind the scene's own loads.
      const auto isInJoint = [](const Load& load) { return load.joint != Load::none; };
      const auto own = static_cast<std::ptrdiff_t>(simulation.scene().loads.size());
      scene.loads.erase(std::remove_if(scene.loads.begin() + own, scene.loads.end(), isInJoint),
                        scene.loads.end());
    }
    const LinearModel model = linearModel(scene, t, at, rates, about);
    response.notes = model.notes;
    copy(model.A, response.A);
    copy(model.B, response.B);
  };
  return answerBy(fill, simulation, q, qd, response);
}

}  // namespace planar_chain
