#include "planar_chain/simulation.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "dynamics/given_state.h"
#include "planar_chain/batch.h"
#include "python/running.h"
#include "python/watching.h"

namespace planar_chain::python {

namespace {

constexpr long long mostCommands = 1'000'000;

Numbers emptyOf(std::size_t size) {
  return Numbers(static_cast<py::ssize_t>(size));
}

Numbers stateOf(Running& self) {
  Numbers state = emptyOf(2 * self.size());
  self.writeState(state.mutable_data());
  return state;
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
  requireFinite("motions", Eigen::VectorXd::Map(static_cast<const double*>(motions.data()),
                                                static_cast<Eigen::Index>(13 * self.size())));
  return motions;
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

void bindResults(py::module& module) {
  const auto energy =
      py::class_<Energy>(module, "Energy", "Energy of a chain, J.")
          .def_readonly("kinetic", &Energy::kinetic)
          .def_readonly("potential", &Energy::potential)
          .def_readonly("elastic", &Energy::elastic, "The part of the potential energy in springs and stops.")
          .def_property_readonly("total", &Energy::total, "kinetic + potential");
  showFields(energy, {"kinetic", "potential", "elastic"});
  const auto balance =
      py::class_<EnergyBalance>(module, "EnergyBalance", "Energy balance since the state was last set, J.")
          .def_readonly("now", &EnergyBalance::now)
          .def_readonly("supplied", &EnergyBalance::supplied, "Work of loads and commands on the chain.")
          .def_readonly("dissipated", &EnergyBalance::dissipated, "Work that dampers and stops took.")
          .def_readonly("residual", &EnergyBalance::residual, "What is left over: the error of integration.");
  showFields(balance, {"now", "supplied", "dissipated", "residual"});
  const auto statistics =
      py::class_<Statistics>(module, "Statistics", "What an integration did since its start.")
          .def_readonly("steps", &Statistics::steps, "Accepted steps.")
          .def_readonly("rejected", &Statistics::rejected, "Steps repeated with a smaller size.")
          .def_readonly("evaluations", &Statistics::evaluations, "Evaluations of the accelerations.")
          .def_readonly("rescues", &Statistics::rescues, "Returns to the last good state.")
          .def_readonly("local_error", &Statistics::localError, "Of the last step, in tolerances.");
  showFields(statistics, {"steps", "rejected", "evaluations", "rescues", "local_error"});
}

/// All that was delivered and not yet returned.
std::vector<Reading> measure(Running& self) {
  std::vector<Reading> readings;
  for (Measurement& one : self.idle().measure()) {
    const std::string& name = self.idle().scene().sensors[static_cast<std::size_t>(one.sensor)].name;
    readings.push_back({name, std::move(one)});
  }
  if (const long long lost = self.idle().lostMeasurements(); lost > 0) {
    warn(std::to_string(lost) +
         " measurements are lost: call measure() more often. See help(Simulation.measure)");
  }
  return readings;
}

void bindReading(py::module& module) {
  const auto reading =
      py::class_<Reading>(module, "Measurement", "What a sensor measured.")
          .def_property_readonly(
              "sensor", [](const Reading& self) { return self.sensor; }, "The sensor's name.")
          .def_property_readonly(
              "number", [](const Reading& self) { return self.measurement.number; },
              "k = 0, 1, 2, … of this sensor.")
          .def_property_readonly(
              "time", [](const Reading& self) { return self.measurement.time; },
              "When it was taken: k/rate, s.")
          .def_property_readonly(
              "delivered", [](const Reading& self) { return self.measurement.delivered; }, "time + delay, s")
          .def_property_readonly(
              "values", [](const Reading& self) { return copyOf(self.measurement.values); },
              "Positions of the encoder's joints (rad or m). Of an IMU: angular velocity x, y, z (rad/s), "
              "then\n"
              "specific force x, y, z (m/s²), in its axes; z is along the joint axes.");
  showFields(reading, {"sensor", "time", "values"});
}

void bindSaving(py::module& module, py::class_<Running>& simulation) {
  py::class_<SavedState>(module, "SavedState",
                         "The state of a Simulation: all that decides what it does next. save() returns it; "
                         "it pickles.")
      .def(py::pickle([](const SavedState& self) { return py::bytes(self.bytes()); },
                      [](const py::bytes& bytes) { return SavedState(bytes); }))
      .def_property_readonly(
          "bytes", [](const SavedState& self) { return py::bytes(self.bytes()); }, "What pickles.")
      .def("__repr__", [](const SavedState& self) {
        return "<SavedState, " + std::to_string(self.bytes().size()) + " bytes>";
      });
  simulation
      .def(
          "save", [](Running& self) { return self.idle().save(); },
          R"(Returns the present state, for restore(): time, angles and rates; the method, its step and what it has
found out; commands that act or wait; torques that lag; what sticks; measurements that were not taken; laws of
driven joints; works and counts. It changes nothing.)")
      .def(
          "restore",
          [](Running& self, const SavedState& saved) {
            Simulation& its = self.idle();
            its.restore(saved);
          },
          py::arg("saved"),
          R"(Goes back to a state that save() returned, here or in another Simulation of the same scene and commands.
The same calls then give the same bits as they gave there. Raises Refused for a state of another scene, another
number of commands, another version of the program or another kind of CPU.)")
      .def(
          "__deepcopy__",
          [](Running& self, const py::object& /*memo*/) { return std::make_unique<Running>(self); },
          py::arg("memo"), "Returns a Simulation in the same state, which goes on by itself.");
}

void bindState(py::class_<Running>& simulation) {
  const auto q = py::arg("q"), qd = py::arg("qd");
  simulation
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
          [](Running& self, const py::object& angles, const py::object& rates) {
            const std::vector<double> given = numbersOf(angles, "q", self.size());
            Simulation& its = self.idle();
            its.setState(given, numbersOf(rates, "qd", self.size()));
            warn(movedWords("q: ", its.scene().chain, given.data(), its.q().data()));
          },
          q, qd,
          "Sets the angles q (n, rad) and rates qd (n, rad/s) at the present time. Commands stay, and "
          "the torques in the lags of motors: motor_torques sets those.")
      .def_property(
          "motor_torques", [](Running& self) { return copyOf(self.idle().motorTorques()); },
          [](Running& self, const py::object& torques) {
            self.idle().setMotorTorques(numbersOf(torques, "motor_torques", self.size()));
          },
          R"(The torque in the lag of each joint's motor (time_constant), n, N m: what the motor gives, unless its
torque-speed line bounds it. Without a lag, the commanded torque that acts.

It can be set, after hold_torques(), so that a run begins in a pose that motors hold. A torque without a lag stays what
is commanded; another one is refused.)")
      .def(
          "settle",
          [](Running& self) {
            self.alone([](Simulation& its) {
              Uninterrupted isUninterrupted;
              its.settle([&] { return isUninterrupted(); });
            });
          },
          "Puts the chain at rest in the static equilibrium, searched from the present state. Raises "
          "ValueError if "
          "there is none.")
      .def(
          "reset", [](Running& self) { self.idle().reset(); },
          "Restores the first state and time 0. The same calls then give the same bits again.")
      .def("__repr__", [](const Running& self) { return "<Simulation, " + self.words() + ">"; });
}

/// The n numbers that a member writes. what: such as "accelerations"
Numbers written(Running& self, void (Simulation::*write)(double*), const char* what) {
  Numbers numbers = emptyOf(self.size());
  (self.idle().*write)(numbers.mutable_data());
  requireFinite(what, Eigen::VectorXd::Map(numbers.data(), numbers.size()));
  return numbers;
}

void bindModels(py::class_<Running>& simulation) {
  simulation
      .def(
          "equations", [](Running& self) { return atPresent(self.idle(), equationsAt); },
          "As the function equations(), at the present state, with the commands in force.")
      .def(
          "linearize",
          [](Running& self, bool motors) {
            requireFewLinks(self.idle().scene());
            return shownModel(self.alone([&](Simulation& its) { return its.linearize(motors); }));
          },
          py::arg("motors") = false,
          R"(As the function linearize(), at the present state, under the commands in force.

motors=True: δτ are commanded torques, and the torques that lag (time_constant) are states behind (δq, δq̇), in chain
order, N m; a torque-speed line that bounds a torque counts, and a command cut off at its limit changes nothing.)");
}

void bindQuantities(py::class_<Running>& simulation) {
  simulation
      .def("measure", &measure,
           "Returns the measurements of the scene's sensors delivered up to `time`, each once, in the order "
           "of\n"
           "delivery. Until this call the newest million values of each sensor are kept, 8 MB; a "
           "warning\n"
           "says how many measurements are lost.")
      .def(
          "accelerations",
          [](Running& self) { return written(self, &Simulation::accelerations, "accelerations"); },
          "Returns q̈: n, rad/s².")
      .def(
          "joint_torques", [](Running& self) { return written(self, &Simulation::jointTorques, "torques"); },
          "Returns the whole torque in each joint, of springs, dampers, stops, friction, drives, loads and\n"
          "commands: n, N m.")
      .def("link_motions", &linkMotions, R"(Returns the motion of each link: n records.

Fields, with base-frame components: inner_pin, com (n×2, m), angle (n, rad), velocity (n×2, m/s), omega
(n, rad/s), acceleration (n×2, m/s²), alpha (n, rad/s²), pin_force (n×2, N, on the link at its inner pin).)")
      .def(
          "base_wrench",
          [](Running& self) {
            const BaseWrench wrench = self.idle().baseWrench();
            requireFinite("forces", Eigen::Vector3d(wrench.force.x, wrench.force.y, wrench.torque));
            return std::array<double, 3>{wrench.force.x, wrench.force.y, wrench.torque};
          },
          "Returns [F_x, F_y, torque] of the chain on its base at the ground pin, in N, N, N m.")
      .def(
          "tip_force",
          [](Running& self) {
            const Vec2d force = self.idle().tipForce();
            return std::array<double, 2>{force.x, force.y};
          },
          "Returns [F_x, F_y], N, on the tip that is held; 0 if it is free.")
      .def(
          "closure_margin", [](Running& self) { return self.idle().closureMargin(); },
          "Returns how far the chain is from a pose stretched or folded between its ends, from 1 to 0; see "
          "SimStatus.msg.")
      .def(
          "closure_error", [](Running& self) { return self.idle().closureError(); },
          "Returns how far the tip is from where it is held, m; 0 if it is free.")
      .def(
          "energy_balance", [](Running& self) { return self.idle().energyBalance(); },
          "Returns the energies and works since the state was last set.")
      .def(
          "statistics", [](Running& self) { return self.idle().statistics(); },
          "Returns the steps made since the start or reset().")
      .def_property_readonly(
          "method", [](Running& self) { return self.idle().method(); }, "In use, such as 'dopri5'.");
}

}  // namespace

void bindSimulation(py::module& module) {
  bindResults(module);
  bindReading(module);
  py::register_exception<Failed>(module, "Failed", PyExc_RuntimeError).attr("__doc__") =
      "Raised when an integration fails; says why.";
  py::class_<Running> simulation(module, "Simulation", R"(A scene in motion, from time 0.

Deterministic: the same calls give the same bits. commands: how many timed commands may act or wait at once;
0: no commands at all.)");
  simulation.def(py::init([](const TreeAndScene& from, const py::object& most) {
                   const auto commands = static_cast<int>(countOf(most, "commands", 0, mostCommands));
                   return released([&] { return std::make_unique<Running>(from, commands, true); });
                 }),
                 py::arg("scene"), py::arg("commands") = 16);
  bindAdvance(simulation);
  bindState(simulation);
  bindSaving(module, simulation);
  bindQuantities(simulation);
  bindModels(simulation);
  bindMotion(simulation);
  bindCommands(simulation);
  bindDerivatives(module, simulation);
  bindLaws(simulation);

  module.def(
      "simulate",
      [](const TreeAndScene& scene, const py::object& times, const py::object& mostSteps,
         const py::object& derivatives, const py::object& events) -> py::object {
        const std::vector<double> instants = timesOf(times);
        requireTimes(instants);
        if (!derivatives.is_none() || !events.is_none())
          return runOf(scene, instants, derivatives, events, mostSteps);
        Running running(scene, 0);
        const StepBudget budget = running.budget(instants.empty() ? 0 : instants.back(), stepsOf(mostSteps));
        Numbers states(
            {static_cast<py::ssize_t>(instants.size()), static_cast<py::ssize_t>(2 * running.size())});
        for (std::size_t k = 0; k < instants.size(); ++k) {
          running.advanceTo(instants[k], budget);
          running.writeState(states.mutable_data(static_cast<py::ssize_t>(k), 0));
        }
        return std::move(states);
      },
      py::arg("scene"), py::arg("times"), py::arg("most_steps") = py::none(),
      py::arg("derivatives") = py::none(), py::arg("events") = py::none(),
      R"(Returns the states at the times (s, from 0, never falling): times × 2n, q (rad) and then q̇ (rad/s).

With derivatives, a list of "state", "torques" and paths of numbers of the scene, it returns a Run: states, and the dict
derivatives, whose arrays are times × 2n × columns: by the first state, by torques that are held in the joints (no motor
acts), by each number. Raises ValueError if the motion has none.

With events, as Simulation.advance_to() takes them, it returns a Run, too: times and states up to a terminal event, whose
number is terminal, and t_events and y_events.

Raises Failed when the integration fails, or after most_steps steps, as Simulation.advance_to().)");
}

}  // namespace planar_chain::python
