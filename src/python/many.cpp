#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "planar_chain/batch.h"
#include "planar_chain/simulation.h"
#include "python/bindings.h"

namespace planar_chain::python {

/// The results of many runs. Arrays show its memory.
struct Runs {
  BatchResult result;
  py::ssize_t times, size;

  py::ssize_t count() const { return static_cast<py::ssize_t>(result.runs.size()); }
};

namespace {

/// Writes torques, and their number of runs.
void readTorques(const py::object& given, py::ssize_t times, py::ssize_t joints,
                 std::optional<std::size_t>& runs, std::vector<double>& to) {
  if (given.is_none()) return;
  const Numbers torques = arrayOf(given, "torques");
  const bool fits = torques.ndim() == 3 && torques.shape(1) == times && torques.shape(2) == joints &&
                    (!runs || static_cast<std::size_t>(torques.shape(0)) == *runs);
  if (!fits) {
    const std::string expected = runs ? std::to_string(*runs) : "runs";
    throw Refused({{"torques",
                    "an array of " + expected + " x " + std::to_string(times) + " x " +
                        std::to_string(joints) + ", for each run, time and joint",
                    shapeOf(torques)}});
  }
  to.assign(torques.data(), torques.data() + torques.size());
  runs = static_cast<std::size_t>(torques.shape(0));
}

/// The numbers that differ between runs, and the number of runs.
std::pair<Varied, std::size_t> variedBy(const TreeAndScene& scene, const py::object& initial,
                                        const py::object& parameters, const py::object& torques,
                                        std::size_t times, std::vector<double>& held) {
  const py::ssize_t width = 2 * scene.scene.chain.size();
  Varied varied;
  std::optional<std::size_t> runs;
  const py::dict columns = dictOf(parameters, "parameters");
  if (!initial.is_none()) {
    const Numbers starts = arrayOf(initial, "initial");
    if (starts.ndim() != 2 || starts.shape(1) != width) {
      throw Refused({{"initial", "an array of runs x " + std::to_string(width), shapeOf(starts)}});
    }
    varied.starts.assign(starts.data(), starts.data() + starts.size());
    runs = static_cast<std::size_t>(starts.shape(0));
  } else if (columns.empty() && torques.is_none()) {
    throw Refused({{"initial", "initial states, parameters, or torques", "none of them"}});
  }
  for (const auto& [key, values] : columns) {
    const std::string path = textOf(py::reinterpret_borrow<py::object>(key), "parameters");
    const std::vector<double>& column = varied.numbers[path] =
        numbersOf(py::reinterpret_borrow<py::object>(values), path.c_str(), runs);
    runs = column.size();
  }
  readTorques(torques, static_cast<py::ssize_t>(times), width / 2, runs, held);
  return {std::move(varied), *runs};
}

/// The state in which all runs begin, or nullptr.
const SavedState* startOf(const py::object& state, const py::object& initial, const py::object& parameters,
                          const py::object& torques) {
  if (state.is_none()) return nullptr;
  if (!py::isinstance<SavedState>(state))
    throw Refused({{"state", "a state that Simulation.save() returned", shown(state)}});
  if (!initial.is_none() || !dictOf(parameters, "parameters").empty())
    throw Refused(
        {{"state", "no initial states or parameters beside it, which is that of one scene", "them"}});
  if (torques.is_none()) throw Refused({{"torques", "those of each run, which begins in the state", "none"}});
  return &state.cast<const SavedState&>();
}

/// One warning for all runs.
void warnOfNotes(const BatchResult& result) {
  const auto hasNotes = [](const BatchRun& run) { return !run.notes.empty(); };
  const auto first = std::find_if(result.runs.begin(), result.runs.end(), hasNotes);
  if (first == result.runs.end()) return;
  warn(std::to_string(std::count_if(first, result.runs.end(), hasNotes)) + " of " +
       std::to_string(result.runs.size()) + " runs have notes; of run " +
       std::to_string(first - result.runs.begin()) + ": " + first->notes);
}

/// The texts that are not empty, by the numbers of their runs.
std::map<std::size_t, std::string> saidBy(const Runs& runs, std::string BatchRun::*what) {
  std::map<std::size_t, std::string> said;
  for (std::size_t run = 0; run < runs.result.runs.size(); ++run) {
    if (const std::string& text = runs.result.runs[run].*what; !text.empty()) said[run] = text;
  }
  return said;
}

Runs simulateMany(const TreeAndScene& scene, const py::object& times, const py::object& initial,
                  const py::object& parameters, const py::object& threads, const py::object& progress,
                  const py::object& mostSteps, const py::object& torques, const py::object& state) {
  const std::vector<double> instants = timesOf(times);
  BatchOptions options;
  options.state = startOf(state, initial, parameters, torques);
  const auto [varied, runs] = variedBy(scene, initial, parameters, torques, instants.size(), options.torques);
  if (!progress.is_none() && PyCallable_Check(progress.ptr()) == 0) {
    throw Refused({{"progress", "a function of the number of runs that have ended", shown(progress)}});
  }
  options.threads = static_cast<int>(countOf(threads, "threads", 0, 1 << 20));
  options.mostSteps = stepsOf(mostSteps);
  options.keepGoing = [&](std::size_t ended) {
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!progress.is_none()) progress(ended);
    return true;
  };
  const SceneOfRun each = sceneOfRun(scene.tree, varied);
  BatchResult result;
  {
    const py::gil_scoped_release others;
    result = planar_chain::simulateMany(scene.scene, runs, each, instants, options);
  }
  warnOfNotes(result);
  return {std::move(result), static_cast<py::ssize_t>(instants.size()),
          static_cast<py::ssize_t>(2 * scene.scene.q.size())};
}

void bindRuns(py::module& module) {
  py::class_<Runs>(module, "Runs", "The results of simulate_many().")
      .def_property_readonly(
          "states",
          [](const py::object& self) {
            const auto& runs = self.cast<const Runs&>();
            const std::vector<py::ssize_t> shape{runs.count(), runs.times, runs.size};
            return py::array(shape, runs.result.states.data(), self);
          },
          R"(runs × times × 2n: angles q (rad), then rates q̇ (rad/s).

NaN where a failed run did not arrive.)")
      .def_property_readonly(
          "done",
          [](const Runs& self) {
            py::array_t<bool> done(self.count());
            for (py::ssize_t run = 0; run < self.count(); ++run) {
              done.mutable_at(run) =
                  self.result.runs[static_cast<std::size_t>(run)].outcome == RunOutcome::done;
            }
            return done;
          },
          "runs: True for each run that reached all times.")
      .def_property_readonly(
          "reasons", [](const Runs& self) { return saidBy(self, &BatchRun::reason); },
          "Why each failed run failed, by its number.")
      .def_property_readonly(
          "notes", [](const Runs& self) { return saidBy(self, &BatchRun::notes); },
          "Notes on the scenes of runs, by their numbers: those that `scene` does not have.")
      .def_property_readonly(
          "steps",
          [](const Runs& self) {
            py::array_t<std::int64_t> steps(self.count());
            for (py::ssize_t run = 0; run < self.count(); ++run) {
              steps.mutable_at(run) = self.result.runs[static_cast<std::size_t>(run)].steps;
            }
            return steps;
          },
          "runs: accepted steps of each run.")
      .def("__repr__", [](const Runs& self) {
        const auto failed = std::count_if(self.result.runs.begin(), self.result.runs.end(),
                                          [](const auto& run) { return run.outcome != RunOutcome::done; });
        return "<Runs: " + std::to_string(self.count()) + ", " + std::to_string(failed) + " failed>";
      });
}

}  // namespace

