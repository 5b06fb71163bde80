#pragma once

/// The steps of every explicit Runge–Kutta method; see tableau.h.

#include "planar_chain/cache_lines.h"
#include "planar_chain/ode/nystrom.h"
#include "planar_chain/ode/stepper.h"
#include "planar_chain/ode/tableau.h"

namespace planar_chain::ode {

class ExplicitRungeKutta : public Stepper {
 public:
  /// f must outlive the stepper; the table is copied.
  ExplicitRungeKutta(const Tableau& table, System& f);

  const char* name() const override { return table_.name; }
  int order() const override { return table_.order; }
  int errorOrder() const override { return table_.errorOrder; }

  double cost() const override;
  double stabilityLimit() const override { return table_.stabilityLimit; }
  System& system() override { return f_; }
  const Eigen::VectorXd& derivative(double t, const Eigen::VectorXd& y) override;
  void step(double t, double h, const Eigen::VectorXd& y) override;
  const Eigen::VectorXd& increment() const override { return increment_; }
  const Eigen::VectorXd& error() const override { return error_; }
  void accept() override;
  void forget() override { firstIsKnown_ = false; }

 private:
  /// y, arranged; and f there.
  const double* arranged(const Eigen::VectorXd& y);
  void evaluateFirst(double t, const double* y);

  Tableau table_;
  System& f_;
  bool isArranged_;
  Eigen::Index size_, positions_, rates_;  ///< arranged: of y; rates: components of f but for the positions'
  void (*damp_)(double* error, const double* coarse, std::ptrdiff_t n);
  CacheRows slopes_;
  std::vector<double*> k_;  ///< these, at the stages
  std::vector<NystromRow> a_;
  NystromRow b_, e_, coarseWeights_;
  CacheLines start_, stage_, arrangedIncrement_, arrangedError_, coarse_;
  Eigen::VectorXd slope_, increment_, error_;
  double *incrementInStages_, *errorInStages_;  ///< where they are found
  bool firstIsKnown_ = false;
};

}  // namespace planar_chain::ode
