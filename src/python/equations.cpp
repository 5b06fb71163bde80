#include <type_traits>
#include <utility>

#include "dynamics/equilibrium.h"
#include "dynamics/letters.h"
#include "python/bindings.h"

namespace planar_chain::python {

namespace {

using Given = std::optional<Eigen::VectorXd>;

Eigen::VectorXd orElse(const Given& given, const std::vector<double>& otherwise) {
  if (given) return *given;
  return Eigen::Map<const Eigen::VectorXd>(otherwise.data(), static_cast<Eigen::Index>(otherwise.size()));
}

py::object arrayOf(const Eigen::MatrixXd& matrix) {
  return py::cast(matrix);
}

py::object arrayOf(const Eigen::VectorXd& vector) {
  return py::cast(vector);
}

py::object arrayOf(const std::vector<Eigen::Matrix2d>& matrices) {
  return py::module::import("numpy").attr("array")(matrices);
}

}  // namespace

py::dict equationsAt(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd) {
  const ActiveForces active = activeForces(scene, t, q, qd);
  py::dict all;
  showAll(active, kane(scene.chain, q, qd, active), std::nullopt,
          [&](const char* letter, const char*, const auto& value) { all[letter] = arrayOf(value); });
  return all;
}

py::tuple linearizedAt(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd) {
  LinearModel model = linearModel(scene, t, q, qd);
  return py::make_tuple(std::move(model.A), std::move(model.B));
}

void bindEquations(py::module& module) {
  const auto scene = py::arg("scene");
  const auto q = py::arg("q") = py::none(), qd = py::arg("qd") = py::none();
  const auto t = py::arg("t") = 0.0;
  module.def(
      "equations",
      [](const TreeAndScene& of, const Given& at, const Given& rates, double time) {
        return equationsAt(of.scene, time, orElse(at, of.scene.q), orElse(rates, of.scene.qd));
      },
      scene, q, qd, t, R"(Returns the matrices of M q̈ = f at the angles q (rad), rates qd (rad/s), time t (s).

By default at the first state of the scene. The dict has the letters that `equations --json` prints; the
theory explains them:

    q, qd, qdd, tau, M_ext, f_ext, f    n        F            2n
    S                                   n×2×2    V_pd, A_1, A_2   n×2n
    T, W_pd, A_3, M                     n×n)");
  module.def(
      "linearize",
      [](const TreeAndScene& of, const Given& at, const Given& rates, double time) {
        return linearizedAt(of.scene, time, orElse(at, of.scene.q), orElse(rates, of.scene.qd));
      },
      scene, q, qd, t, R"(Returns A (2n×2n) and B (2n×n) of ẋ = A x + B δτ near a state.

x = (δq, δq̇) is a small change of the state, in rad and rad/s; δτ is additional torque in the joints, N m.
A is the Jacobian of the motion, exact to rounding. By default at the first state of the scene.)");
  module.def(
      "inverse_dynamics",
      [](const TreeAndScene& of, const Eigen::VectorXd& qdd, const Given& at, const Given& rates,
         double time) {
        return inverseDynamics(of.scene, time, orElse(at, of.scene.q), orElse(rates, of.scene.qd), qdd);
      },
      scene, py::arg("qdd"), q, qd, t,
      "Returns the joint torques, n, N m, that give the accelerations qdd (n, rad/s²) beside all that acts.");
  module.def(
      "equilibrium",
      [](const TreeAndScene& of, const Given& at, double time) {
        const Eigen::VectorXd start = orElse(at, of.scene.q);
        const std::vector<double> rest =
            equilibriumOf(of.scene, time, {start.data(), start.data() + start.size()});
        return Numbers(static_cast<py::ssize_t>(rest.size()), rest.data());
      },
      scene, q, t, R"(Returns the angles of the static equilibrium downhill of q: n, rad.

Raises ValueError where there is none.)");
}

}  // namespace planar_chain::python
