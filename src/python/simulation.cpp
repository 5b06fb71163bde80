#include "planar_chain/simulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "planar_chain/batch.h"
#include "python/bindings.h"

namespace planar_chain::python {

namespace {

constexpr double forever = std::numeric_limits<double>::infinity();

/// Why an integration ended early.
struct Failed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The number of a link or joint that is given by number or name. `things`: the links or joints of the chain.
template <class Things>
int numberOf(const py::object& given, const Things& things, const std::string& what) {
  auto found = things.end();
  if (py::isinstance<py::str>(given)) {
    found = std::find_if(things.begin(), things.end(),
                         [&](const auto& thing) { return given.equal(py::str(thing.name)); });
  } else if (PyIndex_Check(given.ptr())) {
    const py::ssize_t place = PyNumber_AsSsize_t(given.ptr(), nullptr);  // of larger numbers, the largest
    if (place >= 0 && place < static_cast<py::ssize_t>(things.size())) found = things.begin() + place;
  }
  if (found != things.end()) return static_cast<int>(found - things.begin());
  throw Refused(
      {{what, "the name of a " + what + ", or a number from 0 to " + std::to_string(things.size() - 1),
        shown(given)}});
}

/// Holds all of them or, with faults, none.
void holdTorques(Simulation& simulation, const std::vector<double>& tau) {
  std::vector<bool> isDriven(tau.size());
  for (const Drive& drive : simulation.scene().drives) isDriven[static_cast<std::size_t>(drive.joint)] = true;
  std::vector<Fault> faults;
  for (std::size_t i = 0; i < tau.size(); ++i) {
    if (std::isfinite(tau[i]) && !(isDriven[i] && tau[i] != 0)) continue;
    faults.push_back({"torques/" + std::to_string(i),
                      isDriven[i] ? "0 N m in a driven joint" : "a finite number, in N m", toText(tau[i])});
  }
  if (!faults.empty()) throw Refused(std::move(faults));
  for (std::size_t i = 0; i < tau.size(); ++i) {
    if (!isDriven[i]) simulation.holdTorque(static_cast<int>(i), tau[i], forever);
  }
}

}  // namespace

/// A simulation that one thread at a time may use.
class Running {
 public:
  Running(const TreeAndScene& from, int commands) : simulation_(from.scene, commands) {}

  /// @throws std::runtime_error while another thread advances it
  Simulation& idle() {
    if (isBusy_) throw std::runtime_error("another thread advances this simulation");
    return simulation_;
  }

  /// Returns f(simulation) while other threads run. They may not use this simulation.
  template <class F>
  auto alone(const F& f) {
    Simulation& simulation = idle();
    isBusy_ = true;
    const std::unique_ptr<bool, void (*)(bool*)> atEnd(&isBusy_, [](bool* busy) { *busy = false; });
    return released([&] { return f(simulation); });
  }

  void advanceTo(double t) {
    const bool arrives = alone([t](Simulation& simulation) {
      Uninterrupted keepGoing;
      return simulation.advanceTo(t, std::ref(keepGoing));
    });
    if (arrives) return;
    if (PyErr_Occurred()) throw py::error_already_set();
    throw Failed(simulation_.fault());
  }

  int link(const py::object& given) { return numberOf(given, idle().scene().chain.links(), "link"); }
  int joint(const py::object& given) { return numberOf(given, idle().scene().chain.joints(), "joint"); }
  std::size_t size() { return idle().q().size(); }

  /// Writes q and then q̇, 2n.
  void writeState(double* to) {
    const Simulation& simulation = idle();
    std::copy(simulation.qd().begin(), simulation.qd().end(),
              std::copy(simulation.q().begin(), simulation.q().end(), to));
  }

