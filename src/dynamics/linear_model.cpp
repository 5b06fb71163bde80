#include "planar_chain/linear_model.h"

#include <stdexcept>
#include <vector>

#include "effects/effects.h"
#include "recursion/articulated.h"
#include "recursion/dual.h"

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
    effects.enterState(y.data());
    for (Effect* effect : effects.active()) effect->apply(at, {N.data(), F.data()});
    effects.findStiffness(k.data(), d.data());
    effects.addTangents(at, k.data(), d.data());
    effects.addForceStiffness(at, XF.data());
  }
};

/// δq̈ while joint j, with all that hangs on it, turns by `turn`, speeds up by `speed`, and has `torque` more.
class Columns {
 public:
  Columns(const Chain& chain, const At& at)
      : at_(at),
        recursion_(chain),
        ground_{-chain.gravity().x, -chain.gravity().y},
        e_(index(at.n)),
        omega_(index(at.n)),
        N_(index(at.n)),
        alpha_(index(at.n)) {
    for (const Vec2d force : at.F) F_.push_back({force.x, force.y});
  }

  VectorXd along(int j, double turn, double speed, double torque) {
    for (int i = 0; i < at_.n; ++i) {
      const double hangs = i >= j ? 1 : 0;
      e_[index(i)] = turning(at_.e[index(i)], hangs * turn);
      omega_[index(i)] = {at_.y[at_.n + i], hangs * speed};
      N_[index(i)] = {at_.N[i], -at_.XF[i] * hangs * turn};
    }
    N_[index(j)] += Dual(0, torque);
    if (j > 0) N_[index(j - 1)] -= Dual(0, torque);

    recursion_.accelerations(e_.data(), omega_.data(), N_.data(), F_.data(), ground_, alpha_.data());
    VectorXd change(at_.n);
    for (int i = 0; i < at_.n; ++i) {
      change[i] = alpha_[index(i)].slope - (i > 0 ? alpha_[index(i - 1)].slope : 0);
    }
    return change;
  }

 private:
  const At& at_;
  Articulated<Dual> recursion_;
  Vec2<Dual> ground_;
  std::vector<Rotation<Dual>> e_;
  std::vector<Dual> omega_, N_, alpha_;
  std::vector<Vec2<Dual>> F_;
};

}  // namespace

LinearModel linearModel(const Scene& scene, double t, const VectorXd& q, const VectorXd& qd) {
  const int n = scene.chain.size();
  if (q.size() != n || qd.size() != n) {
    throw std::invalid_argument("q and qd must have one value a joint");
  }
  const At at(scene, t, q, qd);
  Columns columns(scene.chain, at);
  LinearModel model{Eigen::MatrixXd::Zero(2 * n, 2 * n), Eigen::MatrixXd::Zero(2 * n, n)};
  model.A.topRightCorner(n, n).setIdentity();
  for (int j = 0; j < n; ++j) {
    model.A.col(j).tail(n) = columns.along(j, 1, 0, -at.k[j]);
    model.A.col(n + j).tail(n) = columns.along(j, 0, 1, -at.d[j]);
    model.B.col(j).tail(n) = columns.along(j, 0, 0, 1);
  }
  return model;
}

}  // namespace planar_chain
