#include "ode/explicit_runge_kutta.h"

#include <algorithm>
#include <utility>

#include "simd/vectors.h"

namespace planar_chain::ode {

namespace {

/// Shorter chains' sums are up to 10 % of a step faster with the rates of the stages.
constexpr Eigen::Index leastInNystromsForm = 64;

const Tableau& checked(const Tableau& table) {
  requireAtMost(simd::VectorKernel::mostTerms, table.b.size(), table.name);
  return table;
}

}  // namespace

ExplicitRungeKutta::ExplicitRungeKutta(const Tableau& table, System& f)
    : Stepper({table.name, table.order, table.errorOrder, table.stabilityLimit}, f),
      table_(checked(table)),
      size_(f.arrangedSize()),
      positions_(f.positions() < leastInNystromsForm ? 0 : f.positions()),
      rates_(size_ - positions_),
      slopesAreWhole_(f.positions() > positions_),
      damp_(simd::vectors().damp),
      slopes_(table.b.size(), static_cast<std::size_t>(rates_)),
      stage_(static_cast<std::size_t>(size_)),
      coarse_(static_cast<std::size_t>(table.coarse.empty() ? 0 : size_)),
      slope_(size_) {
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

[[gnu::always_inline]] inline void ExplicitRungeKutta::evaluate(double t, const double* y, double* k) {
  slopesAreWhole_ ? system_.slope(t, y, k) : system_.rates(t, y, k);
}

void ExplicitRungeKutta::evaluateFirst(double t, const double* y) {
  if (!firstIsKnown_) evaluate(t, y, way_->k.front());
  firstIsKnown_ = true;
}

const Vector& ExplicitRungeKutta::derivative(double t, const Vector& y) {
  evaluateFirst(t, y.data());
  std::copy_n(y.data() + positions_, positions_, slope_.data());
  std::copy_n(way_->k.front(), rates_, slope_.data() + positions_);
  return slope_;
}

void ExplicitRungeKutta::step(double t, double h, const Vector& y) {
  const double* start = y.data();
  double* stage = stage_.data();
  const Way& way = *way_;

  // Slopes of the stages.
  evaluateFirst(t, start);
  const std::size_t stages = way.k.size() - (table_.lastIsFirst ? 1 : 0);
  for (std::size_t i = 1; i < stages; ++i) {
    way.a[i].run(h, start, nullptr, stage);
    evaluate(t + table_.c[i] * h, stage, way.k[i]);
  }

  // The increment. With FSAL, the end of the step is the last stage.
  way.b.run(h, start, increment_.data(), table_.lastIsFirst ? stage : nullptr);
  if (table_.lastIsFirst) evaluate(t + h, stage, way.k.back());

  // The error.
  if (!table_.e.empty()) way.e.run(h, start, error_.data(), nullptr);
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
