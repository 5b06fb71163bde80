/// stability: how far each method goes with equal steps, on chains that get stiffer, heavier, longer.

#include <algorithm>
#include <cstdio>

#include "planar_chain/simulation.h"
#include "report/stability_measure.h"
#include "tools/common.h"

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

/// GitHub Markdown.
void printTable(const Row& header, const std::vector<Row>& rows) {
  const auto print = [](const Row& row) {
    for (const std::string& cell : row) std::printf("| %s ", cell.c_str());
    std::puts("|");
  };
  print(header);
  for (std::size_t i = 0; i < header.size(); ++i) std::fputs("|--:", stdout);
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
         "predicted_s", "largest_eigenvalue", "error_at_largest_rad", "error_at_1ms_rad", "auto_method",
         "auto_steps", "auto_duration_s"});
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

std::string errorCell(const Method& method, const Measured& measured) {
  const bool iterates = !method.table && !method.rosenbrock && !method.isSeries;
  const char* failure = iterates ? "no stages" : "blows up";
  const auto word = [&](const std::optional<double>& error, const char* unknown) -> std::string {
    if (!error) return unknown;
    return std::isfinite(*error) ? text("%.0e", *error) : failure;
  };
  return word(measured.errorAtLimit, "–") + "; " +
         (measured.isStableAtMillisecond ? word(measured.errorAtMillisecond, "stable") : failure);
}

/// What `auto` does in two seconds, or in as many of them as some ten million link-evaluations allow.
struct Automatic {
  std::string method;
  long long steps = 0;
  double duration = 0;
  double meanStep() const { return duration / static_cast<double>(std::max(1LL, steps)); }
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
  if (!simulation.fault().empty()) return {"fails", simulation.statistics().steps, simulation.time()};
  return {simulation.method(), simulation.statistics().steps, simulation.time()};
}

void printFamily(const Family& family, bool quick, std::optional<Csv>& csv) {
  std::printf("### %s\n\n%s.\n\n", family.name.c_str(), family.story.c_str());
  Row header{family.varied, "largest eigenvalue, 1/s"}, errorHeader{family.varied};
  for (const Method& method : measuredMethods()) {
    header.push_back(method.name);
    errorHeader.push_back(method.name);
  }
  header.push_back("auto: mean step");
  header.push_back("its method at the end");

  std::vector<Row> limits, errors;
  for (const Case& scene : family.cases) {
    Bench bench(scene);
    const std::string value = text("%.4g", scene.value);
    const std::string eigenvalue = scene.isNearRest ? text("%.3g", bench.largestFrequency()) : "–";
    Row limitRow{value, eigenvalue}, errorRow{value};
    const std::string links = std::to_string(scene.scene.chain.size());
    for (const Method& method : measuredMethods()) {
      const Measured m = measure(bench, method, !quick);
      limitRow.push_back(limitCell(m));
      errorRow.push_back(errorCell(method, m));
      if (csv) {
        csv->row({family.name, value, links, method.name, text("%.4g", m.limit.stable),
                  text("%.4g", m.limit.unstable), wordFor(m.limit.how), text("%.4g", m.limit.largerStable),
                  text("%.4g", m.predicted), eigenvalue == "–" ? "" : eigenvalue,
                  text("%.3g", m.errorAtLimit),
                  quick || m.isStableAtMillisecond ? text("%.3g", m.errorAtMillisecond) : "inf", "", "", ""});
      }
    }
    const Automatic automatic = runAutomatic(scene.scene, quick);
    limitRow.push_back(text("%.2g", automatic.meanStep()));
    limitRow.push_back(automatic.method);
    if (csv) {
      csv->row({family.name, value, links, "auto", "", "", "", "", "", "", "", "", automatic.method,
                std::to_string(automatic.steps), text("%.4g", automatic.duration)});
    }
    limits.push_back(limitRow);
    errors.push_back(errorRow);
  }
  std::puts("Largest stable step, s (in brackets: by theory), and what auto does:\n");
  printTable(header, limits);
  if (quick) return;
  std::puts("Error after 1 s, rad: at that step; with steps of 1 ms.\n");
  printTable(errorHeader, errors);
}

// ---- Cost ------------------------------------------------------------------------------------

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
  printTable(header, rows);
}

// ---- The run ---------------------------------------------------------------------------------

constexpr const char* explanation =
    R"(Equal steps are *stable* if a run stays finite and the energy of motion (T + V, less V at rest) never exceeds
1.1 times what it was at the start. Nothing drives these chains, so in truth it never grows. A method that takes
energy away is stable too: stable is not accurate. A run takes 200,000 link-steps, but at least 100 and at most 2000
steps (a whip: also 2 s at least).

Given is the largest step that is stable, as every smaller one that was tried. Tried are 1, 0.5, 0.2, 0.1 … s, down to
a decade of stable ones and at least to 1 ms, and then between the last two to 3 %. `none`: every step down to the
smallest tried blows up (1e-9 s; a whip: 1e-4 s). `≥`: none blows up. `*`: larger ones passed as well, but not all.
In brackets, for explicit methods: where |R(h λ)| passes 1 for an eigenvalue λ of the chain at rest; for rk4 undamped
that is 2.83/|λ|. dopri5 grows so slowly just beyond (by 1e-5 a step) that a run does not see it.
taylor is here of order 20, that of tolerance 2e-5. radau13 never grows; it ends (`no stages`) where its iteration, with
one Jacobian a step, no longer solves the equations of the stages. With error control, as it is offered, such a step is
made again, shorter.

Errors are the largest of an angle after 1 s, against auto at tolerance 1e-10; `–`: none at hand. A second may be longer
than a run: what is barely stable may blow up yet. Above 1 rad light links whirl in another way, and the energy hardly
knows them. auto runs in Simulation at tolerance 1e-6, for 2 s or as much of it as 12 million link-evaluations allow
(--quick: 1 million).
)";

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
  std::puts(explanation);
  for (const Family& family : stabilityFamilies(quick)) printFamily(family, quick, csv);
  printCost(quick);
  return done;
}

}  // namespace
}  // namespace planar_chain::tools

int main(int argc, char** argv) {
  namespace tools = planar_chain::tools;
  return tools::run("stability", [&] { return tools::stability(argc, argv); });
}
