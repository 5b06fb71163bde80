/// stability: the largest stable step of each method with equal steps, measured and by theory, on chains that
/// get stiffer, heavier, longer.
///
/// Steps of h are stable on a scene if a run stays finite and the energy of motion, T + V less the V of
/// hanging straight down, never exceeds 1.1 times its value at the start. No load acts, so the true energy
/// never grows. A method that takes energy away is stable, but not accurate. A run takes 200,000 link-steps,
/// but from 100 to 2000 steps, and lasts at least the scene's horizon.

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <utility>

#include "ode/local_stiffness.h"
#include "planar_chain/energy.h"
#include "planar_chain/linear_model.h"
#include "planar_chain/simulation.h"
#include "report/families.h"
#include "report/own.h"
#include "tools/common.h"

namespace planar_chain::tools {
namespace {

constexpr double mostEnergy = 1.1;           // of that at the start
constexpr double largestTried = 1;           // s
constexpr double resolution = 1.03;          // of a limit found by bisection
constexpr int mostDense = 100;               // links for which all eigenvalues are found
constexpr double mostLinkEvaluations = 4e7;  // for a reference: some two seconds
constexpr double mostLinkSteps = 2e7;        // for an error

/// R(z): what one step of h makes of y = 1 for ẏ = λ y, z = h λ.
std::complex<double> amplification(const ode::Tableau& table, std::complex<double> z) {
  std::vector<std::complex<double>> k;
  std::complex<double> result = 1;
  for (std::size_t i = 0; i < table.b.size(); ++i) {
    std::complex<double> stage = 1;
    for (std::size_t j = 0; j < table.a[i].size(); ++j) stage += z * table.a[i][j] * k[j];
    k.push_back(stage);
    result += z * table.b[i] * stage;
  }
  return result;
}

double energyAt(const Scene& scene, const Eigen::VectorXd& motion) {
  return energyOf(scene.chain, motion.data(), motion.data() + scene.chain.size()).total();
}

/// θ and ω, straight down.
Eigen::VectorXd atRest(int n) {
  Eigen::VectorXd rest = Eigen::VectorXd::Zero(2 * n);
  rest.head(n).setConstant(-pi / 2);
  return rest;
}

/// Of J at rest: for long chains the largest alone.
std::vector<std::complex<double>> eigenvaluesAtRest(const Scene& scene) {
  const int n = scene.chain.size();
  if (n > mostDense) {
    // Power iteration, until it settles.
    Dynamics dynamics(scene);
    dynamics.enter(0);
    ode::LocalStiffness stiffness(dynamics);
    Eigen::VectorXd rest = Eigen::VectorXd::Zero(dynamics.size());
    rest.head(2 * n) = atRest(n);
    const ode::State state(dynamics, rest);
    double last = 0;
    for (int looks = 0; looks < 3000; ++looks) {
      stiffness.update(0, state.y);
      if (looks % 100 != 99) continue;
      if (std::abs(stiffness.largestEigenvalue() - last) < 1e-5 * last) break;
      last = stiffness.largestEigenvalue();
    }
    return {{0, stiffness.largestEigenvalue()}};
  }

  const Eigen::VectorXd q = -pi / 2 * Eigen::VectorXd::Unit(n, 0);
  const Eigen::MatrixXd A = linearModel(scene, 0, q, Eigen::VectorXd::Zero(n)).A;
  const Eigen::VectorXcd all = Eigen::EigenSolver<Eigen::MatrixXd>(A, false).eigenvalues();
  // The rounding of fast modes hides the slow ones, which do not limit the step.
  const double slow = 1e-3 * all.cwiseAbs().maxCoeff();
  std::vector<std::complex<double>> fast;
  std::copy_if(all.data(), all.data() + all.size(), std::back_inserter(fast),
               [=](std::complex<double> lambda) { return std::abs(lambda) > slow; });
  return fast;
}

enum class Verdict { stable, grows, notFinite };

struct Limit {
  std::optional<double> stable;    ///< the largest step such that it and all smaller ones tried are stable
  std::optional<double> unstable;  ///< the next larger one tried
  Verdict how = Verdict::stable;   ///< how that one fails
  double largerStable = 0;         ///< the largest of all stable steps
};

/// A case, ready to be run again and again.
class Bench {
 public:
  /// The case must outlive this object.
  Bench(const Case& given) : case_(given), n_(given.scene.chain.size()) {
    Eigen::VectorXd start(2 * n_);
    readStart(given.scene, start.data(), start.data() + n_);
    energyAtRest_ = energyAt(given.scene, atRest(n_));
    energyAtStart_ = energyAt(given.scene, start) - energyAtRest_;
    if (given.isNearRest) eigenvalues_ = eigenvaluesAtRest(given.scene);
  }

