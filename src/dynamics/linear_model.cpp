#include "planar_chain/linear_model.h"

#include <complex>
#include <stdexcept>
#include <vector>

#include "effects/effects.h"
#include "recursion/articulated.h"

namespace planar_chain {

namespace {

using Eigen::VectorXd;

/// One state, and what acts there.
struct At {
  int n;
  VectorXd y;  ///< θ, ω
  std::vector<Rotation<double>> e;
  VectorXd N, k, d, XF;  ///< moments about the inner pins; k, d of the joints; Σ X·F of the bodies
  std::vector<Vec2d> F;

  At(const Scene& scene, double t, const VectorXd& q, const VectorXd& qd)
      : n(scene.chain.size()),
        y(2 * n),
        N(VectorXd::Zero(n)),
        k(VectorXd::Zero(n)),
        d(VectorXd::Zero(n)),
        XF(VectorXd::Zero(n)),
        F(index(n)) {
    toAbsolute(q.data(), n, y.data());
    toAbsolute(qd.data(), n, y.data() + n);
    for (int i = 0; i < n; ++i) e.push_back(Rotation<double>::of(y[i]));

    const std::vector<Vec2d> pinVelocity(index(n));  // for the power, which nobody reads
    const ChainState at{t, y.data(), y.data() + n, e.data(), pinVelocity.data()};
    Effects effects(scene, nullptr);
    effects.enter(t);
    effects.enterState(t, y.data());
    for (Effect* effect : effects.active()) {
      effect->apply(at, {N.data(), F.data()});
      effect->addStiffness(k.data(), d.data());
      effect->addTangents(at, k.data(), d.data());
      effect->addForceStiffness(at, XF.data());
    }
  }
};

/// A number and its slope along one direction, by a complex step: f(x + i h x') = f(x) + i h f'(x) x'. With h
/// this small, terms with h² vanish in the rounding. Source: W. Squire, G. Trapp, Using complex variables to
/// estimate derivatives of real functions, SIAM Rev. 40 (1998) 110–112.
using Moving = std::complex<double>;
constexpr double h = 0x1p-300;
Moving moving(double value, double slope) {
  return {value, slope * h};
}
double slopeOf(Moving number) {
  return number.imag() / h;
}

}  // namespace

LinearModel linearModel(const Scene& scene, double t, const VectorXd& q, const VectorXd& qd) {
  const int n = scene.chain.size();
  if (q.size() != n || qd.size() != n) {
    throw std::invalid_argument("q and qd must have one value a joint");
  }
  const At at(scene, t, q, qd);
  const Vec2d g = scene.chain.gravity();
  Articulated<Moving> recursion(scene.chain);
  std::vector<Rotation<Moving>> e(index(n));
  std::vector<Moving> omega(index(n)), N(index(n)), alpha(index(n));
  std::vector<Vec2<Moving>> F;
  for (const Vec2d force : at.F) F.push_back({force.x, force.y});

  // δq̈ while joint j, with all that hangs on it, turns by `turn`, speeds up by `speed`, and has `torque`
  // more.
  const auto along = [&](int j, double turn, double speed, double torque) {
    for (int i = 0; i < n; ++i) {
      const double hangs = i >= j ? 1 : 0;
      const auto [c, s] = at.e[index(i)];
      e[index(i)] = {moving(c, -s * hangs * turn), moving(s, c * hangs * turn)};
      omega[index(i)] = moving(at.y[n + i], hangs * speed);
      N[index(i)] = moving(at.N[i], -at.XF[i] * hangs * turn);
    }
    N[index(j)] += moving(0, torque);
    if (j > 0) N[index(j - 1)] -= moving(0, torque);
    recursion.accelerations(e.data(), omega.data(), N.data(), F.data(), {-g.x, -g.y}, alpha.data());
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
