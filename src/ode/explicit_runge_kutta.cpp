#include "planar_chain/ode/explicit_runge_kutta.h"

#include <algorithm>

#include "../simd/kernel.h"

namespace planar_chain::ode {

namespace {

/// Numbers from one row to the next, of so many each: whole cache lines, an odd number of them, so that rows
/// do not compete for the same places of a cache.
std::size_t apart(Eigen::Index size) {
  constexpr std::size_t line = 64 / sizeof(double);
  return ((static_cast<std::size_t>(size) + line - 1) / line | 1) * line;
}

}  // namespace

ExplicitRungeKutta::ExplicitRungeKutta(const Tableau& table, System& f)
    : table_(table),
      f_(f),
      positions_(f.positions()),
      damp_(simd::kernelFor(f.size()).vectors.damp),
      rates_(f.size() - positions_),
      slopes_(table.b.size() * apart(rates_)),
      stage_(static_cast<std::size_t>(f.size())),
      slope_(Eigen::VectorXd::Zero(f.size())),
      increment_(slope_),
      coarse_(Eigen::VectorXd::Zero(table.coarse.empty() ? 0 : f.size())),
      error_(Eigen::VectorXd::Zero(table.e.empty() ? 0 : f.size())) {
  for (std::size_t i = 0; i < table.b.size(); ++i) k_.push_back(slopes_.data() + i * apart(rates_));
  // Nothing depends on what stands behind the rates, nor has it an error that counts.
  const Eigen::Index behind = f.size() - 2 * positions_, others = positions_ > 0 ? 0 : behind;
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

void ExplicitRungeKutta::evaluateFirst(double t, const Eigen::VectorXd& y) {
  if (!firstIsKnown_) f_.rates(t, y.data(), k_.front());
  firstIsKnown_ = true;
}

const Eigen::VectorXd& ExplicitRungeKutta::derivative(double t, const Eigen::VectorXd& y) {
  evaluateFirst(t, y);
  std::copy_n(y.data() + positions_, positions_, slope_.data());
  std::copy_n(k_.front(), rates_, slope_.data() + positions_);
  return slope_;
}

void ExplicitRungeKutta::step(double t, double h, const Eigen::VectorXd& y) {
  evaluateFirst(t, y);
  const std::size_t last = k_.size() - 1;
  for (std::size_t i = 1; i <= last; ++i) {
    if (i == last && table_.lastIsFirst) {
      b_.addTo(y, h, increment_, stage_.data());
    } else {
      a_[i].addTo(y, h, stage_.data());
    }
    f_.rates(t + table_.c[i] * h, stage_.data(), k_[i]);
  }
  if (!table_.lastIsFirst) b_.increment(y, h, increment_);
  if (!table_.e.empty()) e_.increment(y, h, error_);
  if (!table_.coarse.empty()) {
    coarseWeights_.increment(y, h, coarse_);
    damp_(error_.data(), coarse_.data(), error_.size());
  }
}

void ExplicitRungeKutta::accept() {
  firstIsKnown_ = table_.lastIsFirst;
  if (table_.lastIsFirst) std::copy_n(k_.back(), rates_, k_.front());  // the rows know where they stand
}

}  // namespace planar_chain::ode
