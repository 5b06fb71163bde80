#include "planar_chain/ode/explicit_runge_kutta.h"

#include <algorithm>

#include "../simd/kernel.h"

namespace planar_chain::ode {

ExplicitRungeKutta::ExplicitRungeKutta(const Tableau& table, System& f)
    : table_(table),
      f_(f),
      size_(f.arrangedSize()),
      positions_(f.positions()),
      rates_(size_ - positions_),
      damp_(simd::kernelFor(size_).vectors.damp),
      slopes_(table.b.size(), static_cast<std::size_t>(rates_)),
      stage_(static_cast<std::size_t>(size_)),
      coarse_(static_cast<std::size_t>(table.coarse.empty() ? 0 : size_)),
      slope_(size_),
      increment_(slope_),
      error_(table.e.empty() ? 0 : size_) {
  for (std::size_t i = 0; i < table.b.size(); ++i) k_.push_back(slopes_.row(i));
  // Nothing depends on what stands behind the rates, nor has it an error that counts.
  const Eigen::Index behind = size_ - 2 * positions_, others = positions_ > 0 ? 0 : behind;
  const auto row = [&](const std::vector<double>& weights, double drift, Eigen::Index count) {
    return NystromRow(weights, drift, table.a, k_, positions_, count);
  };
  for (std::size_t i = 0; i < table.a.size(); ++i) a_.push_back(row(table.a[i], table.c[i], others));
  b_ = row(table.b, 1, behind);
  e_ = row(table.e, 0, others);
  coarseWeights_ = row(table.coarse, 0, others);
}

double ExplicitRungeKutta::cost() const {
  return static_cast<double>(k_.size()) - (table_.lastIsFirst ? 1 : 0);
}

void ExplicitRungeKutta::evaluateFirst(double t, const double* y) {
  if (!firstIsKnown_) f_.rates(t, y, k_.front());
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
  evaluateFirst(t, start);
  const std::size_t last = k_.size() - 1, rows = table_.lastIsFirst ? last : last + 1;
  for (std::size_t i = 1; i < rows; ++i) {
    a_[i].run(h, start, nullptr, stage);
    f_.rates(t + table_.c[i] * h, stage, k_[i]);
  }
  b_.run(h, start, increment_.data(), table_.lastIsFirst ? stage : nullptr);
  if (table_.lastIsFirst) f_.rates(t + h, stage, k_[last]);
  if (!table_.e.empty()) e_.run(h, start, error_.data(), nullptr);
  if (!table_.coarse.empty()) {
    coarseWeights_.run(h, start, coarse_.data(), nullptr);
    damp_(error_.data(), coarse_.data(), size_);
  }
}

void ExplicitRungeKutta::accept() {
  firstIsKnown_ = table_.lastIsFirst;
  if (table_.lastIsFirst) std::copy_n(k_.back(), rates_, k_.front());  // the rows know where they stand
}

}  // namespace planar_chain::ode
