/// Reference trajectories in quadruple precision (113 bits, 34 digits), apart from the program: its own
/// equations, its own solver, its own integrator, not one of the program's headers.
///
/// Equations: Lagrange's in ABSOLUTE angles. With z_k = exp(i θ_k), the outer pin P_k = p_k z_k and
/// U_k = μ_k z_k, μ_k = m_k r_k + (Σ_{i>k} m_i) p_k, the kinetic energy is ½ Σ M_jk ω_j ω_k with
///
///     M_jk = P_j·U_k  (j < k)        M_jj = I_j + m_j |r_j|² + (Σ_{i>j} m_i) |p_j|²
///
/// and since M_jk depends on θ_k − θ_j alone, d/dt ∂T/∂ω_j − ∂T/∂θ_j = Q_j is
///
///     Σ_k M_jk α_k + Σ_k (∂M_jk/∂θ_k) ω_k² = Q_j,    Q_j from virtual work, gravity g·(i U_j)
///
/// solved by Cholesky's method. Integration: Gragg's modified midpoint rule, extrapolated (Hairer, Nørsett,
/// Wanner I, II.9), with step control, landing on every start, stop and corner of the loads.
///
/// Reads a scene as bare numbers (written by trajectories.py); writes q and q̇, as trajectory.h says.

#include "trajectory.h"

namespace {

/// y = [θ, ω], absolute.
template <class Real>
class Lagrange {
 public:
  explicit Lagrange(const Scene<Real>& scene) : s_(scene), n_(int(scene.bodies.size())) {
    M_.assign(n_, std::vector<Real>(n_));
    mu_.resize(n_), P_.resize(n_), U_.resize(n_), z_.resize(n_), own_.resize(n_);
    Real outside = 0;  // Σ_{i>k} m_i
    for (int k = n_ - 1; k >= 0; --k) {
      const Body<Real>& b = s_.bodies[k];
      mu_[k] = {b.m * b.r.x + outside * b.p.x, b.m * b.r.y + outside * b.p.y};
      own_[k] = b.I + b.m * dot(b.r, b.r) + outside * dot(b.p, b.p);
      outside += b.m;
    }
  }

  /// From now on the loads act as they do around time t, between two of their starts, stops and corners.
  void enter(double t) { now_ = t; }

  void operator()(Real t, const std::vector<Real>& y, std::vector<Real>& dydt) {
    const Real* theta = y.data();
    const Real* omega = y.data() + n_;
    for (int k = 0; k < n_; ++k) {
      z_[k] = {cosine(theta[k]), sine(theta[k])};
      P_[k] = rotated(z_[k], s_.bodies[k].p);
      U_[k] = rotated(z_[k], mu_[k]);
    }

    // Right-hand side: Q_j − Σ_k (∂M_jk/∂θ_k) ω_k²
    std::vector<Real> rhs(n_, Real(0));
    for (int j = 0; j < n_; ++j) rhs[j] = dot(s_.g, turned(U_[j]));
    addJoints(theta, omega, rhs);
    addLoads(t, rhs);
    for (int j = 0; j < n_; ++j) {
      M_[j][j] = own_[j];
      for (int k = j + 1; k < n_; ++k) {
        M_[k][j] = dot(P_[j], U_[k]);
        const Real h = dot(P_[j], turned(U_[k]));  // ∂M_jk/∂θ_k = −∂M_jk/∂θ_j
        rhs[j] -= h * omega[k] * omega[k];
        rhs[k] += h * omega[j] * omega[j];
      }
    }

    solve(rhs);
    for (int j = 0; j < n_; ++j) {
      dydt[j] = omega[j];
      dydt[n_ + j] = rhs[j];
    }
  }

 private:
  void addJoint(int j, Real tau, std::vector<Real>& Q) const {
    Q[j] += tau;
    if (j > 0) Q[j - 1] -= tau;
  }

  void addJoints(const Real* theta, const Real* omega, std::vector<Real>& Q) const {
    for (int j = 0; j < n_; ++j) {
      const Body<Real>& b = s_.bodies[j];
      const Real q = j > 0 ? theta[j] - theta[j - 1] : theta[j];
      const Real qd = j > 0 ? omega[j] - omega[j - 1] : omega[j];
      addJoint(j, -b.k * (q - b.q0) - b.d * qd, Q);
    }
  }

  /// Virtual work of a force at the point x of body l: F·∂X/∂θ_j, X = Σ_{j<l} P_j + x z_l
  void addLoads(Real t, std::vector<Real>& Q) const {
    for (const Load<Real>& load : s_.loads) {
      if (!acts(load, now_)) continue;
      const Real c = factor(load, t, now_);
      const int l = load.link;
      if (l >= 0) {
        for (int j = 0; j < l; ++j) Q[j] += c * dot(load.force, turned(P_[j]));
        Q[l] += c * dot(load.force, turned(rotated(z_[l], load.point))) + c * load.moment;
      }
      if (load.joint >= 0) addJoint(load.joint, c * load.torque, Q);
    }
  }

  void solve(std::vector<Real>& b) {
    for (int j = 0; j < n_; ++j) {
      for (int i = j; i < n_; ++i) {
        Real sum = M_[i][j];
        for (int k = 0; k < j; ++k) sum -= M_[i][k] * M_[j][k];
        M_[i][j] = i == j ? root(sum) : sum / M_[j][j];
      }
    }
    for (int i = 0; i < n_; ++i) {
      for (int k = 0; k < i; ++k) b[i] -= M_[i][k] * b[k];
      b[i] /= M_[i][i];
    }
    for (int i = n_ - 1; i >= 0; --i) {
      for (int k = i + 1; k < n_; ++k) b[i] -= M_[k][i] * b[k];
      b[i] /= M_[i][i];
    }
  }

  const Scene<Real>& s_;
  int n_;
  double now_ = 0;
  std::vector<std::vector<Real>> M_;
  std::vector<Real> own_;
  std::vector<Vec<Real>> mu_, P_, U_, z_;
};

}  // namespace

int main() {
  writeReference<Lagrange, Quad>(true, {{12, 1e-28}, {9, 1e-26}, 8});
}
