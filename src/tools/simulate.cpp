/// simulate SCENE.yaml --duration T, or --urdf ROBOT.urdf: runs a scene as fast as possible and writes its
/// motion as CSV or as the bag of a node.

#include <dlfcn.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "ode/methods.h"
#include "planar_chain/simulation.h"
#include "ros/bag/bags.h"
#include "run/step_budget.h"
#include "tools/common.h"
#include "tools/csv.h"
#include "tools/until.h"

namespace planar_chain::tools {
namespace {

bool wantsBags(const Arguments& given) {
  return given.has("bag") || given.has("commands") || given.has("write-urdf");
}

// ---- Rows in time ----------------------------------------------------------------------------

/// The times 0, 1/rate, 2/rate … and the duration, each computed from its index.
struct Rows {
  Rows(double givenDuration, double givenRate) : duration(givenDuration), rate(givenRate) {
    // If the duration is a multiple of 1/rate, up to rounding, there is no extra row just before its end.
    constexpr double rounding = 4e-15;  // some twenty roundings: of both numbers and their product
    const double product = duration * rate;
    const double nearest = std::round(product);
    endsOnATick = nearest > 0 && std::abs(product - nearest) <= rounding * product;
    last = endsOnATick ? nearest : std::ceil(product);
  }
  /// True if row k lies at k/rate, as the ticks of a node do.
  bool isTick(double k) const { return k < last || endsOnATick; }
  double time(double k) const { return k >= last ? duration : k / rate; }

  double duration, rate;
  double last;  ///< index; a double, because it may be huge before it is checked
  bool endsOnATick;
};

Rows rowsOf(double duration, double rate, std::vector<Fault>& faults) {
  const Rows rows(duration, rate);
  if (!(rows.last <= mostRows)) {
    faults.push_back({"--rate", "at most 100000000 rows in all", toText(rows.last)});
  }
  return rows;
}

// ---- Progress and summary --------------------------------------------------------------------

/// A progress bar on standard error if that is a terminal without rows, drawn ten times a second.
struct Progress {
  explicit Progress(bool hasRows) : isShown(isatty(STDERR_FILENO) == 1 && !hasRows) {}
  ~Progress() {
    if (isShown) std::fputs("\r\033[K", stderr);
  }
  void show(double t, double end) {
    const auto now = std::chrono::steady_clock::now();
    if (!isShown || now < next) return;
    next = now + std::chrono::milliseconds(100);
    std::string bar(40, '.');
    std::fill_n(bar.begin(), static_cast<int>(40 * t / end), '#');
    std::fprintf(stderr, "\r[%s] %g of %g s\033[K", bar.c_str(), t, end);
  }

