#pragma once

/// What `stability` measures: the steps that a method bears, and what theory says of it.

#include <Eigen/Core>
#include <complex>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/dynamics.h"
#include "ode/explicit_runge_kutta.h"
#include "ode/integrator.h"
#include "ode/rosenbrock.h"
#include "report/stability_scenes.h"

namespace planar_chain::tools {

struct Method {
  const char* name;
  const ode::Tableau* table;
  const ode::RosenbrockTableau* rosenbrock;
  bool isSeries = false;  ///< taylor, of order 20; none of the three: radau13
};
const std::vector<Method>& measuredMethods();
/// stagesTo: the tolerance to which radau13 solves its stages.
std::unique_ptr<ode::Stepper> makeStepper(const Method& method, ode::SeriesSystem& f, double stagesTo = 1e-6);
/// For size components, the first half of them angles, which count up to half a turn.
ode::Tolerance toleranceOf(double value, int size);
/// Where the scene starts.
ode::State startOf(const Scene& scene, const Dynamics& dynamics);
/// s of this thread on the processor.
double threadSeconds();
/// The upper one of an even number; of one value at least.
double median(std::vector<double> values);
/// Median of what one step on a hanging chain of n links takes, s.
double costOf(const Method& method, int n, bool quick);

/// Equal steps of h are STABLE on a scene if a run of them stays finite and the energy of motion, that is
/// T + V less the V of hanging straight down, never exceeds 1.1 times what it was at the start. (No load
/// acts, so in truth it never grows.) The run takes 200,000 link-steps, but at least 100 and at most 2000
/// steps, and lasts at least the scene's horizon. A method may take energy away: that is an error, not
/// instability.
constexpr double mostEnergy = 1.1;
int stepsOf(const Case& scene, double h);

enum class Verdict { stable, grows, notFinite };

constexpr double largestTried = 1;  // s

struct Limit {
  std::optional<double> stable;    ///< the largest step such that it and all smaller ones tried are stable
  std::optional<double> unstable;  ///< the next larger one
  Verdict how = Verdict::stable;   ///< what goes wrong there
  double largerStable = 0;         ///< the largest step of all that passed
};

/// A case, ready to be run again and again.
class Bench {
 public:
  /// The case must outlive this object.
  explicit Bench(const Case& given);

  Verdict run(const Method& method, double h);
  /// Steps of 1, 0.5, 0.2, 0.1 … s, down to a decade of stable ones and at least to 1 ms; then by bisection.
  Limit findLimit(const Method& method);

  /// Angles after 1 s, by `auto` at a tolerance of 1e-10. Nothing when that takes too long.
  const std::optional<Eigen::VectorXd>& reference();
  /// Largest error of an angle after 1 s, rad; nothing without a reference, or when it takes too long. Not
  /// finite if the run is not.
  std::optional<double> errorAfterASecond(const Method& method, double h);

  /// The largest step at which no mode of the chain at rest grows: |R(h λ)| ≤ 1 for every eigenvalue λ of J
  /// and every smaller h, with R the method's own polynomial. For explicit methods close to rest.
  std::optional<double> predictedLimit(const Method& method);
  /// 1/s; of the chain at rest.
  double largestFrequency();

 private:
  Eigen::VectorXd atRest() const;
  double energyOfMotion(const ode::State& state) const;
  void findEigenvalues();

  const Case& case_;
  int n_;
  Dynamics dynamics_;
  ode::State start_;
  double energyAtRest_ = 0, energyAtStart_ = 0;
  std::vector<std::complex<double>> eigenvalues_;
  bool referenceTried_ = false;
  std::optional<Eigen::VectorXd> reference_;
};

}  // namespace planar_chain::tools
