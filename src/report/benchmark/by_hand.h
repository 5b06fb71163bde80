#pragma once

/// The equations that an expert would write for a chain without springs, dampers and loads.

#include <Eigen/Dense>
#include <memory>

#include "report/benchmark/peer.h"

namespace planar_chain::benchmarks {

/// θ and ω of a posture, α, and back.
class InAbsoluteAngles : public Peer {
 public:
  explicit InAbsoluteAngles(int n) : n_(n), theta_(n), omega_(n), alpha_(n) {}

  void place(const Posture& posture) override {
    double theta = 0, omega = 0;
    for (Eigen::Index i = 0; i < n_; ++i) {
      theta_[i] = theta += posture.q[static_cast<std::size_t>(i)];
      omega_[i] = omega += posture.qd[static_cast<std::size_t>(i)];
    }
  }

  /// Sets absolute angles and rates, n values each.
  void place(const double* theta, const double* omega) {
    theta_ = Eigen::Map<const Eigen::ArrayXd>(theta, n_);
    omega_ = Eigen::Map<const Eigen::ArrayXd>(omega, n_);
  }
  const Eigen::VectorXd& alpha() const { return alpha_; }

  void read(double* qdd) const override { makeRelative(alpha_.data(), n_, qdd); }

 protected:
  int n_;
  Eigen::ArrayXd theta_, omega_;
  Eigen::VectorXd alpha_;
};

/// Two links, their centres of mass on their lines: the closed form.
std::unique_ptr<InAbsoluteAngles> doublePendulumByHand(const Chain& chain);
/// Any chain: the mass matrix and Cholesky's decomposition.
std::unique_ptr<InAbsoluteAngles> denseByHand(const Chain& chain);

}  // namespace planar_chain::benchmarks