  Verdict run(const Method& method, double h) const {
    constexpr int stepsPerCheck = 10;
    const double fewest = std::clamp(2e5 / n_, 100.0, 2000.0);
    const double end = h * static_cast<int>(std::max(fewest, std::ceil(case_.horizon / h)));
    OwnRun run(case_.scene, end, equalSteps(method, h));
    for (;;) {
      const Progress progress = run.steps(stepsPerCheck);
      const double energy = energyAt(case_.scene, run.motion()) - energyAtRest_;
      if (progress == Progress::diverged || !std::isfinite(energy)) return Verdict::notFinite;
      if (!(energy <= mostEnergy * energyAtStart_)) return Verdict::grows;
      if (progress != Progress::underway)
        return progress == Progress::arrived ? Verdict::stable : Verdict::notFinite;
    }
  }

  /// Tries 1, 0.5, 0.2, 0.1 … s, down to a decade of stable steps and at least to 1 ms; then bisects to 3 %.
  Limit findLimit(const Method& method) const {
    Limit limit;
    const auto isStable = [&](double h) {
      const Verdict verdict = run(method, h);
      if (verdict == Verdict::stable) {
        limit.largerStable = std::max(limit.largerStable, h);
      } else {
        limit.unstable = h;
        limit.how = verdict;
      }
      return verdict == Verdict::stable;
    };
    constexpr double parts[] = {1, 0.5, 0.2};
    for (int k = 0;; ++k) {
      const double h = largestTried * parts[k % 3] * std::pow(10.0, -(k / 3));
      const bool wentFarEnough = limit.stable && h < 0.099 * *limit.stable && h < 0.99e-3;
      if (wentFarEnough || h < 0.99 * case_.smallest) break;
      if (!isStable(h)) {
        limit.stable.reset();
      } else if (!limit.stable) {
        limit.stable = h;
      }
    }
    while (limit.stable && limit.unstable && *limit.unstable > resolution * *limit.stable) {
      const double h = std::sqrt(*limit.stable * *limit.unstable);
      if (isStable(h)) limit.stable = h;
    }
    return limit;
  }

  /// The largest h with |R(h λ)| ≤ 1, for it and all smaller ones and every eigenvalue λ of the chain at
  /// rest. R is the polynomial of an explicit method. Nothing for other methods, and far from rest.
  std::optional<double> predictedLimit(const Method& method) const {
    if (!case_.isNearRest || !method.table) return std::nullopt;
    constexpr double fine = 1.002;
    constexpr double rounding = 1e-5;  // of R: an undamped mode's eigenvalue has a small real part
    const auto grows = [&](double h) {
      return std::any_of(eigenvalues_.begin(), eigenvalues_.end(), [&](std::complex<double> lambda) {
        return std::abs(amplification(*method.table, h * lambda)) > 1 + rounding;
      });
    };
    double h = 0.3 / largestEigenvalue();
    while (!grows(h)) h *= fine;
    return h / fine;
  }

  /// |λ| of the chain at rest, 1/s.
  double largestEigenvalue() const {
    double largest = 0;
    for (const auto lambda : eigenvalues_) largest = std::max(largest, std::abs(lambda));
    return largest;
  }

  /// Largest error of an angle after 1 s, rad, against `auto` at tolerance 1e-10. Nothing if either run takes
  /// too long; infinite if the method's run is not finite.
  std::optional<double> errorAfterASecond(const Method& method, double h) {
    if (n_ / h > mostLinkSteps) return std::nullopt;
    if (!std::exchange(referenceTried_, true)) {
      OwnRun run(case_.scene, 1, methodFor("auto", 1e-10));
      Progress progress = Progress::underway;
      while (progress == Progress::underway) {
        progress = run.steps(10);
        // Given up as soon as the speed so far will not bring it there.
        const double spent = static_cast<double>(run.counts().evaluations) * n_ / mostLinkEvaluations;
        if (spent > 0.2 && spent > run.time()) break;
      }
      if (progress == Progress::arrived) reference_ = run.motion();
    }
    if (!reference_) return std::nullopt;
    OwnRun run(case_.scene, 1, equalSteps(method, h));
    if (run.steps(std::numeric_limits<int>::max()) != Progress::arrived) return infinity;
    const double error = (run.motion() - *reference_).head(n_).cwiseAbs().maxCoeff();
    return std::isfinite(error) ? error : infinity;
  }

 private:
  const Case& case_;
  int n_;
  double energyAtRest_, energyAtStart_;
  std::vector<std::complex<double>> eigenvalues_;
  bool referenceTried_ = false;
  std::optional<Eigen::VectorXd> reference_;
};

// ---- Tables ----------------------------------------------------------------------------------

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
  const double most = quick ? 1e6 : 1.2e7;  // link-evaluations
  scene.integrator.method = "auto";
  scene.integrator.tolerance = 1e-6;
  Simulation simulation(scene);
  double t = 1e-5;
  while (simulation.advanceTo(t) && t < duration &&
         static_cast<double>(simulation.statistics().evaluations) * scene.chain.size() < most) {
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
