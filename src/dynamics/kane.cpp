#include "planar_chain/kane.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>
#include <string>

#include "dynamics/entered.h"
#include "effects/effect_kind.h"

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

/// S_i0 = [[c, s], [−s, c]]
Matrix2d rotationMatrix(double theta) {
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  return (Matrix2d() << c, s, -s, c).finished();
}

/// [ω^i] = [[0, ω_i], [−ω_i, 0]]
Matrix2d angularVelocityMatrix(double omega) {
  return (Matrix2d() << 0, omega, -omega, 0).finished();
}

/// Adds rotors, the base, and the torques of drives and friction.
void addCouplings(Entered& entered, ActiveForces& active) {
  const Chain& chain = entered.mechanism.chain();
  VectorXd tau(chain.size());
  entered.motion.torques(entered.t, entered.y.data(), tau.data());
  active.tau += tau;
  active.rotors.resize(chain.size());
  for (int i = 0; i < chain.size(); ++i) active.rotors[i] = inertiaIn(chain.joints()[index(i)]);
  const Couplings& now = entered.motion.evaluator().couplings();
  active.acceleration = now.pinAcceleration();
  active.angle = now.angle.value;
  active.rate = now.angle.rate;
  active.turning = now.angle.acceleration;
}

/// S_r = [−r_y, r_x]: the row of k̂ × r
RowVector2d crossRow(Vec2d r) {
  return {-r.y, r.x};
}

}  // namespace

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

  // Springs, dampers, stops, loads: each writes its own as on paper.
  for (const EffectKind* kind : effectKinds())
    kind->addDense(scene, t, q, qd, {active.F, active.M, active.tau});
  Entered entered(scene, t, q, qd);
  if (!entered.effects.couplers().empty()) addCouplings(entered, active);
  return active;
}

Kane kane(const Chain& chain, const VectorXd& q, const VectorXd& qd, const ActiveForces& active) {
  const int n = chain.size();
  requireSize("q", q, n);
  requireSize("qd", qd, n);
  requireSize("F", active.F, 2 * n);
  requireSize("M", active.M, n);
  requireSize("tau", active.tau, n);
  const VectorXd &F = active.F, &M = active.M, &tau = active.tau;

  Kane k;
  k.q = q;
  k.qd = qd;

  // T_ωq:  [θ_1 … θ_n] = qᵀ T,  [ω_1 … ω_n] = q̇ᵀ T
  k.T = MatrixXd::Ones(n, n).triangularView<Eigen::Upper>();
  const RowVectorXd theta = (q.transpose() * k.T).array() + active.angle;
  const RowVectorXd omega = (qd.transpose() * k.T).array() + active.rate;

  // The rotation matrices S_i0 and the angular velocity matrices [ω^i]
  for (int i = 0; i < n; ++i) {
    k.S.push_back(rotationMatrix(theta(i)));
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
  if (active.rotors.size() > 0) k.M_q.diagonal() += active.rotors;

  // The base: accelerations with q̈ = 0, but for those of A_1.
  VectorXd ofBase = active.rate * C.colwise().sum() + active.turning * B.colwise().sum();
  for (int i = 0; i < n; ++i)
    ofBase.segment<2>(2 * i) += Eigen::Vector2d(active.acceleration.x, active.acceleration.y);
  k.f -= k.V_pd * m.cwiseProduct(ofBase) + active.turning * (k.W_pd * I);
  k.qdd = k.M_q.ldlt().solve(k.f);
  return k;
}

VectorXd inverseDynamics(const Scene& scene, double t, const VectorXd& q, const VectorXd& qd,
                         const VectorXd& qdd) {
  requireSize("q", q, scene.chain.size());
  requireSize("qd", qd, scene.chain.size());
  requireSize("qdd", qdd, scene.chain.size());
  Entered entered(scene, t, q, qd);
  const int n = scene.chain.size();
  const Evaluation& at = entered.evaluation();

  // Without the friction that was found: it follows the motion that is asked for.
  VectorXd found = VectorXd::Zero(n), tau(n);
  for (const auto& effect : entered.effects.all()) {
    if (effect->coupler()) effect->addTorques(at.state(), found.data());
  }
  entered.motion.evaluator().invert(at, found.data(), qdd.data(), tau.data());
  for (int i = 0; i < n; ++i) {
    const Joint& joint = scene.chain.joints()[index(i)];
    const double way = qd[i] != 0 ? qd[i] : qdd[i];
    tau[i] += inertiaIn(joint) * qdd[i] + dryFrictionIn(joint) * ((way > 0) - (way < 0));
  }
  return tau;
}

}  // namespace planar_chain
