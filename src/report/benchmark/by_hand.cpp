#include "report/benchmark/by_hand.h"

#include <cmath>

/// The equations that an expert would write for one chain, in absolute angles: the double pendulum's closed
/// form, and the mass matrix with Cholesky's decomposition.

namespace planar_chain::benchmarks {

namespace {

/// With the centres of mass on the links' lines, and δ = θ_1 − θ_2:
///
///     a α_1 + b cos δ α_2 = −b sin δ ω_2² − f_1 cos θ_1        a = I_1 + m_1 r_1² + m_2 l_1²
///     b cos δ α_1 + c α_2 =  b sin δ ω_1² − f_2 cos θ_2        b = m_2 l_1 r_2        c = I_2 + m_2 r_2²
///
/// and f_1 = (m_1 r_1 + m_2 l_1) g, f_2 = m_2 r_2 g. Solved by Cramer's rule; δ by the angles' own sines and
/// cosines, which the C library gives in pairs.
class DoublePendulum : public InAbsoluteAngles {
 public:
  explicit DoublePendulum(const Chain& chain) : InAbsoluteAngles(2) {
    const Link &first = chain.links()[0], &second = chain.links()[1];
    const double l = first.pin.x, g = -chain.gravity().y;
    a_ = first.inertia + first.mass * first.com.x * first.com.x + second.mass * l * l;
    b_ = second.mass * l * second.com.x;
    c_ = second.inertia + second.mass * second.com.x * second.com.x;
    f1_ = (first.mass * first.com.x + second.mass * l) * g;
    f2_ = second.mass * second.com.x * g;
  }

  void evaluate() override {
    const double c1 = std::cos(theta_[0]), s1 = std::sin(theta_[0]);
    const double c2 = std::cos(theta_[1]), s2 = std::sin(theta_[1]);
    const double bc = b_ * (c1 * c2 + s1 * s2), bs = b_ * (s1 * c2 - c1 * s2);
    const double right1 = -bs * omega_[1] * omega_[1] - f1_ * c1;
    const double right2 = bs * omega_[0] * omega_[0] - f2_ * c2;
    const double inverse = 1 / (a_ * c_ - bc * bc);
    alpha_[0] = (c_ * right1 - bc * right2) * inverse;
    alpha_[1] = (a_ * right2 - bc * right1) * inverse;
  }

 private:
  double a_, b_, c_, f1_, f2_;
};

/// With s^j = m_j r^j + (m_{j+1} + … + m_n) p^j, turned into ground axes S_j = e_j s^j, P_i = e_i p^i:
///
///     M_ij = P_i·S_j (i < j)        M_jj = I_j + m_j |r^j|² + (m_{j+1} + … + m_n) |p^j|²
///     M α = iS·g + Σ_{j > i} ω_j² (iP_i)·S_j + Σ_{j < i} ω_j² (iS_i)·P_j
class Dense : public InAbsoluteAngles {
 public:
  explicit Dense(const Chain& chain)
      : InAbsoluteAngles(chain.size()),
        gravity_(chain.gravity()),
        p_(n_, 2),
        s_(n_, 2),
        P_(n_, 2),
        S_(n_, 2),
        diagonal_(n_),
        cross_(n_),
        M_(n_, n_) {
    double outer = 0;
    for (Eigen::Index j = n_ - 1; j >= 0; --j) {
      const Link& link = chain.links()[static_cast<std::size_t>(j)];
      const Vec2d s = link.mass * link.com + outer * link.pin;
      p_.row(j) << link.pin.x, link.pin.y;
      s_.row(j) << s.x, s.y;
      diagonal_[j] = link.inertia + link.mass * dot(link.com, link.com) + outer * dot(link.pin, link.pin);
      outer += link.mass;
    }
  }

  void evaluate() override {
    for (Eigen::Index j = 0; j < n_; ++j) {
      const double c = std::cos(theta_[j]), s = std::sin(theta_[j]);
      P_.row(j) << c * p_(j, 0) - s * p_(j, 1), s * p_(j, 0) + c * p_(j, 1);
      S_.row(j) << c * s_(j, 0) - s * s_(j, 1), s * s_(j, 0) + c * s_(j, 1);
    }
    alpha_ = (S_.col(0) * gravity_.y - S_.col(1) * gravity_.x).matrix();
    for (Eigen::Index i = 0; i < n_; ++i) {
      const Eigen::Index rest = n_ - i - 1;
      const double x = P_(i, 0), y = P_(i, 1), ww = omega_[i] * omega_[i];
      const auto Sx = S_.col(0).tail(rest), Sy = S_.col(1).tail(rest);
      M_(i, i) = diagonal_[i];
      M_.col(i).tail(rest) = (x * Sx + y * Sy).matrix();
      auto cross = cross_.tail(rest);
      cross = x * Sy - y * Sx;
      alpha_[i] += (omega_.tail(rest).square() * cross).sum();
      alpha_.tail(rest) -= ww * cross.matrix();
    }
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> inPlace(M_);
    inPlace.solveInPlace(alpha_);
  }

 private:
  Vec2d gravity_;
  Eigen::ArrayX2d p_, s_, P_, S_;
  Eigen::ArrayXd diagonal_, cross_;
  Eigen::MatrixXd M_;
};

}  // namespace

std::unique_ptr<InAbsoluteAngles> doublePendulumByHand(const Chain& chain) {
  return std::make_unique<DoublePendulum>(chain);
}

std::unique_ptr<InAbsoluteAngles> denseByHand(const Chain& chain) {
  return std::make_unique<Dense>(chain);
}

PeerKind closedForm() {
  return {"closed form", "by hand", 2, 2, 1e-6, [](const Chain& chain) -> std::unique_ptr<Peer> {
            return doublePendulumByHand(chain);
          }};
}

PeerKind denseCholesky() {
  return {"dense",
          "Eigen " + std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
              std::to_string(EIGEN_MINOR_VERSION),
          1,
          1000,
          1e-6,
          [](const Chain& chain) -> std::unique_ptr<Peer> { return denseByHand(chain); }};
}

}  // namespace planar_chain::benchmarks
