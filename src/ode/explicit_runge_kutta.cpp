#include "planar_chain/ode/explicit_runge_kutta.h"

#include <cmath>

namespace planar_chain::ode {

ExplicitRungeKutta::ExplicitRungeKutta(const Tableau& table, System& f)
    : table_(table),
      f_(f),
      k_(table.b.size(), Eigen::VectorXd::Zero(f.size())),
      a_(combinationsOf(table.a, k_)),
      b_(table.b, k_),
      e_(table.e, k_),
      coarseWeights_(table.coarse, k_),
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
  const std::size_t last = k_.size() - 1;
  for (std::size_t i = 1; i <= last; ++i) {
    if (i == last && table_.lastIsFirst) {
      b_.addTo(y, h, increment_, stage_);
    } else {
      a_[i].addTo(y, h, stage_);
    }
    f_.derivative(t + table_.c[i] * h, stage_.data(), k_[i].data());
  }
  if (!table_.lastIsFirst) b_(h, increment_);
  if (!table_.e.empty()) e_(h, error_);
  if (!table_.coarse.empty()) {
    coarseWeights_(h, coarse_);
    for (Eigen::Index i = 0; i < error_.size(); ++i) {
      const double size = std::sqrt(error_[i] * error_[i] + 0.01 * (coarse_[i] * coarse_[i]));
      error_[i] = size > 0 ? error_[i] * (error_[i] / size) : size;
    }
  }
}

void ExplicitRungeKutta::accept() {
  firstIsKnown_ = table_.lastIsFirst;
  if (table_.lastIsFirst) k_.front() = k_.back();  // not exchanged: the combinations know where they stand
}

}  // namespace planar_chain::ode