  const bool isShown;
  std::chrono::steady_clock::time_point next{};
};

/// Angles or positions, and rates of the first twenty joints.
void writeState(std::FILE* out, const Simulation& simulation) {
  const std::vector<Joint>& joints = simulation.scene().chain.joints();
  const std::size_t most = std::min<std::size_t>(joints.size(), 20);
  std::size_t width = 0;
  for (std::size_t i = 0; i < most; ++i) width = std::max(width, joints[i].name.size());
  for (std::size_t i = 0; i < most; ++i) {
    const char* unit = joints[i].isPrismatic ? "m" : "rad";
    std::fprintf(out, "  %-*s  q = %12.6g %s  qd = %12.6g %s/s\n", static_cast<int>(width),
                 joints[i].name.c_str(), simulation.q()[i], unit, simulation.qd()[i], unit);
  }
  if (joints.size() > most) std::fprintf(out, "  and %zu more\n", joints.size() - most);
}

/// end: of the run, s. The scene's own time is less after a reset, or after states that were shown as ticks.
void writeSummary(std::FILE* out, const Simulation& simulation, double end) {
  const Statistics statistics = simulation.statistics();
  const Energy energy = simulation.energy();
  const bool chose = simulation.scene().integrator.method == "auto";
  std::fprintf(out, "t = %g s%s by %s%s%s: %lld steps, %lld rejected, %lld evaluations (%s)\n",
               simulation.time(), simulation.time() < end ? " of scene time" : "", chose ? "auto (" : "",
               simulation.method().c_str(), chose ? " at the end)" : "", statistics.steps,
               statistics.rejected, statistics.evaluations, simulation.recursion().c_str());
  if (statistics.rescues > 0) {
    std::fprintf(
        out,
        "  the energy guard repeated steps %lld time%s, smaller or by rodas5p, because the energy balance "
        "did not "
        "close or a step was impossible; this restores the energy, not the accuracy lost before\n",
        statistics.rescues, statistics.rescues == 1 ? "" : "s");
  }
  writeState(out, simulation);
  std::fprintf(out, "  energy = %.6g J (kinetic %.6g, potential %.6g)\n", energy.total(), energy.kinetic,
               energy.potential);
}

// ---- The files -------------------------------------------------------------------------------

/// File name of the library for bags. Empty in a build without ROS.
constexpr const char* bagsLibrary = PLANAR_CHAIN_BAGS;

/// Loads the library, which only runs with bags need.
/// @throws std::runtime_error if it cannot be loaded
OpenBags* loadBags() {
  void* const library = dlopen(bagsLibrary, RTLD_NOW);
  void* const function = library ? dlsym(library, "openBags") : nullptr;
  if (!function) throw std::runtime_error(dlerror());
  return reinterpret_cast<OpenBags*>(function);
}

/// Records a fault for each output file that cannot be written or is another file of the run.
void checkFiles(const Arguments& given, std::vector<Fault>& faults) {
  if (wantsBags(given) && *bagsLibrary == 0) {
    faults.push_back(
        {"--bag, --commands, --write-urdf", "a build with ROS", "one without (PLANAR_CHAIN_ROS=OFF)"});
  }
  if (given.has("node") && !wantsBags(given)) {
    faults.push_back({"--node", "--bag, --commands or --write-urdf, whose node it names", "none of them"});
  }
  if (given.has("until") && wantsBags(given)) {
    faults.push_back({"--until", "neither --bag, --commands nor --write-urdf beside it", "one of them"});
  }
  if (given.has("views") && !given.has("bag")) {
    faults.push_back({"--views", "--bag, which they are written to", "none"});
  }
  for (const char* option : {"bag", "write-urdf"}) {
    if (given.text(option) != "-") continue;
    faults.push_back({std::string("--") + option, "a file, as only --csv goes to standard output", "-"});
  }
  std::vector<std::string> inputs;
  for (const char* option : {"urdf", "commands"}) inputs.push_back(given.text(option).value_or(""));
  try {
    inputs.push_back(scenePath(given));
  } catch (const Refused&) {  // readScene() says so
  }
  checkOutputs(given, {"csv", "bag", "write-urdf"}, inputs, faults);
}

// ---- Signals ---------------------------------------------------------------------------------

volatile std::sig_atomic_t caught = 0;  ///< the signal that ends the run
std::chrono::steady_clock::time_point caughtAt;

/// Lets Ctrl-C, kill and the end of the terminal end the run so that its files are complete. A later signal
/// ends the program at once. Signals close together are one: `timeout` sends two.
void catchSignals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const auto before = std::signal(signal, [](int which) {
      constexpr std::chrono::milliseconds together{200};
      const auto now = std::chrono::steady_clock::now();
      if (caught == 0) {
        caughtAt = now;
        caught = which;
      } else if (now - caughtAt > together) {
        std::signal(which, SIG_DFL);
        std::raise(which);
      }
    });
    if (before == SIG_IGN) std::signal(signal, SIG_IGN);  // as in a shell's background
  }
}

// ---- The run ---------------------------------------------------------------------------------

/// Puts an argument in its place in the scene's tree, so that one reader checks both.
void override(Value& scene, const char* section, const char* key, const std::optional<std::string>& given) {
  if (!given || !scene.map()) return;
  Value& settings = scene.map()->try_emplace(section, Value::Map()).first->second;
  if (settings.map()) (*settings.map())[key] = *given;
}

/// The number of --most-steps.
std::optional<long long> stepsOf(const Arguments& given, std::vector<Fault>& faults) {
  if (!given.has("most-steps")) return std::nullopt;
  constexpr double most = 1e15;  // whole numbers up to it are exact, and take centuries
  const double steps = given.number("most-steps", "a number > 0", 0, 1, faults);
  if (steps > most) faults.push_back({"--most-steps", "at most 1e15", toText(steps)});
  return static_cast<long long>(std::ceil(std::min(steps, most)));
}

