#include "planar_chain/ode/explicit_runge_kutta.h"

#include <algorithm>

#include "../simd/kernel.h"

namespace planar_chain::ode {

ExplicitRungeKutta::ExplicitRungeKutta(const Tableau& table, System& f)
    : table_(table),
      f_(f),
      isArranged_(f.isArranged()),
      size_(f.arrangedSize()),
      positions_(f.positions()),
      rates_(size_ - positions_),
      damp_(simd::kernelFor(size_).vectors.damp),
      slopes_(table.b.size(), static_cast<std::size_t>(rates_)),
      stage_(static_cast<std::size_t>(size_)),
      coarse_(static_cast<std::size_t>(table.coarse.empty() ? 0 : size_)),
      slope_(Eigen::VectorXd::Zero(f.size())),
      increment_(slope_),
      error_(Eigen::VectorXd::Zero(table.e.empty() ? 0 : f.size())),
      incrementInStages_(increment_.data()),
      errorInStages_(error_.data()) {
  if (isArranged_) {
    for (CacheLines* lines : {&start_, &arrangedIncrement_, &arrangedError_}) {
      *lines = CacheLines(static_cast<std::size_t>(size_));
    }
    incrementInStages_ = arrangedIncrement_.data();
    errorInStages_ = arrangedError_.data();
  }
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

const double* ExplicitRungeKutta::arranged(const Eigen::VectorXd& y) {
  if (!isArranged_) return y.data();
  f_.arrange(y.data(), start_.data());
  return start_.data();
}

void ExplicitRungeKutta::evaluateFirst(double t, const double* y) {
  if (!firstIsKnown_) f_.rates(t, y, k_.front());
  firstIsKnown_ = true;
}

const Eigen::VectorXd& ExplicitRungeKutta::derivative(double t, const Eigen::VectorXd& y) {
  const double* start = arranged(y);
  evaluateFirst(t, start);
  std::copy_n(start + positions_, positions_, stage_.data());
  std::copy_n(k_.front(), rates_, stage_.data() + positions_);
  f_.restore(stage_.data(), slope_.data());
  return slope_;
}

void ExplicitRungeKutta::step(double t, double h, const Eigen::VectorXd& y) {
  const double* start = arranged(y);
  evaluateFirst(t, start);
  const std::size_t last = k_.size() - 1;
  for (std::size_t i = 1; i <= last; ++i) {
    if (i == last && table_.lastIsFirst) {
      b_.run(h, start, incrementInStages_, stage_.data());
    } else {
      a_[i].run(h, start, nullptr, stage_.data());
    }
    f_.rates(t + table_.c[i] * h, stage_.data(), k_[i]);
  }
  if (!table_.lastIsFirst) b_.run(h, start, incrementInStages_, nullptr);
  if (!table_.e.empty()) e_.run(h, start, errorInStages_, nullptr);
  if (!table_.coarse.empty()) {
    coarseWeights_.run(h, start, coarse_.data(), nullptr);
    damp_(errorInStages_, coarse_.data(), size_);
  }
  if (isArranged_) {
    f_.restore(incrementInStages_, increment_.data());
    if (!table_.e.empty()) f_.restore(errorInStages_, error_.data());
  }
}

void ExplicitRungeKutta::accept() {
  firstIsKnown_ = table_.lastIsFirst;
  if (table_.lastIsFirst) std::copy_n(k_.back(), rates_, k_.front());  // the rows know where they stand
}

}  // namespace planar_chain::ode
