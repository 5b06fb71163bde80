#include "report/stability_measure.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <utility>

#include "ode/methods.h"
#include "ode/radau.h"
#include "ode/surroundings.h"
#include "ode/taylor.h"
#include "planar_chain/energy.h"

namespace planar_chain::tools {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double toleranceOfSeries = 2e-5;   // for order 20
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

}  // namespace

const std::vector<Method>& measuredMethods() {
  static const std::vector<Method> methods{
      {"rk4", &ode::rk4(), nullptr},           {"dopri5", &ode::dopri5(), nullptr},
      {"dop853", &ode::dop853(), nullptr},     {"rodas5p", nullptr, &ode::rodas5p()},
      {"ros34pw2", nullptr, &ode::ros34pw2()}, {"radau13", nullptr, nullptr},
      {"taylor", nullptr, nullptr, true}};
  return methods;
}

ode::Tolerance toleranceOf(double value, int size) {
  ode::Tolerance tolerance{value, Eigen::ArrayXd::Constant(size, infinity)};
  tolerance.ceiling.head(size / 2) = pi;
  return tolerance;
}

std::unique_ptr<ode::Stepper> makeStepper(const Method& method, ode::SeriesSystem& f, double stagesTo) {
  if (method.table) return std::make_unique<ode::ExplicitRungeKutta>(*method.table, f);
  if (method.rosenbrock) return std::make_unique<ode::Rosenbrock>(*method.rosenbrock, f);
  if (method.isSeries) return std::make_unique<ode::Taylor>(f, toleranceOfSeries);
  return std::make_unique<ode::Radau>(f, toleranceOf(stagesTo, f.size()).arrangedBy(f),
                                      std::make_shared<ode::Surroundings>(f));
}

ode::State startOf(const Scene& scene, const Dynamics& dynamics) {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(dynamics.size());
  readStart(scene, y.data(), y.data() + scene.chain.size());
  return {dynamics, y};
}

int stepsOf(const Case& scene, double h) {
  const double steps = std::clamp(2e5 / scene.scene.chain.size(), 100.0, 2000.0);
  return static_cast<int>(std::max(steps, std::ceil(scene.horizon / h)));
}

Bench::Bench(const Case& given)
    : case_(given),
      n_(given.scene.chain.size()),
      dynamics_(given.scene),
      start_(startOf(given.scene, dynamics_)) {
  energyAtRest_ = energyOfMotion(ode::State(dynamics_, atRest()));
  energyAtStart_ = energyOfMotion(start_);
  dynamics_.enter(0);
}

Eigen::VectorXd Bench::atRest() const {
  Eigen::VectorXd rest = Eigen::VectorXd::Zero(dynamics_.size());
  rest.head(n_).setConstant(-pi / 2);
  return rest;
}

double Bench::energyOfMotion(const ode::State& state) const {
  const Eigen::VectorXd y = state.restoredBy(dynamics_);
  return energyOf(case_.scene.chain, y.data(), y.data() + n_).total() - energyAtRest_;
}

Verdict Bench::run(const Method& method, double h) {
  constexpr int stepsPerCheck = 10;
  const auto integrator = ode::fixedSteps(makeStepper(method, dynamics_), h);
  ode::State state = start_;
  const double end = h * stepsOf(case_, h);
  ode::Outcome outcome = ode::Outcome::underway;
  while (outcome == ode::Outcome::underway) {
    outcome = integrator->integrate(state, end, infinity, stepsPerCheck);
    const double energy = energyOfMotion(state);
    if (outcome == ode::Outcome::notFinite || !std::isfinite(energy)) return Verdict::notFinite;
    if (!(energy <= mostEnergy * energyAtStart_)) return Verdict::grows;
  }
  return outcome == ode::Outcome::arrived ? Verdict::stable : Verdict::notFinite;
}

Limit Bench::findLimit(const Method& method) {
  constexpr double parts[] = {1, 0.5, 0.2};
  Limit limit;
  for (int k = 0;; ++k) {
    const double h = largestTried * parts[k % 3] * std::pow(10.0, -(k / 3));
    const bool wentFarEnough = limit.stable && h < 0.099 * *limit.stable && h < 0.99e-3;
    if (wentFarEnough || h < 0.99 * case_.smallest) break;
    const Verdict verdict = run(method, h);
    if (verdict != Verdict::stable) {
      limit.stable.reset();
      limit.unstable = h;
      limit.how = verdict;
    } else {
      if (!limit.stable) limit.stable = h;
      limit.largerStable = std::max(limit.largerStable, h);
    }
  }
  while (limit.stable && limit.unstable && *limit.unstable > resolution * *limit.stable) {
    const double h = std::sqrt(*limit.stable * *limit.unstable);
    const Verdict verdict = run(method, h);
    (verdict == Verdict::stable ? limit.stable : limit.unstable) = h;
    if (verdict != Verdict::stable) limit.how = verdict;
  }
  if (limit.stable) limit.largerStable = std::max(limit.largerStable, *limit.stable);
  return limit;
}

