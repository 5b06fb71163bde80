#include <type_traits>
#include <utility>

#include "dynamics/equilibrium.h"
#include "dynamics/given_state.h"
#include "dynamics/letters.h"
#include "python/bindings.h"

namespace planar_chain::python {

namespace {

using Given = py::object;  // an array, or None

std::optional<Eigen::VectorXd> vectorIn(const Given& given, const char* name) {
  if (given.is_none()) return std::nullopt;
  const std::vector<double> numbers = numbersOf(given, name);
  return Eigen::VectorXd::Map(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

/// Calls answer(scene, t, q, qd) for the state that is given.
template <class Answer>
auto atGiven(const TreeAndScene& of, const py::object& when, const Given& q, const Given& qd,
             const Answer& answer, std::vector<Fault> faults = {}) {
  const double t = numberOf(when, "t");
  const GivenState state = stateOf(of.scene, t, vectorIn(q, "q"), vectorIn(qd, "qd"), faults);
  if (!faults.empty()) throw Refused(std::move(faults));
  if (!q.is_none()) warn(movedWords("q: ", of.scene.chain, vectorIn(q, "q")->data(), state.q.data()));
  return answer(of.scene, t, state.q, state.qd);
}

py::object toArray(const Eigen::MatrixXd& matrix) {
  return py::cast(matrix);
}

py::object toArray(const Eigen::VectorXd& vector) {
  return py::cast(vector);
}

py::object toArray(const std::vector<Eigen::Matrix2d>& matrices) {
  return py::module::import("numpy").attr("array")(matrices);
}

}  // namespace

py::dict equationsAt(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd) {
  requireFewLinks(scene);
  const auto [active, equations] = released([&] {
    ActiveForces forces = activeForces(scene, t, q, qd);
    Kane found = kane(scene.chain, q, qd, forces);
    return std::pair(std::move(forces), std::move(found));
  });
  requireFinite(active, equations, std::nullopt);
  py::dict all;
  showAll(active, equations, std::nullopt,
          [&](const char* letter, const char*, const auto& value) { all[letter] = toArray(value); });
  return all;
}

py::tuple shownModel(LinearModel model) {
  for (const std::string& note : model.notes) warn(note);
  requireFinite("derivatives", model.A);
  requireFinite("derivatives", model.B);
  return py::make_tuple(std::move(model.A), std::move(model.B));
}

namespace {

/// tau: None, "holding" or n numbers; friction: "acts" or "slips"
OperatingPoint pointOf(const Given& tau, const py::object& friction, bool motors) {
  OperatingPoint about;
  about.hasSteadyMotors = motors;
  if (py::isinstance<py::str>(tau)) {
    about.isHeld = tau.equal(py::str("holding"));
    if (!about.isHeld) throw Refused({{"tau", "None, 'holding' or an array of numbers", shown(tau)}});
  } else {
    about.tau = vectorIn(tau, "tau");
  }
  about.slips = friction.equal(py::str("slips"));
  if (!about.slips && !friction.equal(py::str("acts")))
    throw Refused({{"friction", "'acts' or 'slips'", shown(friction)}});
  return about;
}

}  // namespace

Eigen::VectorXd inverseAt(const TreeAndScene& of, const py::object& accelerations, const Given& at,
                          const Given& rates, const py::object& time) {
  if (accelerations.is_none()) throw Refused({{"qdd", "an array of numbers", "None"}});
  const Eigen::VectorXd qdd = *vectorIn(accelerations, "qdd");
  std::vector<Fault> faults;
  checkNumbers("qdd", of.scene, qdd, "rad/s²", faults);
  const auto inverse = [&qdd](const Scene& its, double when, const auto& angles, const auto& ratesThen) {
    Eigen::VectorXd tau = released([&] { return inverseDynamics(its, when, angles, ratesThen, qdd); });
    requireFinite("torques", tau);
    return tau;
  };
  return atGiven(of, time, at, rates, inverse, std::move(faults));
}

static void bindLinearize(py::module& module) {
  const auto none = [](const char* name) { return py::arg(name) = py::none(); };
  const auto modelOf = [](const TreeAndScene& of, const Given& at, const Given& rates, const Given& tau,
                          const py::object& friction, const py::object& time, bool motors) {
    const OperatingPoint about = pointOf(tau, friction, motors);
    const auto near = [&about](const Scene& its, double when, const auto& angles, const auto& ratesThen) {
      requireFewLinks(its);
      return released([&] { return linearModel(its, when, angles, ratesThen, about); });
    };
    return atGiven(of, time, at, rates, near);
  };
  module.def(
      "_operating_point",  // for state_space() and modes()
      [modelOf](const TreeAndScene& of, const Given& at, const Given& rates, const Given& tau,
                const py::object& friction, const py::object& time, bool motors) {
        LinearModel model = modelOf(of, at, rates, tau, friction, time, motors);
        Eigen::VectorXd torques = model.tau, qdd = model.qdd;
        requireFinite("accelerations", qdd);
        return py::make_tuple(shownModel(std::move(model)), std::move(torques), std::move(qdd));
      },
      "((A, B), tau, qdd)");
  module.def(
      "linearize",
      [modelOf](const TreeAndScene& of, const Given& at, const Given& rates, const Given& tau,
                const py::object& friction, const py::object& time,
                bool motors) { return shownModel(modelOf(of, at, rates, tau, friction, time, motors)); },
      py::arg("scene"), none("q"), none("qd"), none("tau"), py::arg("friction") = "acts", py::arg("t") = 0.0,
      py::arg("motors") = false,
      R"(Returns A (2n×2n) and B (2n×n) of ẋ = A x + B δτ near a state and torques.

x = (δq, δq̇) is a small change of the state, in rad and rad/s; δτ is additional torque in the joints, N m.
A is the Jacobian of the motion, exact to rounding. It depends on the torques tau (n, N m) that act in the joints beside all else: None: 0;
'holding': those that hold this state, q̈ = 0. A state at rest that they do not hold is a warning.

friction: with 'acts' a joint at rest may stick; then its column of B is 0, and a warning says so. With 'slips' it
counts as one that slips, without friction. Motors and delays of commands are in neither A nor B, as a warning says: δτ is what acts.
motors: as of Simulation.linearize(); the motors have reached tau.
The default state, and what is refused, are those of equations().
If the tip is held, A and B keep their size, and hold for changes with J_c δq = 0 (J_c: see equations());
B has the rank n − 2, or n − 1 for a tip on a line.)");
}

void bindEquations(py::module& module) {
  bindLinearize(module);
  const auto scene = py::arg("scene");
  const auto q = py::arg("q") = py::none(), qd = py::arg("qd") = py::none();
  const auto t = py::arg("t") = 0.0;
  module.def(
      "equations",
      [](const TreeAndScene& of, const Given& at, const Given& rates, const py::object& time) {
        return atGiven(of, time, at, rates, equationsAt);
      },
      scene, q, qd, t, R"(Returns the matrices of M q̈ = f at the angles q (rad), rates qd (rad/s), time t (s).

By default at the first state of the scene, with driven joints where their laws have them at t. Raises Refused
for other states of driven joints and for numbers that are not finite, OverflowError if
one of the results is not. The dict has the letters that `equations --json` prints; the theory explains them:

    q, qd, qdd, tau, M_ext, f_ext, f    n        F            2n
    S                                   n×2×2    V_pd, A_1, A_2   n×2n
    T, W_pd, A_3, M                     n×n)");
  module.def(
      "inverse_dynamics", &inverseAt, scene, py::arg("qdd"), q, qd, t,
      R"(Returns the joint torques, n, N m, that give the accelerations qdd (n, rad/s²) beside all that acts; with a
held tip, those of smallest norm.
Friction opposes the rate, or at rest the acceleration. breakaway does not count: a joint at rest may stick under these torques.

The default state, and what is refused, are those of equations().)");
  module.def(
      "equilibrium",
      [](const TreeAndScene& of, const Given& at, const py::object& time) {
        const auto downhill = [](const Scene& its, double when, const auto& angles, const auto& /*rates*/) {
          return released([&] {
            Uninterrupted isUninterrupted;
            return equilibriumOf(its, when, {angles.data(), angles.data() + angles.size()}, mostSearchSteps,
                                 [&] { return isUninterrupted(); });
          });
        };
        const std::vector<double> rest = atGiven(of, time, at, py::none(), downhill);
        return Numbers(static_cast<py::ssize_t>(rest.size()), rest.data());
      },
      scene, q, t, R"(Returns the angles of the static equilibrium, searched from q: n, rad.

Raises ValueError where there is none.)");
}

}  // namespace planar_chain::python
