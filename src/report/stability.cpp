/// stability: the largest stable step of each method, on chains that get stiffer, heavier, longer.

#include <algorithm>
#include <cstdio>

#include "planar_chain/simulation.h"
#include "report/bench.h"
#include "tools/common.h"

namespace planar_chain::tools {
namespace {

using Row = std::vector<std::string>;

std::string text(const char* format, const std::optional<double>& value) {
  char buffer[64] = "";
  if (value) std::snprintf(buffer, sizeof buffer, format, *value);
  return buffer;
}

void printRow(const Row& row) {
  for (const std::string& cell : row) std::printf("| %s ", cell.c_str());
  std::puts("|");
  std::fflush(stdout);
}

void writeRow(std::ofstream& file, const Row& row) {
  for (std::size_t i = 0; i < row.size(); ++i) file << (i > 0 ? "," : "") << row[i];
  file << '\n' << std::flush;
}

// ---- Stability -------------------------------------------------------------------------------

/// The cells of a method in the CSV file, without errors if quick.
Row csvCells(Bench& bench, const Method& method, const Limit& limit, const std::string& eigenvalue,
             bool quick) {
  constexpr const char* words[] = {"", "grows", "not finite"};
  std::optional<double> errorAtLimit, errorAtMillisecond;
  if (!quick) {
    if (limit.stable) errorAtLimit = bench.errorAfterASecond(method, *limit.stable);
    errorAtMillisecond =
        bench.run(method, 1e-3) == Verdict::stable ? bench.errorAfterASecond(method, 1e-3) : infinity;
  }
  return {text("%.4g", limit.stable),
          text("%.4g", limit.unstable),
          words[static_cast<int>(limit.how)],
          text("%.4g", limit.largerStable),
          text("%.4g", bench.predictedLimit(method)),
          eigenvalue,
          text("%.3g", errorAtLimit),
          text("%.3g", errorAtMillisecond),
          "",
          "",
          ""};
}

std::string limitCell(const Limit& limit, const std::optional<double>& predicted) {
  if (!limit.stable) return "none";
  return (limit.unstable ? "" : "≥ ") + text("%.3g", limit.stable) +
         (limit.largerStable > 1.01 * *limit.stable ? "*" : "") +
         (predicted ? text(" (%.3g)", predicted) : "");
}

/// What `auto` does in two seconds, or in as many of them as some ten million link-evaluations allow.
struct Automatic {
  std::string method;
  long long steps = 0;
  double duration = 0;
};

Automatic runAutomatic(Scene scene, bool quick) {
  constexpr double duration = 2;
  const double mostLinkEvaluations = quick ? 1e6 : 1.2e7;
  scene.integrator.method = "auto";
  scene.integrator.tolerance = 1e-6;
  Simulation simulation(scene);
  double t = 1e-5;
  while (simulation.advanceTo(t) && t < duration &&
         static_cast<double>(simulation.statistics().evaluations) * scene.chain.size() <
             mostLinkEvaluations) {
    t = std::min(duration, 1.5 * t);
  }
  return {simulation.fault().empty() ? simulation.method() : "fails", simulation.statistics().steps,
          simulation.time()};
}

/// Prints a table in GitHub Markdown, and writes the rows of the CSV file.
void printFamily(const Family& family, bool quick, std::ofstream& csv) {
  std::printf("### %s\n\n%s.\n\n", family.name.c_str(), family.story.c_str());
  Row header{family.varied, "largest eigenvalue, 1/s"};
  for (const Method& method : measuredMethods()) header.push_back(method.name);
  header.insert(header.end(), {"auto: mean step", "its method at the end"});
  printRow(header);
  printRow(Row(header.size(), "--:"));

  for (const Case& scene : family.cases) {
    Bench bench(scene);
    const std::string value = text("%.4g", scene.value), links = std::to_string(scene.scene.chain.size());
    const std::string eigenvalue = scene.isNearRest ? text("%.3g", bench.largestEigenvalue()) : "";
    const auto write = [&](const std::string& method, Row cells) {
      cells.insert(cells.begin(), {family.name, value, links, method});
      if (csv.is_open()) writeRow(csv, cells);
    };
    Row row{value, eigenvalue};
    for (const Method& method : measuredMethods()) {
      const Limit limit = bench.findLimit(method);
      row.push_back(limitCell(limit, bench.predictedLimit(method)));
      write(method.name, csvCells(bench, method, limit, eigenvalue, quick));
    }
    const Automatic automatic = runAutomatic(scene.scene, quick);
    Row cells(8, "");
    cells.insert(cells.end(),
                 {automatic.method, std::to_string(automatic.steps), text("%.4g", automatic.duration)});
    write("auto", cells);
    row.push_back(text("%.2g", automatic.duration / static_cast<double>(std::max(1LL, automatic.steps))));
    row.push_back(automatic.method);
    printRow(row);
  }
  std::puts("");
}

// ---- The run ---------------------------------------------------------------------------------

constexpr const char* explanation =
    R"(The largest stable step, s, of each method with equal steps, in brackets the limit by theory, and what auto does.

A step is *stable* if a run stays finite and the energy of motion (T + V, less V at rest) never exceeds 1.1 times its
value at the start. Stable is not accurate: --csv has the errors. Every smaller step that was tried is stable, too.
`none`: every step blows up, down to 1e-9 s (a whip: 1e-4 s). `≥`: none blows up. `*`: larger ones passed, but not all.
By theory: |R(h λ)| ≤ 1 for every eigenvalue λ of the chain at rest. auto runs at tolerance 1e-6, for 2 s or less.
)";

int stability(int argc, char** argv) {
  CLI::App app("Measures how far each method goes with equal steps; prints Markdown.", "stability");
  std::optional<std::string> csvPath;
  bool quick = false;
  app.add_option("--csv", csvPath, "File to write: every number, one scene and method a row");
  app.add_flag("--quick", quick, "Some seconds: fewer and shorter chains, no errors");
  app.footer("Exit status: 0 done; 1 the run failed; 2 bad arguments.");
  if (const auto status = parseArguments(app, argc, argv)) return *status;

  std::ofstream csv;
  if (csvPath) {
    csv.open(*csvPath);
    if (!csv) {
      const std::string why = std::strerror(errno);
      throw Refused({{"--csv", "a file that can be written", describe(Value(*csvPath)) + ": " + why}});
    }
    writeRow(csv, {"family", "value", "links", "method", "largest_stable_s", "unstable_s", "how",
                   "largest_of_all_s", "predicted_s", "largest_eigenvalue", "error_at_largest_rad",
                   "error_at_1ms_rad", "auto_method", "auto_steps", "auto_duration_s"});
  }
  std::puts(explanation);
  for (const Family& family : stabilityFamilies(quick)) {
    printFamily(family, quick, csv);
    if (!csv) throw std::runtime_error("cannot write " + *csvPath + ": " + std::strerror(errno));
  }
  return done;
}

}  // namespace
}  // namespace planar_chain::tools

int main(int argc, char** argv) {
  namespace tools = planar_chain::tools;
  return tools::run("stability", [&] { return tools::stability(argc, argv); });
}
