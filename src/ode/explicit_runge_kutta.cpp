#include "ode/explicit_runge_kutta.h"

#include <algorithm>

namespace planar_chain::ode {

namespace {

/// Shorter chains' sums are up to 10 % of a step faster with the rates of the stages.
constexpr Eigen::Index leastInNystromsForm = 64;

}  // namespace

ExplicitRungeKutta::ExplicitRungeKutta(const Tableau& table, System& f)
    : Stepper(table, f),
      table_(table),
      size_(f.arrangedSize()),
      positions_(f.positions() < leastInNystromsForm ? 0 : f.positions()),
      rates_(size_ - positions_),
      slopesAreWhole_(f.positions() > positions_),
      slopes_(checkedStages(table.b.size(), table.name), static_cast<std::size_t>(rates_)),
      k_(slopes_.rows()),
      stage_(static_cast<std::size_t>(size_)),
      coarse_(static_cast<std::size_t>(table.coarse.empty() ? 0 : size_)),
      slope_(size_) {
  // Nothing depends on what stands behind the rates, nor has it an error that counts.
  const Eigen::Index behind = size_ - 2 * positions_, others = positions_ > 0 ? 0 : behind;
  const auto row = [&](const std::vector<double>& weights, double drift, Eigen::Index count) {
    return NystromRow(weights, drift, table.a, k_, positions_, count);
  };
  for (std::size_t i = 0; i < table.a.size(); ++i) a_.push_back(row(table.a[i], table.c[i], others));
  b_ = row(table.b, 1, behind);
  e_ = row(table.e, 0, others);
  coarseRow_ = row(table.coarse, 0, others);
}

double ExplicitRungeKutta::cost() const {
  return static_cast<double>(table_.b.size()) - (table_.lastIsFirst ? 1 : 0);
}

[[gnu::always_inline]] inline void ExplicitRungeKutta::evaluate(double t, const double* y, double* k) {
  slopesAreWhole_ ? system_.slope(t, y, k) : system_.rates(t, y, k);
}

void ExplicitRungeKutta::evaluateFirst(double t, const double* y) {
  if (!firstIsKnown_) evaluate(t, y, k_.front());
  firstIsKnown_ = true;
}

const Vector& ExplicitRungeKutta::derivative(double t, const Vector& y) {
  evaluateFirst(t, y.data());
  std::copy_n(y.data() + positions_, positions_, slope_.data());
  std::copy_n(k_.front(), rates_, slope_.data() + positions_);
  return slope_;
}

void ExplicitRungeKutta::step(double t, double h, const Vector& y) {
  const double* start = y.data();
  double* stage = stage_.data();

  // Slopes of the stages.
  evaluateFirst(t, start);
  const std::size_t stages = k_.size() - (table_.lastIsFirst ? 1 : 0);
  for (std::size_t i = 1; i < stages; ++i) {
    a_[i].run(h, start, nullptr, stage);
    evaluate(t + table_.c[i] * h, stage, k_[i]);
  }

  // The increment. With FSAL, the end of the step is the last stage.
  b_.run(h, start, increment_.data(), table_.lastIsFirst ? stage : nullptr);
  if (table_.lastIsFirst) evaluate(t + h, stage, k_.back());

  // The error.
  if (!table_.e.empty()) e_.run(h, start, error_.data(), nullptr);
  if (!table_.coarse.empty()) {
    coarseRow_.run(h, start, coarse_.data(), nullptr);
    vectors_.damp(error_.data(), coarse_.data(), size_);
  }
}

void ExplicitRungeKutta::accept() {
  firstIsKnown_ = table_.lastIsFirst;
  if (table_.lastIsFirst) std::copy_n(k_.back(), rates_, k_.front());
}

}  // namespace planar_chain::ode
