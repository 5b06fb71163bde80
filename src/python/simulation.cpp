#include "planar_chain/simulation.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "dynamics/given_state.h"
#include "planar_chain/batch.h"
#include "python/running.h"

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

/// Lets a simulation follow its derivatives as long as this lives.
class Following {
 public:
  explicit Following(Simulation& its, const std::vector<VariedNumber>& numbers = {}) : its_(its) {
    its_.followDerivatives(numbers);
  }
  Following(const Following&) = delete;
  Following& operator=(const Following&) = delete;
  ~Following() { its_.stopDerivatives(); }

 private:
  Simulation& its_;
};

constexpr const char* byState = "state";
constexpr const char* byTorques = "torques";

/// The motion and its derivatives, as simulate() returns them.
struct Run {
  Numbers states;
  py::dict derivatives;
};

Run differentiated(const TreeAndScene& scene, const std::vector<double>& instants, const py::object& names,
                   const py::object& mostSteps) {
  std::vector<std::string> wanted;
  std::vector<VariedNumber> numbers;
  for (const py::handle& name : py::list(names)) {
    wanted.push_back(textOf(py::reinterpret_borrow<py::object>(name), "derivatives"));
    if (wanted.back() != byState && wanted.back() != byTorques)
      numbers.push_back(variedNumber(scene.tree, wanted.back()));
  }
  Running running(scene, 0);
  const StepBudget budget = running.budget(instants.empty() ? 0 : instants.back(), stepsOf(mostSteps));
  const Following following(running.idle(), numbers);
  const auto rows = static_cast<py::ssize_t>(2 * running.size()),
             count = static_cast<py::ssize_t>(instants.size());
  Run run{Numbers({count, rows}), {}};
  std::vector<Numbers> arrays;
  for (const std::string& name : wanted) {
    arrays.emplace_back(std::vector<py::ssize_t>{count, rows,
                                                 name == byState     ? rows
                                                 : name == byTorques ? rows / 2
                                                                     : py::ssize_t{1}});
    run.derivatives[py::str(name)] = arrays.back();
  }
  for (py::ssize_t k = 0; k < count; ++k) {
    running.advanceTo(instants[static_cast<std::size_t>(k)], budget);
    running.writeState(run.states.mutable_data(k, 0));
    const Derivatives at = running.idle().derivatives();
    Eigen::Index number = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const Eigen::MatrixXd columns = wanted[i] == byState     ? at.state
                                      : wanted[i] == byTorques ? at.torques
                                                               : Eigen::MatrixXd(at.numbers.col(number++));
      using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      Eigen::Map<RowMajor>(arrays[i].mutable_data(k, 0, 0), columns.rows(), columns.cols()) = columns;
    }
  }
  return run;
}

void bindState(py::class_<Running>& simulation) {
  const auto q = py::arg("q"), qd = py::arg("qd");
  simulation
      .def(
          "advance_to",
          [](Running& self, const py::object& t, const py::object& mostSteps) {
            const double end = numberOf(t, "t");
            self.advanceTo(end, self.budget(end, stepsOf(mostSteps)),
                           "; set_state(), settle(), reset() or clear_commands() lets it go on");
          },
          py::arg("t"), py::arg("most_steps") = py::none(),
          R"(Integrates to time t (s, not before `time`). Other threads run meanwhile; Ctrl-C interrupts.

Raises Failed when the integration fails, or after most_steps steps: by default a million for each second so far,
and at least a million. The state is then that of the last good step.)")
      .def(
          "transition",
          [](Running& self, const py::object& t, const py::object& mostSteps) {
            const double end = numberOf(t, "t");
            const StepBudget budget = self.budget(end, stepsOf(mostSteps));
            const Following following(self.idle());
            self.advanceTo(end, budget);
            Derivatives derivatives = self.idle().derivatives();
            return py::make_tuple(std::move(derivatives.state), std::move(derivatives.torques));
          },
          py::arg("t"), py::arg("most_steps") = py::none(),
          R"(Advances to t as advance_to(), and returns Phi, Gamma: how the state (q, q̇) at t changes with the present
one, 2n × 2n, and with torques that are held in the joints from now to t, 2n × n; through motors as commanded torques.

In a closed chain a change of the state counts as far as the tip allows it; driven joints have columns of zeros. Raises
ValueError, at t, if the motion has no derivatives.)")
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
          "the torques in the lags of motors.")
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
          "method", [](Running& self) { return self.idle().method(); }, "In use, such as 'dopri5'.")
      .def(
          "equations", [](Running& self) { return atPresent(self.idle(), equationsAt); },
          "As the function equations(), at the present state, with the commands in force.")
      .def(
          "linearize", [](Running& self) { return atPresent(self.idle(), linearizedAt); },
          "As the function linearize(), at the present state, with the commands in force, whose torques "
          "count as constant.");
}

}  // namespace

void bindSimulation(py::module& module) {
  bindResults(module);
  py::class_<Run>(module, "Run", "What simulate() returns with derivatives.")
      .def_readonly("states", &Run::states, "times × 2n: q (rad), then q̇ (rad/s).")
      .def_readonly("derivatives", &Run::derivatives, "Arrays by name: times × 2n × columns.");
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
  bindState(simulation);
  bindQuantities(simulation);
  bindCommands(simulation);
  bindLaws(simulation);

  module.def(
      "simulate",
      [](const TreeAndScene& scene, const py::object& times, const py::object& mostSteps,
         const py::object& derivatives) -> py::object {
        const std::vector<double> instants = timesOf(times);
        requireTimes(instants);
        if (!derivatives.is_none()) return py::cast(differentiated(scene, instants, derivatives, mostSteps));
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
      py::arg("derivatives") = py::none(),
      R"(Returns the states at the times (s, from 0, never falling): times × 2n, q (rad) and then q̇ (rad/s).

With derivatives, a list of "state", "torques" and paths of numbers of the scene, it returns a Run: states, and the dict
derivatives, whose arrays are times × 2n × columns: by the first state, by torques that are held in the joints, by each
number. Raises ValueError if the motion has none.

Raises Failed when the integration fails, or after most_steps steps, as Simulation.advance_to().)");
}

}  // namespace planar_chain::python
