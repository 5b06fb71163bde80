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

#include "ode/explicit_runge_kutta.h"
#include "planar_chain/linear_model.h"
#include "planar_chain/simulation.h"
#include "report/own_methods.h"
#include "tools/common.h"

namespace planar_chain::tools {
namespace {

constexpr double mostEnergy = 1.1;   // of that at the start
constexpr double largestTried = 1;   // s
constexpr double resolution = 1.03;  // of a limit found by bisection
constexpr int mostDense = 100;       // links for which eigenvalues are found

// ---- The chains: each family varies one number -----------------------------------------------

/// A chain, undriven, which would hang straight down at rest.
struct Case {
  std::string family;
  double value;  ///< of what the family varies
  Scene scene;
  double horizon;   ///< s that a run lasts at least
  double smallest;  ///< step that is tried, s
  /// The motion stays close to rest, so that the eigenvalues there say what explicit methods need.
  bool isNearRest;
};

/// Ten links with springs and dampers, bent as a moment of about 1 N m would, if that is little.
Scene springyBar(double k, double d) {
  return uniformChain(10, 0.02 * std::min(1.0, 10 / k), k, d);
}

/// Without gravity about the ground pin: only tension holds it straight.
Scene spinning(double rate) {
  Scene scene = uniformChain(10, 0.02);
  scene.chain = Chain(scene.chain.links(), scene.chain.joints(), {});
  scene.qd[0] = rate;
  return scene;
}

/// quick: few and short chains.
std::vector<Case> stabilityCases(bool quick) {
  using Numbers = std::vector<double>;
  const Numbers stiffnesses =
      quick ? Numbers{1, 1e3, 1e6, 1e9} : Numbers{1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
  const Numbers ratios = quick ? Numbers{1, 1e4, 1e8} : Numbers{1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8};
  const Numbers lengths = quick ? Numbers{10, 50} : Numbers{1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 10000};
  const Numbers whips = quick ? Numbers{10} : Numbers{10, 20, 50, 100};
  const Numbers spins = quick ? Numbers{1, 100} : Numbers{1, 10, 100, 1e3, 1e4};

  std::vector<Case> cases;
  const auto add = [&](const std::string& family, const Numbers& values, auto makeScene) {
    const bool isWhip = family == "whip";
    for (const double value : values) {
      cases.push_back({family, value, makeScene(value), isWhip ? 2.0 : 0.0, isWhip ? 1e-4 : 1e-9,
                       !isWhip && family != "spin"});
    }
  };
  add("stiff", stiffnesses, [](double k) { return springyBar(k, 0); });
  add("stiff_damped", stiffnesses, [](double k) { return springyBar(k, 1e-3 * k); });
  add("heavy_tip", ratios, [](double ratio) { return uniformChain(20, 0, 0, 0, ratio); });
  add("long", lengths, [](double n) { return uniformChain(static_cast<int>(n), 0.02); });
  add("whip", whips,
      [](double n) { return uniformChain(static_cast<int>(n), 0, 0, 0, 1, pi / 2); });  // let go level
  add("spin", spins, spinning);
  return cases;
}

// ---- By theory -------------------------------------------------------------------------------

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

/// Of J at rest; none for motions far from rest and for long chains.
Eigen::VectorXcd eigenvaluesAtRest(const Case& given) {
  const int n = given.scene.chain.size();
  if (!given.isNearRest || n > mostDense) return {};
  const Eigen::VectorXd q = -pi / 2 * Eigen::VectorXd::Unit(n, 0);
  return linearModel(given.scene, 0, q, Eigen::VectorXd::Zero(n)).A.eigenvalues();
}

/// The largest h with |R(h λ)| ≤ 1, for it and all smaller ones and every eigenvalue λ. R is the polynomial
/// of an explicit method; 0 for other methods. largest: |λ|.
double predictedLimit(const std::string& method, const Eigen::VectorXcd& eigenvalues, double largest) {
  constexpr double fine = 1.002;
  constexpr double rounding = 1e-5;  // of R: an undamped mode's eigenvalue has a small real part
  for (const ode::Tableau* table : {&ode::rk4(), &ode::dopri5(), &ode::dop853()}) {
    if (method != table->name || largest == 0) continue;
    // The rounding of fast modes hides the slow ones, which do not limit the step.
    const auto grows = [&](double h, std::complex<double> lambda) {
      return std::abs(lambda) > 1e-3 * largest && std::abs(amplification(*table, h * lambda)) > 1 + rounding;
    };
    double h = 0.3 / largest;
    while (!eigenvalues.unaryExpr([&](auto lambda) { return grows(h, lambda); }).any()) h *= fine;
    return h / fine;
  }
  return 0;
}

// ---- By runs ---------------------------------------------------------------------------------

/// How a run fails; empty if it is stable.
std::string failureOf(const Case& given, const std::string& method, double h) {
  constexpr int stepsPerCheck = 10;
  const double fewest = std::clamp(2e5 / given.scene.chain.size(), 100.0, 2000.0);
  const double end = h * static_cast<int>(std::max(fewest, std::ceil(given.horizon / h)));
  OwnRun run(given.scene, end, equalSteps(method, h));
  const double energyAtStart = run.energyOfMotion();
  for (;;) {
    const Progress progress = run.steps(stepsPerCheck);
    const double energy = run.energyOfMotion();
    if (progress == Progress::diverged || !std::isfinite(energy)) return "not finite";
    if (!(energy <= mostEnergy * energyAtStart)) return "grows";
    if (progress != Progress::underway) return progress == Progress::arrived ? "" : "not finite";
  }
}

struct Limit {
  double stable = 0;    ///< the largest step such that it and all smaller ones tried are stable; 0: none
  double unstable = 0;  ///< the next larger one tried; 0: none
  std::string how;      ///< that one fails
};

/// Tries 1, 0.5, 0.2, 0.1 … s, down to a decade of stable steps and at least to 1 ms; then bisects to 3 %.
Limit findLimit(const Case& given, const std::string& method) {
  Limit limit;
  const auto isStable = [&](double h) {
    const std::string failure = failureOf(given, method, h);
    if (failure.empty()) return true;
    limit.unstable = h;
    limit.how = failure;
    return false;
  };
  constexpr double parts[] = {1, 0.5, 0.2};
  for (int k = 0;; ++k) {
    const double h = largestTried * parts[k % 3] * std::pow(10.0, -(k / 3));
    if (h < std::min(0.099 * limit.stable, 0.99e-3) || h < 0.99 * given.smallest) break;
    limit.stable = isStable(h) ? std::max(limit.stable, h) : 0;
  }
  while (limit.stable > 0 && limit.unstable > resolution * limit.stable) {
    const double h = std::sqrt(limit.stable * limit.unstable);
    if (isStable(h)) limit.stable = h;
  }
  return limit;
}

// ---- The table -------------------------------------------------------------------------------

/// Empty for 0.
std::string text(double value) {
  char buffer[32] = "";
  if (value != 0) std::snprintf(buffer, sizeof buffer, "%.4g", value);
  return buffer;
}

/// Runs `auto` for two seconds, or as long as some ten million link-evaluations allow. Returns its method at
/// the end and its mean step.
std::string automatic(Scene scene, bool quick) {
  constexpr double duration = 2;
  const double most = quick ? 1e6 : 1.2e7;  // link-evaluations
  scene.integrator = {"auto", 1e-6, 0};
  Simulation simulation(scene);
  simulation.advanceTo(duration, [&] {
    return static_cast<double>(simulation.statistics().evaluations) * scene.chain.size() < most;
  });
  const long long steps = std::max(1LL, simulation.statistics().steps);
  return (simulation.fault().empty() ? simulation.method() : "fails") + "," +
         text(simulation.time() / static_cast<double>(steps));
}

int stability(const Arguments& given) {
  const bool quick = given.has("quick");
  const std::optional<std::string> path = given.file("csv");
  const std::string name = path.value_or("standard output");
  if (path) {
    std::vector<Fault> faults;
    checkOutputs(given, {"csv"}, {}, faults);
    if (!faults.empty() || !std::freopen(path->c_str(), "w", stdout)) throw Refused(faults);
  }
  std::cout << "family,value,links,method,largest_stable_s,unstable_s,how,predicted_s,largest_eigenvalue,"
               "auto_method,auto_mean_step_s\n";
  for (const Case& each : stabilityCases(quick)) {
    const Eigen::VectorXcd eigenvalues = eigenvaluesAtRest(each);
    const double largest = eigenvalues.size() > 0 ? eigenvalues.cwiseAbs().maxCoeff() : 0;
    const std::string chain =
        each.family + "," + text(each.value) + "," + std::to_string(each.scene.chain.size()) + ",";
    for (const std::string& method : steppedMethods()) {
      const Limit limit = findLimit(each, method);
      std::cout << chain << method << ',' << text(limit.stable) << ',' << text(limit.unstable) << ','
                << limit.how << ',' << text(predictedLimit(method, eigenvalues, largest)) << ','
                << text(largest) << ",,\n";
      finishOutput(name);
    }
    std::cout << chain << "auto,,,,,," << automatic(each.scene, quick) << '\n';
    finishOutput(name);
  }
  return done;
}

}  // namespace
}  // namespace planar_chain::tools

int main(int argc, char** argv) {
  using namespace planar_chain::tools;
  return run({"stability",
              "Measures how far each method goes with equal steps; prints CSV.",
              "0 done; 1 the run failed; 2 bad arguments.",
              false,
              {{"csv", "File to write in place of standard output, which is -"},
               {"quick", "Some seconds: fewer and shorter chains", false}},
              stability},
             argc, argv);
}