void bindMany(py::module& module) {
  bindRuns(module);
  module.def("simulate_many", &simulateMany, py::arg("scene"), py::arg("times"),
             py::arg("initial") = py::none(), py::arg("parameters") = py::dict(), py::arg("threads") = 0,
             py::arg("progress") = py::none(), py::arg("most_steps") = py::none(),
             py::arg("torques") = py::none(), py::arg("state") = py::none(),
             R"(Simulates a scene many times, on all cores (or so many threads), and returns Runs.

times: s, from 0, never falling. initial: runs × 2n first states, q (rad) and then q̇ (rad/s). parameters: a
dict from paths in the scene, such as 'links/lower/mass', to arrays of one number a run. progress: called
about ten times a second with the number of runs that have ended. torques: runs × times × n, commanded torques
(N m; N in a prismatic joint), each held from the time before (at first from 0) to its time, as hold_torques() holds
them. state: of Simulation.save(): each run goes on from there under its torques, as after restore(), bit for bit;
times are those of that simulation, not counted from the state.

Raises Refused, with all faults, if the scene has no number at a path, or if initial and a path set the same
state. The results depend neither on the number of threads nor on the
other runs. A run whose scene is refused, whose integration fails, or that needs more than most_steps steps
(by default a million for each second so far, and at least a million), is not done and has a reason.)");
}

}  // namespace planar_chain::python