/// Reads the scene. All faults of the arguments and the scene are reported together.
Scene sceneOf(const Arguments& given, bool hasBags) {
  std::vector<Fault> faults;
  const double duration = given.number("duration", "a finite number > 0 s", 0, 1, faults);
  stepsOf(given, faults);
  untilOf(given, faults);
  const double rate = given.number("rate", "a finite number > 0 rows a second", 0, 100, faults);
  rowsOf(duration, rate, faults);
  if (!given.has("duration") && !given.has("commands") && !given.has("check")) {
    faults.push_back(
        {"--duration", "a finite number > 0 s, or --commands with a bag that has the states", "neither"});
  }
  checkFiles(given, faults);
  checkAlone(
      given, "check",
      {"duration", "until", "rate", "csv", "bag", "views", "commands", "write-urdf", "node", "most-steps"},
      faults);
  const auto amend = [&](Value& value) {
    for (const char* key : {"method", "tolerance", "step"})
      override(value, "integrator", key, given.text(key));
    if (hasBags) override(value, "publish", "rate", given.text("rate"));
    if (given.has("settle") && value.map()) (*value.map())["start"] = std::string("rest");
  };
  return readScene(given, amend, std::move(faults));
}

/// With a bag, rows are the node's ticks: steps end where the node's do, so the motion is equal to the last
/// digit.
Rows rowsOf(const Arguments& given, const Scene& scene, bool hasBags) {
  std::vector<Fault> faults;
  const double duration = given.number("duration", "a finite number > 0 s", 0, 1, faults);
  const double rate = given.number("rate", "a finite number > 0 rows a second", 0, 100, faults);
  const Rows rows = rowsOf(duration, hasBags ? scene.publish.rate : rate, faults);
  if (hasBags && duration > longestRun) {
    faults.push_back({"--duration", "at most 4294967295 s with a bag", toText(duration)});
  }
  if (given.has("bag") && given.has("duration") && !rows.isTick(1)) {
    const std::string tick = toText(1 / scene.publish.rate);
    faults.push_back(
        {"--duration", "at least a tick of " + tick + " s, the first with messages", toText(duration)});
  }
  if (!faults.empty()) throw Refused(std::move(faults));
  return rows;
}

/// An option that the method does not use is named.
void tellUnused(const Arguments& given, const std::string& method) {
  const bool isFixed = ode::hasFixedStep(method);
  if (!given.has(isFixed ? "tolerance" : "step")) return;
  std::fprintf(stderr, "simulate: %s %s\n", method.c_str(),
               isFixed ? "takes equal steps; --tolerance only applies to adaptive methods"
                       : "chooses its steps; --step only applies to fixed-step methods");
}

/// Runs row by row, or to the event: the last row is there then. Returns false if the run failed or was
/// interrupted; k: the rows that were made.
bool runRows(Simulation& simulation, Bags* bags, Rows& rows, const std::vector<MotionEvent>& events,
             const StepBudget& budget, Csv& csv, double& k) {
  Progress progress(csv.isOnTerminal());
  const auto keepGoing = [&] {
    progress.show(simulation.time(), rows.duration);
    return caught == 0 && budget.isLeft();
  };
  bool isGood = true;
  FoundEvents found;
  const auto advance = [&](long long row, double t) {
    if (bags) return bags->advanceTo(row, t, keepGoing);
    return events.empty() ? simulation.advanceTo(t, keepGoing)
                          : simulation.advanceTo(t, events, found, keepGoing);
  };
  for (k = 0; isGood && keepGoing() && k <= rows.last; ++k) {
    const auto row = static_cast<long long>(k);
    isGood = advance(row, rows.time(k));
    if (found.terminal) {
      rows.last = k;
      rows.duration = simulation.time();
    }
    if (!isGood && simulation.fault().empty()) break;  // interrupted
    if (bags && rows.isTick(k)) bags->tick(row);
    if (isGood) csv.write(rows.time(k), simulation);
  }
  csv.close();
  if (bags) bags->close();
  if (isGood && k > rows.last && !events.empty() && !found.terminal)
    std::fprintf(stderr, "note: the joint of --until did not pass its angle\n");
  return isGood;
}

