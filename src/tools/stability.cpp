/// stability: how far each method goes with equal steps, on chains that get stiffer, heavier, longer.

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "common.h"
#include "planar_chain/simulation.h"
#include "stability_measure.h"

namespace planar_chain::tools {
namespace {

using Row = std::vector<std::string>;

std::string text(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

std::string text(const char* format, const std::optional<double>& value) {
  return value ? text(format, *value) : "";
}

/// GitHub Markdown; the first `words` columns are words, the others numbers.
void printTable(const Row& header, const std::vector<Row>& rows, std::size_t words = 1) {
  const auto print = [](const Row& row) {
    for (const std::string& cell : row) std::printf("| %s ", cell.c_str());
    std::puts("|");
  };
  print(header);
  for (std::size_t i = 0; i < header.size(); ++i) std::fputs(i < words ? "|---" : "|--:", stdout);
  std::puts("|");
  for (const Row& row : rows) print(row);
  std::puts("");
  std::fflush(stdout);
}

// ---- The CSV file ----------------------------------------------------------------------------

class Csv {
 public:
  /// @throws Refused when the file cannot be opened
  explicit Csv(const std::string& path) : path_(path), file_(path) {
    if (!file_) {
      throw Refused(
          {{"--csv", "a file that can be written", describe(Value(path)) + ": " + std::strerror(errno)}});
    }
    row({"family", "value", "links", "method", "largest_stable_s", "unstable_s", "how", "largest_of_all_s",
         "predicted_s", "largest_eigenvalue", "error_at_largest_rad", "error_at_1ms_rad", "auto_steps",
         "auto_mean_step_s"});
  }

  /// @throws std::runtime_error when the disk is full or the like
  void row(const Row& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) file_ << (i > 0 ? "," : "") << cells[i];
    file_ << '\n' << std::flush;
    if (!file_) throw std::runtime_error("cannot write " + path_ + ": " + std::strerror(errno));
  }

 private:
  std::string path_;
  std::ofstream file_;
};

// ---- Stability -------------------------------------------------------------------------------

const char* wordFor(Verdict verdict) {
  switch (verdict) {
    case Verdict::stable:
      return "";
    case Verdict::grows:
      return "grows";
    default:
      return "not finite";
  }
}

struct Measured {
  Limit limit;
  std::optional<double> predicted, errorAtLimit, errorAtMillisecond;
  bool isStableAtMillisecond = false;
};

Measured measure(Bench& bench, const Method& method, bool withErrors) {
  Measured result;
  result.limit = bench.findLimit(method);
  result.predicted = bench.predictedLimit(method);
  if (!withErrors) return result;
  result.isStableAtMillisecond = bench.run(method, 1e-3) == Verdict::stable;
  if (result.isStableAtMillisecond) result.errorAtMillisecond = bench.errorAfterASecond(method, 1e-3);
  if (result.limit.stable) result.errorAtLimit = bench.errorAfterASecond(method, *result.limit.stable);
  return result;
}

std::string limitCell(const Measured& measured) {
  const Limit& limit = measured.limit;
  if (!limit.stable) return "none";
  std::string cell = (limit.unstable ? "" : "≥ ") + text("%.3g", *limit.stable);
  if (limit.largerStable > 1.01 * *limit.stable) cell += "*";
  if (measured.predicted) cell += text(" (%.3g)", *measured.predicted);
  return cell;
}

std::string errorCell(const Measured& measured) {
  const std::string atLimit = measured.errorAtLimit ? text("%.0e", *measured.errorAtLimit) : "–";
  if (!measured.isStableAtMillisecond) return atLimit + "; blows up";
  return atLimit + "; " + (measured.errorAtMillisecond ? text("%.0e", *measured.errorAtMillisecond) : "–");
}

/// What `auto` does in two seconds.
struct Automatic {
  std::string method;
  long long steps = 0;
  double meanStep = 0;
  bool isDone = false;
};

Automatic runAutomatic(Scene scene) {
  constexpr double duration = 2;
  constexpr int slices = 200;
  constexpr double mostLinkEvaluations = 1e8;
  scene.integrator.method = "auto";
  scene.integrator.tolerance = 1e-6;
  Simulation simulation(scene);
  bool isGood = true;
  for (int k = 1; isGood && k <= slices; ++k) {
    isGood =
        simulation.advanceTo(duration * k / slices) &&
        static_cast<double>(simulation.statistics().evaluations) * scene.chain.size() < mostLinkEvaluations;
  }
  const long long steps = simulation.statistics().steps;
  return {simulation.method(), steps, simulation.time() / static_cast<double>(std::max(1LL, steps)), isGood};
}

void printFamily(const Family& family, bool withErrors, std::optional<Csv>& csv) {
  std::printf("### %s\n\n%s.\n\n", family.name.c_str(), family.story.c_str());
  Row header{family.varied, "largest eigenvalue, 1/s"}, errorHeader{family.varied};
  for (const Method& method : measuredMethods()) {
    header.push_back(method.name);
    errorHeader.push_back(method.name);
  }
  header.push_back("auto: mean step");
  header.push_back("steps");
  header.push_back("at the end");

  std::vector<Row> limits, errors;
  for (const Case& scene : family.cases) {
    Bench bench(scene);
    const std::string value = text("%.4g", scene.value);
    const std::string eigenvalue = scene.isNearRest ? text("%.3g", bench.largestFrequency()) : "–";
    Row limitRow{value, eigenvalue}, errorRow{value};
    const std::string links = std::to_string(scene.scene.chain.size());
    for (const Method& method : measuredMethods()) {
      const Measured m = measure(bench, method, withErrors);
      limitRow.push_back(limitCell(m));
      errorRow.push_back(errorCell(m));
      if (csv) {
        csv->row(
            {family.name, value, links, method.name, text("%.4g", m.limit.stable),
             text("%.4g", m.limit.unstable), wordFor(m.limit.how), text("%.4g", m.limit.largerStable),
             text("%.4g", m.predicted), eigenvalue == "–" ? "" : eigenvalue, text("%.3g", m.errorAtLimit),
             !withErrors || m.isStableAtMillisecond ? text("%.3g", m.errorAtMillisecond) : "inf", "", ""});
      }
    }
    const Automatic automatic = runAutomatic(scene.scene);
    limitRow.push_back(text("%.2g", automatic.meanStep));
    limitRow.push_back((automatic.isDone ? "" : "> ") + std::to_string(automatic.steps));
    limitRow.push_back(automatic.isDone ? automatic.method : "given up");
    if (csv) {
      csv->row({family.name, value, links, "auto", "", "", "", "", "", "", "", "",
                std::to_string(automatic.steps), text("%.4g", automatic.meanStep)});
    }
    limits.push_back(limitRow);
    errors.push_back(errorRow);
  }
  std::puts("Largest stable step, s (in brackets: by theory), and what auto does:\n");
  printTable(header, limits, 0);
  if (!withErrors) return;
  std::puts("Error after 1 s, rad: at that step; with steps of 1 ms.\n");
  printTable(errorHeader, errors, 0);
}

// ---- Cost ------------------------------------------------------------------------------------

/// Median of what one step takes, s.
double costOf(const Method& method, int n, bool quick) {
  using Clock = std::chrono::steady_clock;
  const Scene scene = hangingChain(n);
  Loads loads(scene, 0);
  Dynamics dynamics(scene.chain, loads);
  loads.enter(0);
  const auto integrator = ode::fixedSteps(makeStepper(method, dynamics), 1e-3 / n);
  ode::State state(dynamics.size());
  double theta = 0;
  for (int i = 0; i < n; ++i) state.y[i] = theta += scene.q[static_cast<std::size_t>(i)];

  const int batch = std::max(1, 2000 / n);
  const int repetitions = std::clamp((quick ? 100'000 : 1'000'000) / (n * batch), 9, 301);
  std::vector<double> times;
  for (int k = 0; k < repetitions; ++k) {
    const auto begin = Clock::now();
    integrator->integrate(state, 1, std::numeric_limits<double>::infinity(), batch);
    times.push_back(std::chrono::duration<double>(Clock::now() - begin).count() / batch);
  }
  std::nth_element(times.begin(), times.begin() + repetitions / 2, times.end());
  return times[static_cast<std::size_t>(repetitions / 2)];
}

void printCost(bool quick) {
  constexpr int base = 100;
  const std::vector<int> lengths = quick
                                       ? std::vector<int>{10, 100, 1000}
                                       : std::vector<int>{10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000};
  Row header{"links"};
  std::vector<double> atBase;
  for (const Method& method : measuredMethods()) {
    header.push_back(std::string(method.name) + ", ns");
    header.push_back("ratio");
    atBase.push_back(costOf(method, base, quick) / base);
  }
  std::vector<Row> rows;
  for (const int n : lengths) {
    Row row{std::to_string(n)};
    for (std::size_t i = 0; i < measuredMethods().size(); ++i) {
      const double cost = costOf(measuredMethods()[i], n, quick) / n;
      row.push_back(text("%.0f", 1e9 * cost));
      row.push_back(text("%.2f", cost / atBase[i]));
    }
    rows.push_back(row);
  }
  std::printf("### Cost\n\nOne step, ns a link, median; and its ratio to that of %d links. Linear is 1.\n\n",
              base);
  printTable(header, rows, 0);
}

// ---- The run ---------------------------------------------------------------------------------

int stability(int argc, char** argv) {
  CLI::App app("Measures how far each method goes with equal steps; prints Markdown.", "stability");
  std::optional<std::string> csvPath;
  bool quick = false;
  app.add_option("--csv", csvPath, "File to write: every number, one scene and method a row");
  app.add_flag("--quick", quick, "Some seconds: fewer and shorter chains, no errors");
  app.footer("Exit status: 0 done; 1 the run failed; 2 bad arguments.");
  if (const auto status = parseArguments(app, argc, argv)) return *status;

  std::optional<Csv> csv;
  if (csvPath) csv.emplace(*csvPath);
  std::printf(
      "Equal steps are *stable* if the run stays finite and the energy of motion (T + V, less V at rest) "
      "never\n"
      "exceeds %g times what it was at the start; nothing drives these chains, so in truth it never grows. A "
      "run\n"
      "takes 400,000 link-steps, at least 200 and at most 2000 steps (a whip: 2 s at least). Given is the "
      "largest\n"
      "step that is stable and below which every one tried was, too; tried are 1, 0.5, 0.2, 0.1 … s down to "
      "a\n"
      "decade of stable ones and at least to 1 ms, then by bisection to 3 %%. \"none\": every step tried "
      "blows up.\n"
      "\"≥\": none tried does. \"*\": a larger step passed as well, but not all between. auto: 2 s by\n"
      "Simulation, tolerance 1e-6. Errors: the largest of an angle, against auto at 1e-11; \"–\": not "
      "known.\n\n",
      mostEnergy);
  for (const Family& family : stabilityFamilies(quick)) printFamily(family, !quick, csv);
  printCost(quick);
  return done;
}

}  // namespace
}  // namespace planar_chain::tools

int main(int argc, char** argv) {
  namespace tools = planar_chain::tools;
  return tools::run("stability", [&] { return tools::stability(argc, argv); });
}
