#pragma once

/// The largest stable step of a method with equal steps, measured and by theory.
///
/// Steps of h are stable on a scene if a run stays finite and the energy of motion, T + V less the V of
/// hanging straight down, never exceeds 1.1 times its value at the start. No load acts, so the true energy
/// never grows. A method that takes energy away is stable, but not accurate. A run takes 200,000 link-steps,
/// but from 100 to 2000 steps, and lasts at least the scene's horizon.

#include <complex>
#include <optional>

#include "report/families.h"
#include "report/own.h"

namespace planar_chain::tools {

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
  explicit Bench(const Case& given);

  Verdict run(const Method& method, double h) const;
  /// Tries 1, 0.5, 0.2, 0.1 … s, down to a decade of stable steps and at least to 1 ms; then bisects to 3 %.
  Limit findLimit(const Method& method) const;
  /// The largest h with |R(h λ)| ≤ 1, for it and all smaller ones and every eigenvalue λ of the chain at
  /// rest. R is the polynomial of an explicit method. Nothing for other methods, and far from rest.
  std::optional<double> predictedLimit(const Method& method) const;
  /// |λ| of the chain at rest, 1/s.
  double largestEigenvalue() const;
  /// Largest error of an angle after 1 s, rad, against `auto` at tolerance 1e-10. Nothing if either run takes
  /// too long; infinite if the method's run is not finite.
  std::optional<double> errorAfterASecond(const Method& method, double h);

 private:
  const Case& case_;
  int n_;
  double energyAtRest_, energyAtStart_;
  std::vector<std::complex<double>> eigenvalues_;
  bool referenceTried_ = false;
  std::optional<Eigen::VectorXd> reference_;
};

}  // namespace planar_chain::tools
