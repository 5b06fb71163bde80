#pragma once

/// The steps of every explicit Runge–Kutta method; see tableau.h.

#include <vector>

#include "ode/combination.h"
#include "ode/stepper.h"
#include "ode/tableau.h"
#include "simd/cache_lines.h"

namespace planar_chain::ode {

class ExplicitRungeKutta : public Stepper {
 public:
  /// f must outlive the stepper; the table is copied. Allocates.
  /// @throws std::invalid_argument for a table of more than 13 stages.
  ExplicitRungeKutta(const Tableau& table, System& f);

  double cost() const override;
  const Vector& derivative(double t, const Vector& y) override;
  void step(double t, double h, const Vector& y) override;
  void accept() override;
  void forget() override { firstIsKnown_ = false; }

 private:
  void evaluateFirst(double t, const double* y);
  void evaluate(double t, const double* y, double* k);

  Tableau table_;
  Eigen::Index size_, positions_, rates_;  ///< of y; those in Nyström's form; the components of a slope
  bool slopesAreWhole_;                    ///< with the rates of positions that are not in Nyström's form
  CacheRows slopes_;
  std::vector<double*> k_;  ///< these, one a stage
  std::vector<NystromRow> a_;
  NystromRow b_, e_, coarseRow_;
  CacheLines stage_, coarse_;
  Vector slope_;
  bool firstIsKnown_ = false;
};

}  // namespace planar_chain::ode
