#include "planar_chain/kane.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <stdexcept>
#include <string>

#include "dynamics/scene_snapshot.h"
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
void addCouplings(SceneSnapshot& snapshot, ActiveForces& active) {
  const Chain& chain = snapshot.mechanism.chain();
  VectorXd tau(chain.size());
  snapshot.motion.torques(snapshot.t, snapshot.y.data(), tau.data());
  active.tau += tau;
  active.rotors.resize(chain.size());
  for (int i = 0; i < chain.size(); ++i) active.rotors[i] = inertiaIn(chain.joints()[index(i)]);
  const Couplings& now = snapshot.motion.couplings(snapshot.t);
  active.acceleration = now.pinAcceleration();
  active.angle = now.angle.value;
  active.rate = now.angle.rate;
  active.turning = now.angle.acceleration;
  active.tipRows.resize(now.tip.rows, 2);
  for (int j = 0; j < now.tip.rows; ++j)
    active.tipRows.row(j) << now.tip.row[index(j)].x, now.tip.row[index(j)].y;
  active.tipAcceleration = now.tip.acceleration;
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
  SceneSnapshot snapshot(scene, t, q, qd);
  if (!snapshot.effects.jointConstraints().empty()) addCouplings(snapshot, active);
  return active;
}

namespace {

/// q_i d_i of a prismatic joint, body axes.
Vec2d displacementOf(const Chain& chain, const Kane& k, int i) {
  const Joint& joint = chain.joints()[index(i)];
  return joint.isPrismatic ? k.q[i] * joint.axis : Vec2d{};
}

/// B and C: row i holds body i's own centre of mass, then its outer pin, which carries all that follows.
struct Blocks {
  MatrixXd B, C;

  Blocks(const Chain& chain, const Kane& k)
      : B(MatrixXd::Zero(chain.size(), 2 * chain.size())), C(MatrixXd::Zero(B.rows(), B.cols())) {
    for (int i = 0; i < chain.size(); ++i) {
      const Link& link = chain.links()[index(i)];
      const Vec2d displacement = displacementOf(chain, k, i);
      const RowVector2d S_r = crossRow(displacement + link.com);
      const RowVector2d S_p = crossRow(displacement + link.pin);
      B.block<1, 2>(i, 2 * i) = S_r * k.S[i];
      C.block<1, 2>(i, 2 * i) = S_r * k.omega[i] * k.S[i];
      for (int j = i + 1; j < chain.size(); ++j) {
        B.block<1, 2>(i, 2 * j) = S_p * k.S[i];
        C.block<1, 2>(i, 2 * j) = S_p * k.omega[i] * k.S[i];
      }
    }
  }
};

/// d_i of a prismatic joint, in ground components.
Eigen::Vector2d axisOf(const Chain& chain, const Kane& k, int i) {
  const Vec2d d = chain.joints()[index(i)].axis;
  return (RowVector2d(d.x, d.y) * k.S[index(i)]).transpose();
}

/// The Coriolis acceleration of a prismatic joint, 2 ω q̇ k̂×d; 0 for a revolute one.
Eigen::Vector2d coriolisOf(const Chain& chain, const Kane& k, const RowVectorXd& omega, int i) {
  if (!chain.joints()[index(i)].isPrismatic) return Eigen::Vector2d::Zero();
  const Eigen::Vector2d d = axisOf(chain, k, i);
  return 2 * omega(i) * k.qd[i] * Eigen::Vector2d(-d.y(), d.x());
}

/// The accelerations with q̈ = 0, but for those of A_1: of a base that moves, and of Coriolis.
VectorXd ofBase(const Chain& chain, const Kane& k, const ActiveForces& active, const RowVectorXd& omega,
                const MatrixXd& B, const MatrixXd& C) {
  VectorXd a = active.rate * C.colwise().sum() + active.turning * B.colwise().sum();
  Eigen::Vector2d ofAll(active.acceleration.x, active.acceleration.y);
  for (int i = 0; i < chain.size(); ++i) {
    ofAll += coriolisOf(chain, k, omega, i);
    a.segment<2>(2 * i) += ofAll;
  }
  return a;
}

/// J_c, c, φ, and what φ adds to q̈. inverse: M_q⁻¹. T, S and q̈ without φ are known.
void takeTip(const Chain& chain, const ActiveForces& active, const RowVectorXd& omega,
             const MatrixXd& inverse, Kane& k) {
  const int n = chain.size();
  MatrixXd J = MatrixXd::Zero(2, n);
  Eigen::Vector2d rest(active.acceleration.x, active.acceleration.y), turned = Eigen::Vector2d::Zero();
  for (int j = n - 1; j >= 0; --j) {
    const Vec2d p = displacementOf(chain, k, j) + chain.links()[index(j)].pin;
    const Eigen::Vector2d arm = (RowVector2d(p.x, p.y) * k.S[index(j)]).transpose();
    const Eigen::Vector2d own(-arm.y(), arm.x());
    turned += own;
    rest += active.turning * own - omega(j) * omega(j) * arm + coriolisOf(chain, k, omega, j);
    J.col(j) = chain.joints()[index(j)].isPrismatic ? axisOf(chain, k, j) : turned;
  }
  k.J_c = active.tipRows * J;
  k.c = active.tipRows * (Eigen::Vector2d(active.tipAcceleration.x, active.tipAcceleration.y) - rest);
  const MatrixXd under = inverse * k.J_c.transpose();
  k.phi = (k.J_c * under).completeOrthogonalDecomposition().solve(k.c - k.J_c * k.qdd);
  k.qdd += under * k.phi;
}

}  // namespace

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
  k.T = MatrixXd::Zero(n, n);
  k.T.triangularView<Eigen::Upper>().setOnes();
  for (int i = 0; i < n; ++i) {
    if (chain.joints()[index(i)].isPrismatic) k.T.row(i).setZero();
  }
  const RowVectorXd theta = (q.transpose() * k.T).array() + active.angle;
  const RowVectorXd omega = (qd.transpose() * k.T).array() + active.rate;

  // The rotation matrices S_i0 and the angular velocity matrices [ω^i]
  for (int i = 0; i < n; ++i) {
    k.S.push_back(rotationMatrix(theta(i)));
    k.omega.push_back(angularVelocityMatrix(omega(i)));
  }

  // Partial velocities, those of prismatic joints along their axes
  const auto [B, C] = Blocks(chain, k);
  k.V_pd = k.T * B;
  for (int i = 0; i < n; ++i) {
    if (!chain.joints()[index(i)].isPrismatic) continue;
    for (int j = i; j < n; ++j) k.V_pd.block<1, 2>(i, 2 * j) += axisOf(chain, k, i).transpose();
  }
  k.W_pd = k.T;

  // Inertia: A_1, A_2, A_3
  VectorXd m(2 * n);
  VectorXd I(n);
  for (int i = 0; i < n; ++i) {
    m.segment<2>(2 * i).setConstant(chain.links()[i].mass);
    I(i) = chain.links()[i].inertia;
  }
  k.A_1 = k.T * C * m.asDiagonal();
  k.A_2 = k.V_pd * m.asDiagonal();
  k.A_3 = k.T * I.asDiagonal();

  // Kane: V_pd (F + F_in) + W_pd (M + M_in) + τ = 0
  k.f_ext = k.V_pd * F + k.W_pd * M + tau;
  k.f = k.f_ext - k.V_pd * k.A_1.transpose() * qd;
  k.M_q = k.V_pd * k.A_2.transpose() + k.W_pd * k.A_3.transpose();
  if (active.rotors.size() > 0) k.M_q.diagonal() += active.rotors;

  k.f -= k.V_pd * m.cwiseProduct(ofBase(chain, k, active, omega, B, C)) + active.turning * (k.W_pd * I);
  const auto inverse = k.M_q.ldlt();
  k.qdd = inverse.solve(k.f);
  if (active.tipRows.rows() > 0) takeTip(chain, active, omega, inverse.solve(MatrixXd::Identity(n, n)), k);
  return k;
}

