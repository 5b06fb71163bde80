#pragma once

/// A simulation as Python holds it, and its arguments.

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "python/bindings.h"
#include "reading/names.h"
#include "run/step_budget.h"

namespace planar_chain::python {

constexpr double forever = std::numeric_limits<double>::infinity();

/// Why an integration ended early.
struct Failed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

template <class Things>
Indices indicesOf(const Things& things) {
  Indices indices;
  for (const auto& thing : things) indices.emplace(thing.name, static_cast<int>(indices.size()));
  return indices;
}

/// The number of a link or joint that is given by number or name. `things`: the links or joints of the chain;
/// `others`: its joints or links.
template <class Things, class Others>
int numberOf(const py::object& given, const Things& things, const std::string& what, const Others& others) {
  auto found = things.end();
  if (py::isinstance<py::str>(given)) {
    found = std::find_if(things.begin(), things.end(),
                         [&](const auto& thing) { return given.equal(py::str(thing.name)); });
    if (found == things.end()) {
      const Indices otherwise = indicesOf(others);
      throw Refused(
          {{what, oneOf(what, textIn(given).value_or(""), indicesOf(things), &otherwise), shown(given)}});
    }
  } else if (const std::optional<py::ssize_t> place = indexIn(given)) {
    if (*place >= 0 && *place < static_cast<py::ssize_t>(things.size())) found = things.begin() + *place;
  }
  if (found != things.end()) return static_cast<int>(found - things.begin());
  throw Refused(
      {{what, "the name of a " + what + ", or a number from 0 to " + std::to_string(things.size() - 1),
        shown(given)}});
}

/// A measurement, with the name of its sensor.
struct Reading {
  std::string sensor;
  Measurement measurement;
};

/// A simulation that one thread at a time may use.
class Running {
 public:
  Running(const TreeAndScene& from, int commands, bool measures = false)
      : simulation_(std::make_unique<Simulation>(from.scene, commands, measures)) {}
  /// In the same state.
  explicit Running(Running& other) : simulation_(other.idle().copy()) {}

  /// @throws std::runtime_error while it is advanced
  Simulation& idle() {
    if (isBusy_)
      throw std::runtime_error(
          "another thread advances this simulation, or it calls an event function, which may not use it");
    return *simulation_;
  }

  /// Returns f(simulation) while other threads run. They may not use this simulation.
  template <class F>
  auto alone(const F& f) {
    Simulation& simulation = idle();
    isBusy_ = true;
    const std::unique_ptr<bool, void (*)(bool*)> atEnd(&isBusy_, [](bool* busy) { *busy = false; });
    return released([&] { return f(simulation); });
  }

  /// The steps of a run that ends at `end`, s.
  StepBudget budget(double end, std::optional<long long> mostSteps) { return {idle(), end, mostSteps}; }

  /// cure: words after the reason of a failure
  void advanceTo(double t, const StepBudget& budget, const char* cure = "") {
    advance([t](Simulation& simulation, const auto& keepGoing) { return simulation.advanceTo(t, keepGoing); },
            budget, cure);
  }
  /// Advances by way(simulation, keepGoing), which returns true if it arrives.
  template <class Way>
  void advance(const Way& way, const StepBudget& budget, const char* cure) {
    const bool arrives = alone([&](Simulation& simulation) {
      Uninterrupted isUninterrupted;
      return way(simulation, [&] { return isUninterrupted() && budget.isLeft(); });
    });
    if (arrives) return;
    if (PyErr_Occurred()) throw py::error_already_set();
    throw Failed(simulation_->fault().empty() ? budget.reason() : simulation_->fault() + cure);
  }

  /// A failure may be the commands' fault: the simulation goes on from its last good state.
  void clearCommands() {
    Simulation& simulation = idle();
    simulation.clearCommands();
    if (!simulation.fault().empty()) simulation.setState(simulation.q(), simulation.qd());
  }

  int link(const py::object& given) { return numberOf(given, chain().links(), "link", chain().joints()); }
  int joint(const py::object& given) { return numberOf(given, chain().joints(), "joint", chain().links()); }
  const Chain& chain() { return idle().scene().chain; }
  const Link& linkAt(int link) { return idle().scene().chain.links()[static_cast<std::size_t>(link)]; }
  std::size_t size() { return idle().q().size(); }

  /// Such as "n = 2, t = 0.5 s". Any thread may call it.
  std::string words() const {
    return "n = " + std::to_string(simulation_->scene().chain.size()) +
           (isBusy_ ? ", advanced by a thread" : ", t = " + toText(simulation_->time()) + " s");
  }

  /// For each event of the last advance_to() with events, an array of times and one of states.
  /// Empty: there was none.
  py::object timesOfEvents, statesOfEvents;

  /// Writes q and then q̇, 2n.
  void writeState(double* to) {
    const Simulation& simulation = idle();
    std::copy(simulation.qd().begin(), simulation.qd().end(),
              std::copy(simulation.q().begin(), simulation.q().end(), to));
  }

 private:
  std::unique_ptr<Simulation> simulation_;
  bool isBusy_ = false;
};

void bindCommands(py::class_<Running>& simulation);
/// Simulation.transition(), and what simulate() returns with derivatives or events.
void bindDerivatives(py::module& module, py::class_<Running>& simulation);
/// simulate() with a list of derivatives, or with events. Either may be None.
py::object runOf(const TreeAndScene& scene, const std::vector<double>& instants, const py::object& names,
                 const py::object& events, const py::object& mostSteps);
/// Simulation.advance_to(), and the events on its way.
void bindAdvance(py::class_<Running>& simulation);
/// Motions of frames.
void bindMotion(py::class_<Running>& simulation);
/// Laws that driven joints and the base follow.
void bindLaws(py::class_<Running>& simulation);

}  // namespace planar_chain::python
