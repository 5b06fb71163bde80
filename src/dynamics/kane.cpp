#include "planar_chain/kane.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>
#include <string>
#include <variant>

namespace planar_chain {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::RowVector2d;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

void requireSize(const char* name, const VectorXd& v, int expected) {
  if (v.size() != expected) {
    throw std::invalid_argument(std::string(name) + ": expected " + std::to_string(expected) +
                                " values, got " + std::to_string(v.size()));
  }
}

void requireIndex(const Load& load, const char* what, int index, int n) {
  if (index != Load::none && (index < 0 || index >= n)) {
    throw std::invalid_argument("load " + load.name + ": the chain has no " + what + " " +
                                std::to_string(index));
  }
}

/// s = k x + d ẋ of a stop that pushes, x > 0 deep in it; else 0.
double pushOf(const Joint& joint, double x, double xd) {
  const double s = joint.stopStiffness * x + joint.stopDamping * xd;
  return x > 0 && s > 0 ? s : 0;
}

/// S_i0 = [[c, s], [−s, c]]
Matrix2d shifter(double theta) {
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  return (Matrix2d() << c, s, -s, c).finished();
}

/// [ω^i] = [[0, ω_i], [−ω_i, 0]]
Matrix2d angularVelocityMatrix(double omega) {
  return (Matrix2d() << 0, omega, -omega, 0).finished();
}

/// S_r = [−r_y, r_x]: the row of k̂ × r
RowVector2d crossRow(Vec2d r) {
  return {-r.y, r.x};
}

}  // namespace

double factorAt(const Load& load, double t) {
  if (t < load.start || t >= load.stop) return 0;

  if (const auto* sine = std::get_if<Sine>(&load.law)) {
    return std::sin(2 * pi * sine->frequency * t + sine->phase);
  }
  if (const auto* ramp = std::get_if<Ramp>(&load.law)) {
    const auto& ts = ramp->times;
    const auto& ys = ramp->values;
    if (t <= ts.front()) return ys.front();
    for (std::size_t k = 1; k < ts.size(); ++k) {
      if (t < ts[k]) {
        return ys[k - 1] + (ys[k] - ys[k - 1]) * (t - ts[k - 1]) / (ts[k] - ts[k - 1]);
      }
    }
    return ys.back();
  }
  return 1;
}

ActiveForces activeForces(const Scene& scene, double t, const VectorXd& q, const VectorXd& qd) {
  const Chain& chain = scene.chain;
  const int n = chain.size();
  requireSize("q", q, n);
  requireSize("qd", qd, n);

  ActiveForces active{VectorXd::Zero(2 * n), VectorXd::Zero(n), VectorXd::Zero(n)};

  // Gravity: F^i = m_i g
  for (int i = 0; i < n; ++i) {
    active.F(2 * i) = chain.links()[i].mass * chain.gravity().x;
    active.F(2 * i + 1) = chain.links()[i].mass * chain.gravity().y;
  }

  // Springs, dampers and stops: τ_i = −k_i (q_i − q0_i) − d_i q̇_i − s_upper + s_lower
  for (int i = 0; i < n; ++i) {
    const Joint& joint = chain.joints()[i];
    active.tau(i) = -joint.stiffness * (q(i) - joint.restAngle) - joint.damping * qd(i) -
                    pushOf(joint, q(i) - joint.upper, qd(i)) + pushOf(joint, joint.lower - q(i), -qd(i));
  }

  // Loads. A force X at the point x (link frame) has the moment ((x − r) S_i0) × X about the centre
  // of mass.
  for (const Load& load : scene.loads) {
    requireIndex(load, "link", load.link, n);
    requireIndex(load, "joint", load.joint, n);
    const double factor = factorAt(load, t);
    if (load.link != Load::none) {
      const Vec2d r = chain.links()[load.link].com;
      const RowVector2d arm =
          RowVector2d(load.point.x - r.x, load.point.y - r.y) * shifter(q.head(load.link + 1).sum());
      active.F(2 * load.link) += factor * load.force.x;
      active.F(2 * load.link + 1) += factor * load.force.y;
      active.M(load.link) += factor * (load.moment + arm.x() * load.force.y - arm.y() * load.force.x);
    }
    if (load.joint != Load::none) active.tau(load.joint) += factor * load.torque;
  }
  return active;
}

Kane kane(const Chain& chain, const VectorXd& q, const VectorXd& qd, const ActiveForces& active) {
  const int n = chain.size();
  requireSize("q", q, n);
  requireSize("qd", qd, n);
  requireSize("F", active.F, 2 * n);
  requireSize("M", active.M, n);
  requireSize("tau", active.tau, n);
  const auto& [F, M, tau] = active;

  Kane k;
  k.q = q;
  k.qd = qd;

  // T_ωq:  [θ_1 … θ_n] = qᵀ T,  [ω_1 … ω_n] = q̇ᵀ T
  k.T = MatrixXd::Ones(n, n).triangularView<Eigen::Upper>();
  const RowVectorXd theta = q.transpose() * k.T;
  const RowVectorXd omega = qd.transpose() * k.T;

  // The shifters S_i0 and the angular velocity matrices [ω^i]
  for (int i = 0; i < n; ++i) {
    k.S.push_back(shifter(theta(i)));
    k.omega.push_back(angularVelocityMatrix(omega(i)));
  }

  // B and C: row i holds body i's own centre of mass, then its outer pin, which carries all that
  // follows.
  MatrixXd B = MatrixXd::Zero(n, 2 * n);
  MatrixXd C = MatrixXd::Zero(n, 2 * n);
  for (int i = 0; i < n; ++i) {
    const RowVector2d S_r = crossRow(chain.links()[i].com);
    const RowVector2d S_p = crossRow(chain.links()[i].pin);
    B.block<1, 2>(i, 2 * i) = S_r * k.S[i];
    C.block<1, 2>(i, 2 * i) = S_r * k.omega[i] * k.S[i];
    for (int j = i + 1; j < n; ++j) {
      B.block<1, 2>(i, 2 * j) = S_p * k.S[i];
      C.block<1, 2>(i, 2 * j) = S_p * k.omega[i] * k.S[i];
    }
  }

  // Partial velocities
  k.V_pd = k.T * B;
  k.W_pd = k.T;

  // Inertia: A_1, A_2, A_3
  VectorXd m(2 * n);
  VectorXd I(n);
  for (int i = 0; i < n; ++i) {
    m.segment<2>(2 * i).setConstant(chain.links()[i].mass);
    I(i) = chain.links()[i].inertia;
  }
  k.A_1 = k.T * C * m.asDiagonal();
  k.A_2 = k.T * B * m.asDiagonal();
  k.A_3 = k.T * I.asDiagonal();

  // Kane: V_pd (F + F_in) + W_pd (M + M_in) + τ = 0
  k.f_ext = k.V_pd * F + k.W_pd * M + tau;
  k.f = k.f_ext - k.V_pd * k.A_1.transpose() * qd;
  k.M_q = k.V_pd * k.A_2.transpose() + k.W_pd * k.A_3.transpose();
  k.qdd = k.M_q.ldlt().solve(k.f);
  return k;
}

}  // namespace planar_chain
