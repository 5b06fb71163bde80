#include "planar_chain/ode/explicit_runge_kutta.h"

#include <utility>

namespace planar_chain::ode {

ExplicitRungeKutta::ExplicitRungeKutta(const Tableau& table, int size)
    : table_(table),
      k_(table.b.size(), Eigen::VectorXd::Zero(size)),
      stage_(Eigen::VectorXd::Zero(size)),
      increment_(Eigen::VectorXd::Zero(size)),
      error_(Eigen::VectorXd::Zero(table.e.empty() ? 0 : size)) {}

const Eigen::VectorXd& ExplicitRungeKutta::derivative(System& f, double t, const Eigen::VectorXd& y) {
  if (!firstIsKnown_) f.derivative(t, y.data(), k_.front().data());
  firstIsKnown_ = true;
  return k_.front();
}

void ExplicitRungeKutta::step(System& f, double t, double h, const Eigen::VectorXd& y) {
  derivative(f, t, y);
  for (std::size_t i = 1; i < k_.size(); ++i) {
    combine(h, table_.a[i], stage_);
    stage_ += y;
    f.derivative(t + table_.c[i] * h, stage_.data(), k_[i].data());
  }
  combine(h, table_.b, increment_);
  if (!table_.e.empty()) combine(h, table_.e, error_);
}

void ExplicitRungeKutta::accept() {
  firstIsKnown_ = table_.lastIsFirst;
  if (table_.lastIsFirst) std::swap(k_.front(), k_.back());
}

void ExplicitRungeKutta::combine(double h, const std::vector<double>& weights, Eigen::VectorXd& out) const {
  out = (h * weights[0]) * k_[0];
  for (std::size_t j = 1; j < weights.size(); ++j) {
    if (weights[j] != 0) out += (h * weights[j]) * k_[j];
  }
}

}  // namespace planar_chain::ode
