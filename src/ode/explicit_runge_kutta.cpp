#include "ode/explicit_runge_kutta.h"

#include <algorithm>
#include <utility>

#include "simd/vectors.h"

namespace planar_chain::ode {

ExplicitRungeKutta::ExplicitRungeKutta(const Tableau& table, System& f)
    : table_(table),
      f_(f),
      size_(f.arrangedSize()),
      positions_(f.positions()),
      rates_(size_ - positions_),
      damp_(simd::vectorsFor(size_).damp),
      slopes_(table.b.size(), static_cast<std::size_t>(rates_)),
      stage_(static_cast<std::size_t>(size_)),
      coarse_(static_cast<std::size_t>(table.coarse.empty() ? 0 : size_)),
      slope_(size_),
      increment_(slope_),
      error_(table.e.empty() ? 0 : size_) {
  std::vector<double*> k;
  for (std::size_t i = 0; i < table.b.size(); ++i) k.push_back(slopes_.row(i));
  ways_[0] = wayWith(k);
  if (table.lastIsFirst) std::swap(k.front(), k.back());
  ways_[1] = wayWith(k);
}

ExplicitRungeKutta::Way ExplicitRungeKutta::wayWith(const std::vector<double*>& k) const {
  // Nothing depends on what stands behind the rates, nor has it an error that counts.
  const Eigen::Index behind = size_ - 2 * positions_, others = positions_ > 0 ? 0 : behind;
  const auto row = [&](const std::vector<double>& weights, double drift, Eigen::Index count) {
    return NystromRow(weights, drift, table_.a, k, positions_, count);
  };
  Way way{k, {}, row(table_.b, 1, behind), row(table_.e, 0, others), row(table_.coarse, 0, others)};
  for (std::size_t i = 0; i < table_.a.size(); ++i) way.a.push_back(row(table_.a[i], table_.c[i], others));
  return way;
}

double ExplicitRungeKutta::cost() const {
  return static_cast<double>(table_.b.size()) - (table_.lastIsFirst ? 1 : 0);
}

void ExplicitRungeKutta::evaluateFirst(double t, const double* y) {
  if (!firstIsKnown_) f_.rates(t, y, way_->k.front());
  firstIsKnown_ = true;
}

const Vector& ExplicitRungeKutta::derivative(double t, const Vector& y) {
  evaluateFirst(t, y.data());
  std::copy_n(y.data() + positions_, positions_, slope_.data());
  std::copy_n(way_->k.front(), rates_, slope_.data() + positions_);
  return slope_;
}

/// The slope k of the stage, and the row that comes next.
[[gnu::always_inline]] inline void ExplicitRungeKutta::evaluate(double t, double* k, double h,
                                                                const double* base, const NystromRow& row,
                                                                double* sum, double* out) {
  if (positions_ > 0 && row.endsWith(k)) {
    return f_.ratesAndRow(t, stage_.data(), k, {row, h, base, sum, out});
  }
  f_.rates(t, stage_.data(), k);
  row.run(h, base, sum, out);
}

void ExplicitRungeKutta::step(double t, double h, const Vector& y) {
  const double* start = y.data();
  double* stage = stage_.data();
  evaluateFirst(t, start);
  const Way& way = *way_;
  way.a[1].run(h, start, nullptr, stage);
  const std::size_t last = way.k.size() - (table_.lastIsFirst ? 2 : 1);
  for (std::size_t i = 1; i < last; ++i) {
    evaluate(t + table_.c[i] * h, way.k[i], h, start, way.a[i + 1], nullptr, stage);
  }
  double* end = table_.lastIsFirst ? stage : nullptr;
  evaluate(t + table_.c[last] * h, way.k[last], h, start, way.b, increment_.data(), end);
  if (table_.lastIsFirst) {
    evaluate(t + h, way.k[last + 1], h, start, way.e, error_.data(), nullptr);
  } else if (!table_.e.empty()) {
    way.e.run(h, start, error_.data(), nullptr);
  }
  if (!table_.coarse.empty()) {
    way.coarse.run(h, start, coarse_.data(), nullptr);
    damp_(error_.data(), coarse_.data(), size_);
  }
}

void ExplicitRungeKutta::accept() {
  firstIsKnown_ = table_.lastIsFirst;
  way_ = way_ == ways_.data() ? &ways_[1] : &ways_[0];
}

}  // namespace planar_chain::ode