const std::optional<Eigen::VectorXd>& Bench::reference() {
  if (std::exchange(referenceTried_, true)) return reference_;
  const auto integrator = ode::makeMethod("auto", dynamics_, 0, toleranceOf(1e-10, 2 * n_));
  integrator->begin();
  ode::State state = start_;
  ode::Outcome outcome = ode::Outcome::underway;
  const long long before = dynamics_.evaluations();
  while (outcome == ode::Outcome::underway) {
    outcome = integrator->integrate(state, 1, infinity, 10);
    // Given up as soon as it will not get there, by the speed so far.
    const double spent = static_cast<double>(dynamics_.evaluations() - before) * n_ / mostLinkEvaluations;
    if (spent > 0.2 && spent > state.t) break;
  }
  if (outcome == ode::Outcome::arrived) reference_ = state.restoredBy(dynamics_).head(n_);
  return reference_;
}

std::optional<double> Bench::errorAfterASecond(const Method& method, double h) {
  if (n_ / h > mostLinkSteps || !reference()) return std::nullopt;
  const auto integrator = ode::fixedSteps(makeStepper(method, dynamics_), h);
  ode::State state = start_;
  if (integrator->integrate(state, 1, infinity) != ode::Outcome::arrived) return infinity;
  const double error = (state.restoredBy(dynamics_).head(n_) - *reference()).cwiseAbs().maxCoeff();
  return std::isfinite(error) ? error : infinity;
}

// ---- Theory ----------------------------------------------------------------------------------

void Bench::findEigenvalues() {
  if (!eigenvalues_.empty()) return;
  const Eigen::VectorXd rest = atRest();
  if (n_ > mostDense) {
    ode::Surroundings surroundings(dynamics_);
    const ode::State state(dynamics_, rest);
    double last = 0;
    for (int looks = 0; looks < 3000; ++looks) {
      surroundings.look(0, state.y);
      if (looks % 100 != 99) continue;
      if (std::abs(surroundings.largestEigenvalue() - last) < 1e-5 * last) break;
      last = surroundings.largestEigenvalue();
    }
    eigenvalues_.push_back({0, surroundings.largestEigenvalue()});
    return;
  }

  // J by central differences, a column at a time; works left out, as nothing hangs on them.
  constexpr double size = 1e-6;
  Eigen::MatrixXd J(2 * n_, 2 * n_);
  Eigen::VectorXd up(dynamics_.size()), down(dynamics_.size());
  for (int j = 0; j < 2 * n_; ++j) {
    Eigen::VectorXd moved = rest;
    moved[j] = rest[j] + size;
    dynamics_.derivative(0, moved.data(), up.data());
    moved[j] = rest[j] - size;
    dynamics_.derivative(0, moved.data(), down.data());
    J.col(j) = (up - down).head(2 * n_) / (2 * size);
  }
  const Eigen::VectorXcd eigenvalues = Eigen::EigenSolver<Eigen::MatrixXd>(J, false).eigenvalues();
  // Slow modes drown in the rounding of fast ones, and bind no step.
  const double slow = 1e-3 * eigenvalues.cwiseAbs().maxCoeff();
  for (Eigen::Index k = 0; k < eigenvalues.size(); ++k) {
    if (std::abs(eigenvalues[k]) > slow) eigenvalues_.push_back(eigenvalues[k]);
  }
}

double Bench::largestFrequency() {
  findEigenvalues();
  double largest = 0;
  for (const auto lambda : eigenvalues_) largest = std::max(largest, std::abs(lambda));
  return largest;
}

std::optional<double> Bench::predictedLimit(const Method& method) {
  if (!case_.isNearRest || !method.table) return std::nullopt;
  constexpr double fine = 1.002;
  constexpr double rounding = 1e-5;  // of R, for the eigenvalues are differences
  const double fastest = largestFrequency();
  const auto grows = [&](double h) {
    return std::any_of(eigenvalues_.begin(), eigenvalues_.end(), [&](std::complex<double> lambda) {
      return std::abs(amplification(*method.table, h * lambda)) > 1 + rounding;
    });
  };
  double h = 0.3 / fastest;
  while (!grows(h)) h *= fine;
  return h / fine;
}

// ---- Cost ------------------------------------------------------------------------------------

double threadSeconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double costOf(const Method& method, int n, bool quick) {
  const Scene scene = hangingChain(n);
  Dynamics dynamics(scene);
  dynamics.enter(0);
  const auto integrator = ode::fixedSteps(makeStepper(method, dynamics), 1e-3 / n);
  ode::State state = startOf(scene, dynamics);

  const int batch = std::max(1, 2000 / n);
  const int repetitions = std::clamp((quick ? 100'000 : 1'000'000) / (n * batch), 9, 301);
  const double end = 2e-3 / n * batch * repetitions;
  std::vector<double> times;
  for (int k = 0; k < repetitions; ++k) {
    const double begin = threadSeconds();
    integrator->integrate(state, end, infinity, batch);
    times.push_back((threadSeconds() - begin) / batch);
  }
  return median(times);
}

}  // namespace planar_chain::tools
