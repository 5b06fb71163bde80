#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "planar_chain/batch.h"
#include "planar_chain/scene_reader.h"
#include "python/bindings.h"

namespace planar_chain::python {

namespace {

/// Values for each run by their paths in the scene, such as "links/lower/mass".
using Columns = std::map<std::string, std::vector<double>>;

/// The results of many runs. Arrays show its memory.
struct Runs {
  BatchResult result;
  py::ssize_t times, size;

  py::ssize_t count() const { return static_cast<py::ssize_t>(result.runs.size()); }
};

/// Those of Python's arguments that the threads read.
struct Given {
  std::vector<double> initial;  ///< 2n a run, or none
  Columns columns;
  std::size_t runs = 0;
};

Given given(const TreeAndScene& scene, const std::optional<Numbers>& initial,
            const std::map<std::string, Numbers>& parameters) {
  const py::ssize_t width = 2 * scene.scene.chain.size();
  Given all;
  if (initial) {
    if (initial->ndim() != 2 || initial->shape(1) != width) {
      std::string got;
      for (py::ssize_t k = 0; k < initial->ndim(); ++k) {
        got += (k > 0 ? " x " : "") + std::to_string(initial->shape(k));
      }
      throw std::invalid_argument("initial: expected an array of runs x " + std::to_string(width) + ", got " +
                                  (got.empty() ? "one number" : got));
    }
    all.initial.assign(initial->data(), initial->data() + initial->size());
    all.runs = static_cast<std::size_t>(initial->shape(0));
  } else if (!parameters.empty()) {
    all.runs = static_cast<std::size_t>(parameters.begin()->second.size());
  } else {
    throw std::invalid_argument("expected initial states, parameters, or both");
  }
  for (const auto& [path, values] : parameters) {
    all.columns[path] = vectorOf(values, all.runs, path.c_str());
  }
  return all;
}

SceneOfRun sceneOfRun(const TreeAndScene& from, const Given& all) {
  return [&](std::size_t run, Scene& scene) {
    if (!all.columns.empty()) {
      Value tree = from.tree;
      for (const auto& [path, values] : all.columns) setAt(tree, path, values[run]);
      scene = readScene(tree);
    }
    if (all.initial.empty()) return;
    const auto n = static_cast<std::ptrdiff_t>(from.scene.q.size());
    const double* q = all.initial.data() + static_cast<std::ptrdiff_t>(run) * 2 * n;
    scene.q.assign(q, q + n);
    scene.qd.assign(q + n, q + 2 * n);
  };
}

/// A path to an unknown link is a fault of all runs. A value out of its range, or an unknown key, is a fault
/// of its run.
void requirePaths(const SceneOfRun& sceneOfRun, const TreeAndScene& scene, const Given& all) {
  if (all.runs == 0) return;
  try {
    Scene first = scene.scene;
    sceneOfRun(0, first);
  } catch (const Refused& refused) {
    for (const Fault& fault : refused.faults()) {
      if (all.columns.count(fault.path) == 0) throw;
    }
  }
}

Runs simulateMany(const TreeAndScene& scene, const Numbers& times, const std::optional<Numbers>& initial,
                  const std::map<std::string, Numbers>& parameters, int threads, const py::object& progress) {
  const std::vector<double> instants = vectorOf(times, static_cast<std::size_t>(times.size()), "times");
  const Given all = given(scene, initial, parameters);
  BatchOptions options;
  options.threads = threads;
  options.keepGoing = [&](std::size_t ended) {
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!progress.is_none()) progress(ended);
    return true;
  };
  const SceneOfRun each = sceneOfRun(scene, all);
  requirePaths(each, scene, all);
  BatchResult result;
  {
    const py::gil_scoped_release others;
    result = planar_chain::simulateMany(scene.scene, all.runs, each, instants, options);
  }
  return {std::move(result), times.size(), static_cast<py::ssize_t>(2 * scene.scene.q.size())};
}

}  // namespace

void bindMany(py::module& module) {
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
          "reasons",
          [](const Runs& self) {
            std::map<std::size_t, std::string> reasons;
            for (std::size_t run = 0; run < self.result.runs.size(); ++run) {
              if (!self.result.runs[run].reason.empty()) reasons[run] = self.result.runs[run].reason;
            }
            return reasons;
          },
          "Why each failed run failed, by its number.")
      .def_property_readonly(
          "steps",
          [](const Runs& self) {
            py::array_t<std::int64_t> steps(self.count());
            for (py::ssize_t run = 0; run < self.count(); ++run) {
              steps.mutable_at(run) = self.result.runs[static_cast<std::size_t>(run)].steps;
            }
            return steps;
          },
          "runs: accepted steps of each run.");
  module.def("simulate_many", &simulateMany, py::arg("scene"), py::arg("times"),
             py::arg("initial") = py::none(), py::arg("parameters") = std::map<std::string, Numbers>{},
             py::arg("threads") = 0, py::arg("progress") = py::none(),
             R"(Simulates a scene many times, on all cores (or so many threads), and returns Runs.

times: s, from 0, never falling. initial: runs × 2n first states, q (rad) and then q̇ (rad/s). parameters: a
dict from paths in the scene, such as 'links/lower/mass', to arrays of one number a run. progress: called
about ten times a second with the number of runs that have ended.

Raises Refused if a path names an unknown link. The results depend neither on the number of threads nor on the
other runs. A run whose scene is refused, or whose integration fails, is not done and has a reason.)");
}

}  // namespace planar_chain::python
