#include "planar_chain/ode/explicit_runge_kutta.h"

#include <cmath>
#include <utility>

namespace planar_chain::ode {

ExplicitRungeKutta::ExplicitRungeKutta(const Tableau& table, System& f)
    : table_(table),
      f_(f),
      k_(table.b.size(), Eigen::VectorXd::Zero(f.size())),
      stage_(Eigen::VectorXd::Zero(f.size())),
      increment_(Eigen::VectorXd::Zero(f.size())),
      coarse_(Eigen::VectorXd::Zero(table.coarse.empty() ? 0 : f.size())),
      error_(Eigen::VectorXd::Zero(table.e.empty() ? 0 : f.size())) {}

double ExplicitRungeKutta::cost() const {
  return static_cast<double>(k_.size()) - (table_.lastIsFirst ? 1 : 0);
}

const Eigen::VectorXd& ExplicitRungeKutta::derivative(double t, const Eigen::VectorXd& y) {
  if (!firstIsKnown_) f_.derivative(t, y.data(), k_.front().data());
  firstIsKnown_ = true;
  return k_.front();
}

void ExplicitRungeKutta::step(double t, double h, const Eigen::VectorXd& y) {
  derivative(t, y);
  for (std::size_t i = 1; i < k_.size(); ++i) {
    combine(h, table_.a[i], stage_);
    stage_ += y;
    f_.derivative(t + table_.c[i] * h, stage_.data(), k_[i].data());
  }
  combine(h, table_.b, increment_);
  if (!table_.e.empty()) combine(h, table_.e, error_);
  if (!table_.coarse.empty()) {
    combine(h, table_.coarse, coarse_);
    for (Eigen::Index i = 0; i < error_.size(); ++i) {
      const double size = std::hypot(error_[i], 0.1 * coarse_[i]);
      error_[i] = size > 0 ? error_[i] * (error_[i] / size) : size;
    }
  }
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
