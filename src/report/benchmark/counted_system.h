#pragma once

/// Counts the calls of a method to a system.

#include <complex>

#include "ode/system.h"

namespace planar_chain::benchmarks {

class CountedSystem : public ode::SeriesSystem {
 public:
  explicit CountedSystem(ode::SeriesSystem& f) : f_(f) {}
  int size() const override { return f_.size(); }
  void derivative(double t, const double* y, double* dydt) override {
    ++evaluations;
    f_.derivative(t, y, dydt);
  }
  const simd::VectorKernel& vectors() const override { return f_.vectors(); }
  int sizeInLaneOrder() const override { return f_.sizeInLaneOrder(); }
  bool hasOneOrder() const override { return f_.hasOneOrder(); }
  void toLaneOrder(const double* y, double* laneOrdered) const override { f_.toLaneOrder(y, laneOrdered); }
  void toChainOrder(const double* laneOrdered, double* y) const override { f_.toChainOrder(laneOrdered, y); }
  int positions() const override { return f_.positions(); }
  int firstRate() const override { return f_.firstRate(); }
  void rates(double t, const double* y, double* out) override {
    ++evaluations;
    f_.rates(t, y, out);
  }
  void linearize(double t, const double* y, double* dydt) override {
    ++linearizations;
    f_.linearize(t, y, dydt);
  }
  bool timeDerivative(double* ft) override { return f_.timeDerivative(ft); }
  ode::LinearCosts linearCosts() const override { return f_.linearCosts(); }
  void factor(double s) override {
    ++factors;
    f_.factor(s);
  }
  void solve(const double* rhs, double* x) override {
    ++solves;
    f_.solve(rhs, x);
  }
  void reserve(int complexCount) override { f_.reserve(complexCount); }
  void factorComplex(int k, std::complex<double> s) override {
    ++complexFactors;
    f_.factorComplex(k, s);
  }
  void solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) override {
    ++complexSolves;
    f_.solveComplex(k, rhs, x);
  }
  bool seriesAreWorthwhile() const override { return f_.seriesAreWorthwhile(); }
  void reserveSeries(int order) override { f_.reserveSeries(order); }
  int driving() const override { return f_.driving(); }
  void series(double t, const double* y, const double* carry, int order, double* c) override {
    f_.series(t, y, carry, order, c);
  }
  bool hasIntegrands() const override { return f_.hasIntegrands(); }
  void integrands(double t, const double* y, double* rates) override {
    ++integrals;
    f_.integrands(t, y, rates);
  }
  double seriesCost(int order) const override { return f_.seriesCost(order); }

  long long evaluations = 0, linearizations = 0, integrals = 0;
  long long factors = 0, solves = 0, complexFactors = 0, complexSolves = 0;

 private:
  ode::SeriesSystem& f_;
};

}  // namespace planar_chain::benchmarks