namespace {

/// Takes from the torques what the force on the tip can do: the smallest are left.
void leaveToTip(const Scene& scene, double t, const VectorXd& q, const VectorXd& qd, const VectorXd& qdd,
                VectorXd& tau) {
  constexpr double exact = 1e-6;  // of the accelerations: as a user writes them
  const Kane k = kane(scene.chain, q, qd, activeForces(scene, t, q, qd));
  const double missing = (k.J_c * qdd - k.c).norm(), size = 1 + k.c.norm() + (k.J_c * qdd).norm();
  if (!(missing <= exact * size)) {
    throw Refused({{"qdd", "accelerations with which the tip stays where it is held",
                    toText(missing) + " m/s² of the tip more"}});
  }
  tau -= k.J_c.transpose() * k.J_c.transpose().completeOrthogonalDecomposition().solve(tau);
}

}  // namespace

VectorXd inverseDynamics(const Scene& scene, double t, const VectorXd& q, const VectorXd& qd,
                         const VectorXd& qdd) {
  requireSize("q", q, scene.chain.size());
  requireSize("qd", qd, scene.chain.size());
  requireSize("qdd", qdd, scene.chain.size());
  SceneSnapshot snapshot(scene, t, q, qd);
  const int n = scene.chain.size();
  const Evaluation& at = snapshot.evaluation();

  // Without the friction that was found: it follows the motion that is asked for.
  VectorXd found = VectorXd::Zero(n), tau(n);
  for (const auto& effect : snapshot.effects.all()) {
    if (effect->jointConstraint()) effect->addTorques(at.state(), found.data());
  }
  snapshot.motion.evaluator().invert(at, found.data(), qdd.data(), tau.data());
  for (int i = 0; i < n; ++i) {
    const Joint& joint = scene.chain.joints()[index(i)];
    const double way = qd[i] != 0 ? qd[i] : qdd[i];
    tau[i] += inertiaIn(joint) * qdd[i] + dryFrictionIn(joint) * ((way > 0) - (way < 0));
  }
  if (scene.tip) leaveToTip(scene, t, q, qd, qdd, tau);
  return tau;
}

}  // namespace planar_chain