int simulate(const Arguments& given) {
  const bool hasBags = wantsBags(given);
  const Scene scene = sceneOf(given, hasBags);
  if (given.has("check")) {
    const int links = scene.chain.size();
    const std::size_t loads = scene.loads.size();
    std::printf("no faults: %d link%s, %zu load%s, method %s\n", links, links == 1 ? "" : "s", loads,
                loads == 1 ? "" : "s", scene.integrator.method.c_str());
    return done;
  }
  Rows rows = rowsOf(given, scene, hasBags);
  std::vector<Fault> none;
  std::vector<MotionEvent> events;
  if (const std::optional<Until> until = untilOf(given, none)) events.push_back(eventOf(*until, scene.chain));
  tellUnused(given, scene.integrator.method);

  // The simulation, with or without bags, and the run.
  std::unique_ptr<Bags> bags;
  std::optional<Simulation> alone;
  if (hasBags) {
    bags.reset(loadBags()(scene, {given.text("bag"), given.has("views"), given.text("commands"),
                                  !given.has("duration"), given.text("write-urdf"), given.text("node")}));
  }
  if (!given.has("duration")) rows = Rows(bags->recordedEnd(), scene.publish.rate);
  Simulation& simulation = bags ? bags->simulation() : alone.emplace(scene);
  Csv csv(given.text("csv"), scene.chain);
  catchSignals();
  const StepBudget budget(simulation, rows.duration, stepsOf(given, none));
  double k = 0;
  const bool isGood = runRows(simulation, bags.get(), rows, events, budget, csv, k);

  // The result.
  if (caught == 0 && !budget.isLeft() && simulation.fault().empty() && k <= rows.last) {
    const bool areForRows = k > static_cast<double>(simulation.statistics().steps) / 2;
    std::fprintf(stderr, "simulate: %s (--most-steps)%s\nThe last state:\n", budget.reason().c_str(),
                 areForRows ? "; each row takes a step (--rate)" : "");
    writeState(stderr, simulation);
    return runFailed;
  }
  if (isGood ? k <= rows.last : simulation.fault().empty()) {
    std::fprintf(stderr, "simulate: interrupted; the last row is at t = %s s, of %g s\n",
                 toText(rows.time(std::max(0.0, k - 1))).c_str(), rows.duration);
    return 128 + caught;
  }
  if (!isGood) {
    std::fprintf(stderr, "simulate: the run failed at t = %.17g s: %s\nThe last finite state:\n",
                 simulation.time(), simulation.fault().c_str());
    writeState(stderr, simulation);
    return runFailed;
  }
  std::FILE* const out = given.text("csv") == "-" ? stderr : stdout;
  writeSummary(out, simulation, rows.duration);
  if (bags) std::fputs(bags->summary().c_str(), out);
  return !bags || bags->isAsRecorded() ? done : doneInPart;
}

}  // namespace
}  // namespace planar_chain::tools

int main(int argc, char** argv) {
  using namespace planar_chain::tools;
  return run(
      {"simulate",
       "Simulates a scene as fast as possible and writes its motion.",
       "0 done; 1 the run failed; 2 bad arguments or scene; 3 a command of --commands was refused, or the "
       "motion left the recorded one; 130 interrupted by Ctrl-C.",
       true,
       {{"duration",
         "Simulated time, s (default with --commands: to the last state in their bag, on joint_states or "
         "~status)"},
        {"rate", "Rows per second of simulated time (default 100; with a bag: the scene's publish/rate)"},
        {"until", "JOINT = ANGLE (rad, m): ends where the joint first passes it, with a last row there"},
        {"check", "Only reads the scene: prints its faults, or one line", false},
        {"settle", "Starts at rest in the static equilibrium, as start: rest does", false},
        {"method", "Integrator, in place of the scene's"},
        {"tolerance", "Tolerance of adaptive methods, in place of the scene's"},
        {"step", "Step of fixed-step methods, s, in place of the scene's"},
        {"most-steps",
         "Ends the run with status 1 after so many steps, counted every 32 (default: a million for each "
         "second so far, and at "
         "least a million; for methods of fixed step, besides those that --step asks for)"},
        {"csv", "File to write, or - for standard output: t, q and qd of every joint, energy"},
        {"bag", "Bag to write: the messages of the node, and /clock; the first tick is stamped 1/rate"},
        {"views", "Also writes the markers of rviz and base_wrench to the bag", false},
        {"commands", "Bag whose recorded commands are applied again"},
        {"write-urdf", "File to write: the scene as URDF"},
        {"node", "Node whose topics the bags have (default: the only one in the bag, or /planar_chain)"}},
       simulate},
      argc, argv);
}
