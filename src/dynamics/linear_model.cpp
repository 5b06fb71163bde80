#include "planar_chain/linear_model.h"

#include <complex>
#include <stdexcept>
#include <vector>

#include "dynamics/coupled_dynamics.h"

namespace planar_chain {

namespace {

using Eigen::VectorXd;

/// A number and its slope along one direction, by a complex step: f(x + i h x') = f(x) + i h f'(x) x'. With h
/// this small, terms with h² vanish in the rounding. Source: W. Squire, G. Trapp, Using complex variables to
/// estimate derivatives of real functions, SIAM Rev. 40 (1998) 110–112.
using Nudged = std::complex<double>;
constexpr double h = 0x1p-300;
Nudged moving(double value, double slope) {
  return {value, slope * h};
}
double slopeOf(Nudged number) {
  return number.imag() / h;
}

}  // namespace

LinearModel linearModel(const Scene& scene, double t, const VectorXd& q, const VectorXd& qd) {
  const int n = scene.chain.size();
  if (q.size() != n || qd.size() != n) {
    throw std::invalid_argument("q and qd must have one value a joint");
  }
  CoupledDynamics dynamics(scene);
  VectorXd y(dynamics.size()), slope(dynamics.size());
  toAbsolute(q.data(), n, y.data());
  toAbsolute(qd.data(), n, y.data() + n);
  dynamics.enter(t);
  dynamics.enterState(t, y.data());
  dynamics.reserve(0);
  dynamics.linearize(t, y.data(), slope.data());
  const CoupledState at = dynamics.linearized();

  Coupled<Nudged> recursion(scene.chain);
  std::vector<Rotation<Nudged>> e(index(n));
  std::vector<Nudged> omega(index(n)), N(index(n)), alpha(index(n)), moments(index(n));
  std::vector<Vec2<Nudged>> F(index(n));
  std::vector<Coupling<Nudged>> joints;
  for (int i = 0; i < n; ++i) {
    const auto& [rotor, isHeld, acceleration] = at.joints[i];
    joints.push_back({rotor, isHeld, acceleration});
    if (at.F) F[index(i)] = {at.F[i].x, at.F[i].y};
  }

  // δq̈ while joint j, with all that hangs on it, turns by `turn`, speeds up by `speed`, and has `torque`
  // more.
  const auto along = [&](int j, double turn, double speed, double torque) {
    for (int i = 0; i < n; ++i) {
      const double hangs = i >= j ? 1 : 0;
      const auto [c, s] = at.e[i];
      e[index(i)] = {moving(c, -s * hangs * turn), moving(s, c * hangs * turn)};
      omega[index(i)] = moving(at.omega[i], hangs * speed);
      N[index(i)] = moving(dynamics.moments()[index(i)], -at.XF[i] * hangs * turn);
    }
    N[index(j)] += moving(0, torque);
    if (j > 0) N[index(j - 1)] -= moving(0, torque);
    recursion.accelerations(e.data(), omega.data(), N.data(), F.data(), joints.data(),
                            {at.ground.x, at.ground.y}, dynamics.couplings().angle.acceleration, alpha.data(),
                            moments.data());
    VectorXd change(n);
    for (int i = 0; i < n; ++i) change[i] = slopeOf(alpha[index(i)] - (i > 0 ? alpha[index(i - 1)] : 0));
    return change;
  };

  LinearModel model{Eigen::MatrixXd::Zero(2 * n, 2 * n), Eigen::MatrixXd::Zero(2 * n, n)};
  model.A.topRightCorner(n, n).setIdentity();
  for (int j = 0; j < n; ++j) {
    model.A.col(j).tail(n) = along(j, 1, 0, -at.k[j]);
    model.A.col(n + j).tail(n) = along(j, 0, 1, -at.d[j]);
    model.B.col(j).tail(n) = along(j, 0, 0, 1);
  }
  return model;
}

}  // namespace planar_chain
