#include "planar_chain/derivatives.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "python/running.h"
#include "python/watching.h"

namespace planar_chain::python {

/// The motion, its derivatives and events, as simulate() returns them.
struct Run {
  py::object times, states;
  py::dict derivatives{};
  py::list timesOfEvents{}, statesOfEvents{};
  py::object terminal = py::none();
};

namespace {

/// Lets a simulation follow its derivatives as long as this lives.
class Following {
 public:
  explicit Following(Simulation& its, const std::vector<VariedNumber>& numbers = {}, bool motors = false)
      : its_(its) {
    its_.followDerivatives(numbers, motors);
  }
  Following(const Following&) = delete;
  Following& operator=(const Following&) = delete;
  ~Following() { its_.stopDerivatives(); }

 private:
  Simulation& its_;
};

constexpr const char* byState = "state";
constexpr const char* byTorques = "torques";

void warnOf(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) warn(note);
}

/// The first rows of an array.
py::object firstOf(const py::object& array, py::ssize_t rows) {
  return array[py::slice(0, rows, 1)];
}

}  // namespace

py::object runOf(const TreeAndScene& scene, const std::vector<double>& instants, const py::object& names,
                 const py::object& events, const py::object& mostSteps) {
  std::optional<Watching> watching;
  if (!events.is_none()) watching.emplace(events);
  std::vector<std::string> wanted;
  std::vector<VariedNumber> numbers;
  for (const py::handle& name : names.is_none() ? py::list() : py::list(names)) {
    wanted.push_back(textOf(py::reinterpret_borrow<py::object>(name), "derivatives"));
    if (wanted.back() != byState && wanted.back() != byTorques) numbers.push_back(scene.near(wanted.back()));
  }
  Running running(scene, 0);
  const StepBudget budget = running.budget(instants.empty() ? 0 : instants.back(), stepsOf(mostSteps));
  std::optional<Following> following;
  if (!names.is_none()) following.emplace(running.idle(), numbers);
  const auto rows = static_cast<py::ssize_t>(2 * running.size()),
             count = static_cast<py::ssize_t>(instants.size());
  Numbers states({count, rows});
  std::vector<Numbers> arrays;
  for (const std::string& name : wanted) {
    arrays.emplace_back(std::vector<py::ssize_t>{count, rows,
                                                 name == byState     ? rows
                                                 : name == byTorques ? rows / 2
                                                                     : py::ssize_t{1}});
  }
  py::ssize_t made = 0;  // rows
  for (bool isOver = false; made < count && !isOver;) {
    const py::ssize_t k = made;
    const double t = instants[static_cast<std::size_t>(k)];
    if (watching) isOver = watching->advanceTo(running, t, budget);
    if (!watching) running.advanceTo(t, budget);
    if (running.idle().time() < t) break;
    ++made;
    running.writeState(states.mutable_data(k, 0));
    if (!following) continue;
    const Derivatives at = running.idle().derivatives();
    if (k == 0 && std::count(wanted.begin(), wanted.end(), byState) > 0) warnOf(at.notes);
    Eigen::Index number = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const Eigen::MatrixXd columns = wanted[i] == byState     ? at.state
                                      : wanted[i] == byTorques ? at.torques
                                                               : Eigen::MatrixXd(at.numbers.col(number++));
      using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      Eigen::Map<RowMajor>(arrays[i].mutable_data(k, 0, 0), columns.rows(), columns.cols()) = columns;
    }
  }
  Run run{firstOf(Numbers(count, instants.data()), made), firstOf(states, made)};
  for (std::size_t i = 0; i < wanted.size(); ++i)
    run.derivatives[py::str(wanted[i])] = firstOf(arrays[i], made);
  if (watching) {
    run.timesOfEvents = watching->times();
    run.statesOfEvents = watching->states(2 * running.size());
    run.terminal = watching->terminal();
  }
  return py::cast(run);
}

void bindDerivatives(py::module& module, py::class_<Running>& simulation) {
  py::class_<Run>(module, "Run", "What simulate() returns with derivatives or events.")
      .def_readonly("times", &Run::times, "Those reached before a terminal event, s.")
      .def_readonly("states", &Run::states, "times × 2n: q (rad), then q̇ (rad/s).")
      .def_readonly("derivatives", &Run::derivatives, "Arrays by name: times × 2n × columns.")
      .def_readonly("t_events", &Run::timesOfEvents, "For each event an array of its times, s.")
      .def_readonly("y_events", &Run::statesOfEvents,
                    "For each event an array of the states then, times × 2n.")
      .def_readonly("terminal", &Run::terminal, "The number of the event that ended the run, or None.");
  simulation.def(
      "transition",
      [](Running& self, const py::object& t, const py::object& mostSteps, bool motors) {
        const double end = numberOf(t, "t");
        const StepBudget budget = self.budget(end, stepsOf(mostSteps));
        const Following following(self.idle(), {}, motors);
        self.advanceTo(end, budget);
        Derivatives derivatives = self.idle().derivatives();
        warnOf(derivatives.notes);
        return py::make_tuple(std::move(derivatives.state), std::move(derivatives.torques));
      },
      py::arg("t"), py::arg("most_steps") = py::none(), py::arg("motors") = false,
      R"(Advances to t as advance_to(), and returns Phi, Gamma: how the state (q, q̇) at t changes with the present
one, 2n × 2n, and with torques that are held in the joints from now to t, 2n × n; through motors as commanded torques.

motors=True: the k torques that lag (time_constant) are states behind (q, q̇), in chain order, N m, as motor_torques has
them: Phi is (2n+k) × (2n+k), Gamma (2n+k) × n. Otherwise a warning says that products over intervals leave them out.

In a closed chain a change of the state counts as far as the tip allows it; driven joints have columns of zeros. Raises
ValueError, at t, if the motion has no derivatives.)");
}

}  // namespace planar_chain::python