 private:
  Simulation simulation_;
  bool isBusy_ = false;
};

namespace {

Numbers arrayOf(std::size_t size) {
  return Numbers(static_cast<py::ssize_t>(size));
}

Numbers stateOf(Running& self) {
  Numbers state = arrayOf(2 * self.size());
  self.writeState(state.mutable_data());
  return state;
}

Numbers copyOf(const std::vector<double>& values) {
  return Numbers(static_cast<py::ssize_t>(values.size()), values.data());
}

/// One record a link. Its fields are the members of LinkMotion.
py::array linkMotions(Running& self) {
  static_assert(sizeof(LinkMotion) == 13 * sizeof(double), "the fields below are all of them");
  py::list fields;
  for (const auto& [name, isVector] : {std::pair("inner_pin", true),
                                       {"angle", false},
                                       {"com", true},
                                       {"velocity", true},
                                       {"omega", false},
                                       {"acceleration", true},
                                       {"alpha", false},
                                       {"pin_force", true}}) {
    isVector ? fields.append(py::make_tuple(name, "f8", 2)) : fields.append(py::make_tuple(name, "f8"));
  }
  const std::vector<std::size_t> shape{self.size()};
  py::array motions(py::dtype::from_args(fields), shape);
  self.idle().linkMotions(static_cast<LinkMotion*>(motions.mutable_data()));
  return motions;
}

Vec2d vec2Of(const std::array<double, 2>& xy) {
  return {xy[0], xy[1]};
}

/// Calls at(scene, t, q, qd) for the present state. The scene has the commands in force as loads.
template <class At>
auto atPresent(Simulation& simulation, const At& at) {
  Scene scene = simulation.scene();
  for (const Load& command : simulation.commands()) scene.loads.push_back(command);
  const auto n = static_cast<Eigen::Index>(simulation.q().size());
  return at(scene, simulation.time(), Eigen::VectorXd::Map(simulation.q().data(), n),
            Eigen::VectorXd::Map(simulation.qd().data(), n));
}

void requireTaken(bool isTaken) {
  if (!isTaken) throw std::runtime_error("as many commands as Simulation(commands=...) allows wait already");
}

void bindResults(py::module& module) {
  py::class_<Energy>(module, "Energy", "Energy of a chain, J.")
      .def_readonly("kinetic", &Energy::kinetic)
      .def_readonly("potential", &Energy::potential)
      .def_readonly("elastic", &Energy::elastic, "The part of the potential energy in springs and stops.")
      .def_property_readonly("total", &Energy::total, "kinetic + potential");
  py::class_<EnergyBalance>(module, "EnergyBalance", "Energy balance since the state was last set, J.")
      .def_readonly("now", &EnergyBalance::now)
      .def_readonly("supplied", &EnergyBalance::supplied, "Work of loads and commands on the chain.")
      .def_readonly("dissipated", &EnergyBalance::dissipated, "Work that dampers and stops took.")
      .def_readonly("residual", &EnergyBalance::residual, "What is left over: the error of integration.");
  py::class_<Statistics>(module, "Statistics", "What an integration did since its start.")
      .def_readonly("steps", &Statistics::steps, "Accepted steps.")
      .def_readonly("rejected", &Statistics::rejected, "Steps repeated with a smaller size.")
      .def_readonly("evaluations", &Statistics::evaluations, "Evaluations of the accelerations.")
      .def_readonly("rescues", &Statistics::rescues, "Returns to the last good state.")
      .def_readonly("local_error", &Statistics::localError, "Of the last step, in tolerances.");
}

void bindState(py::class_<Running>& simulation) {
  const auto q = py::arg("q"), qd = py::arg("qd");
  simulation
      .def("advance_to", &Running::advanceTo, py::arg("t"),
           R"(Integrates to time t (s, not before `time`). Other threads run meanwhile; Ctrl-C interrupts.

Raises Failed when the integration fails. The state is then that of the last good step.)")
      .def_property_readonly(
          "time", [](Running& self) { return self.idle().time(); }, "s")
      .def_property_readonly("state", &stateOf, "A new array, 2n: angles q (rad), then rates (rad/s).")
      .def_property_readonly(
          "q", [](Running& self) { return copyOf(self.idle().q()); },
          "A new array, n: relative angles, rad, not wrapped.")
      .def_property_readonly(
          "qd", [](Running& self) { return copyOf(self.idle().qd()); }, "A new array, n: rates, rad/s.")
      .def(
          "set_state",
          [](Running& self, const Numbers& angles, const Numbers& rates) {
            self.idle().setState(vectorOf(angles, "q", self.size()), vectorOf(rates, "qd", self.size()));
          },
          q, qd, "Sets the angles q (n, rad) and rates qd (n, rad/s) at the present time. Commands stay.")
      .def(
          "settle", [](Running& self) { self.alone([](Simulation& its) { its.settle(); }); },
          "Puts the chain at rest in the static equilibrium, searched from the present state. Raises "
          "ValueError if "
          "there is none.")
      .def(
          "reset", [](Running& self) { self.idle().reset(); },
          "Restores the first state and time 0. The same calls then give the same bits again.");
}

/// The n numbers that a member writes.
Numbers written(Running& self, void (Simulation::*write)(double*)) {
  Numbers numbers = arrayOf(self.size());
  (self.idle().*write)(numbers.mutable_data());
  return numbers;
}

void bindQuantities(py::class_<Running>& simulation) {
  simulation
      .def(
          "accelerations", [](Running& self) { return written(self, &Simulation::accelerations); },
          "Returns q̈: n, rad/s².")
      .def(
          "joint_torques", [](Running& self) { return written(self, &Simulation::jointTorques); },
          "Returns the whole torque in each joint, of springs, dampers, stops, friction, drives, loads and\n"
          "commands: n, N m.")
      .def("link_motions", &linkMotions, R"(Returns the motion of each link: n records.

Fields, with base-frame components: inner_pin, com (n×2, m), angle (n, rad), velocity (n×2, m/s), omega
(n, rad/s), acceleration (n×2, m/s²), alpha (n, rad/s²), pin_force (n×2, N, on the link at its inner pin).)")
      .def(
          "base_wrench",
          [](Running& self) {
            const BaseWrench wrench = self.idle().baseWrench();
            return std::array<double, 3>{wrench.force.x, wrench.force.y, wrench.torque};
          },
          "Returns [F_x, F_y, torque] of the chain on its base at the ground pin, in N, N, N m.")
      .def(
          "energy_balance", [](Running& self) { return self.idle().energyBalance(); },
          "Returns the energies and works since the state was last set.")
      .def(
          "statistics", [](Running& self) { return self.idle().statistics(); },
          "Returns the steps made since the start or reset().")
      .def_property_readonly(
          "method", [](Running& self) { return self.idle().method(); }, "In use, such as 'dopri5'.")
      .def(
          "equations", [](Running& self) { return atPresent(self.idle(), equationsAt); },
          "As the function equations(), at the present state, with the commands in force.")
      .def(
          "linearize", [](Running& self) { return atPresent(self.idle(), linearizedAt); },
          "As the function linearize(), at the present state, with the commands in force.");
}

void bindCommands(py::class_<Running>& simulation) {
  const auto joint = py::arg("joint"), link = py::arg("link"), torque = py::arg("torque");
  const auto force = py::arg("force"), point = py::arg("point"), duration = py::arg("duration");
  const auto moment = py::arg("moment") = 0.0;
  const auto start = py::arg("start") = Simulation::now, until = py::arg("until") = forever;
  using Pair = std::array<double, 2>;
  simulation
      .def(
          "hold_torques",
          [](Running& self, const Numbers& torques) {
            holdTorques(self.idle(), vectorOf(torques, "torques", self.size()));
          },
          py::arg("torques"),
          "Holds these torques, n, N m, in the joints until the next ones: 0 in driven joints.")
      .def(
          "hold_torque",
          [](Running& self, const py::object& where, double tau, double end, double begin) {
            requireTaken(self.idle().holdTorque(self.joint(where), tau, end, begin));
          },
          joint, torque, until, start,
          R"(Holds a torque (N m) in a joint (its name or number) until the next such call, or until a time (s).

It acts from `start` (s) on, or at once.)")
      .def(
          "add_torque",
          [](Running& self, const py::object& where, double tau, double length, double begin) {
            requireTaken(self.idle().addTorque(self.joint(where), tau, length, begin));
          },
          joint, torque, duration, start, "Adds a torque (N m) in a joint for exactly this duration (s).")
      .def(
          "hold_force",
          [](Running& self, const py::object& where, const Pair& F, const Pair& X, double M, double end,
             double begin) {
            requireTaken(self.idle().holdForce(self.link(where), vec2Of(X), vec2Of(F), M, end, begin));
          },
          link, force, point, moment, until, start,
          R"(Holds a force (x, y in N, base frame) and a moment (N m) on a link (its name or number).

The force acts at a point of the link: x, y in m, link frame, from its inner pin, where it acts by default. (A
load of a scene acts at the centre of mass by default.) Both last until the next such call for this link, or
until a time (s).)")
      .def(
          "add_force",
          [](Running& self, const py::object& where, const Pair& F, const Pair& X, double length, double M,
             double begin) {
            requireTaken(self.idle().addForce(self.link(where), vec2Of(X), vec2Of(F), M, length, begin));
          },
          link, force, point, duration, moment, start,
          "Adds a force and a moment, as hold_force(), for exactly this duration (s).")
      .def(
          "clear_commands", [](Running& self) { self.idle().clearCommands(); }, "Ends all commands.");
}

}  // namespace

void bindSimulation(py::module& module) {
  bindResults(module);
  py::register_exception<Failed>(module, "Failed", PyExc_RuntimeError).attr("__doc__") =
      "Raised when an integration fails; says why.";
  py::class_<Running> simulation(module, "Simulation", R"(A scene in motion, from time 0.

Deterministic: the same calls give the same bits. commands: how many timed commands may act or wait at once;
0: no commands at all.)");
  simulation.def(py::init([](const TreeAndScene& from, int most) {
                   return released([&] { return std::make_unique<Running>(from, most); });
                 }),
                 py::arg("scene"), py::arg("commands") = 16);
  bindState(simulation);
  bindQuantities(simulation);
  bindCommands(simulation);

  module.def(
      "simulate",
      [](const TreeAndScene& scene, const Numbers& times) {
        const std::vector<double> instants = vectorOf(times, "times");
        requireTimes(instants);
        Running running(scene, 0);
        Numbers states({times.size(), static_cast<py::ssize_t>(2 * running.size())});
        for (std::size_t k = 0; k < instants.size(); ++k) {
          running.advanceTo(instants[k]);
          running.writeState(states.mutable_data(static_cast<py::ssize_t>(k), 0));
        }
        return states;
      },
      py::arg("scene"), py::arg("times"),
      R"(Returns the states at the times (s, from 0, never falling): times × 2n, q (rad) and then q̇ (rad/s).

Raises Failed when the integration fails.)");
}

}  // namespace planar_chain::python
