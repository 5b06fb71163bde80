#include "report/bench.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "ode/local_stiffness.h"
#include "planar_chain/energy.h"
#include "planar_chain/linear_model.h"

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

}  // namespace

Bench::Bench(const Case& given) : case_(given), n_(given.scene.chain.size()) {
  Eigen::VectorXd start(2 * n_);
  readStart(given.scene, start.data(), start.data() + n_);
  energyAtRest_ = energyAt(given.scene, atRest(n_));
  energyAtStart_ = energyAt(given.scene, start) - energyAtRest_;
  if (given.isNearRest) eigenvalues_ = eigenvaluesAtRest(given.scene);
}

// ---- Measured --------------------------------------------------------------------------------

Verdict Bench::run(const Method& method, double h) const {
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

Limit Bench::findLimit(const Method& method) const {
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

std::optional<double> Bench::errorAfterASecond(const Method& method, double h) {
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

// ---- By theory -------------------------------------------------------------------------------

double Bench::largestEigenvalue() const {
  double largest = 0;
  for (const auto lambda : eigenvalues_) largest = std::max(largest, std::abs(lambda));
  return largest;
}

std::optional<double> Bench::predictedLimit(const Method& method) const {
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

}  // namespace planar_chain::tools
