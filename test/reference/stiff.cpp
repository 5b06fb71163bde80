/// Reference trajectories of stiff chains in quadruple precision, apart from the program and, but for the
/// reading of scenes, from trajectories.cpp: an implicit method, and equations from pins instead of a mass
/// matrix in closed form.
///
/// Let V_ij = ∂x_i/∂θ_j, of the centres of mass x_i, in absolute angles. From Lagrange's equations
///
///     Σ_i m_i V_ij·(Σ_k V_ik α_k − Σ_k ω_k² i⁻¹V_ik − g) + I_j α_j = N_j,    i⁻¹V_ik = the arm of k in x_i
///
/// with the springs' and dampers' torques N. Reads one scene as bare numbers (written by stiff.py, no loads);
/// writes q and q̇ at the end and the difference to a second run of other order and tolerance.

#include <cstdio>
#include <iostream>

#include "collocation.h"

namespace {

using Quad = __float128;

struct Body {
  Quad m, I, r[2], p[2], k, d, q0;
};

struct Scene {
  Quad g[2], end;
  std::vector<Body> bodies;
  std::vector<Quad> y;  // θ, ω at the start, absolute
};

Quad number() {
  double value = 0;
  if (!(std::cin >> value)) throw std::runtime_error("number expected");
  return value;
}

Scene readScene() {
  Scene scene{};
  scene.g[0] = number(), scene.g[1] = number(), scene.end = number();
  const int n = int(number());
  scene.y.resize(2 * n);
  for (int i = 0; i < n; ++i) {
    Body b{};
    b.m = number(), b.I = number();
    for (Quad* value : {&b.r[0], &b.r[1], &b.p[0], &b.p[1], &b.k, &b.d, &b.q0}) *value = number();
    for (const int k : {i, n + i}) scene.y[k] = number() + (i > 0 ? scene.y[k - 1] : 0);
    scene.bodies.push_back(b);
  }
  if (number() != 0) throw std::runtime_error("loads are not known here");
  return scene;
}

class Chain {
 public:
  explicit Chain(const Scene& scene) : s_(scene), n_(int(scene.bodies.size())) {}

  void operator()(const std::vector<Quad>& y, std::vector<Quad>& dydt) const {
    const Quad *theta = y.data(), *omega = theta + n_;
    std::vector<Quad> rhs(n_, Quad(0));
    Elimination<Quad>::Matrix M(n_, std::vector<Quad>(n_, Quad(0)));
    for (int i = 0; i < n_; ++i) {
      const Body& b = s_.bodies[i];
      M[i][i] += b.I;
      addJoint(i, theta, omega, rhs);
      // arm[k] = p_k exp(i θ_k), and r_i exp(i θ_i) for the last
      std::vector<Quad> x(i + 1), z(i + 1);
      Quad pull[2] = {s_.g[0], s_.g[1]};
      for (int k = 0; k <= i; ++k) {
        const Quad* a = k < i ? s_.bodies[k].p : b.r;
        const Quad c = cosq(theta[k]), s = sinq(theta[k]);
        x[k] = c * a[0] - s * a[1];
        z[k] = s * a[0] + c * a[1];
        pull[0] += omega[k] * omega[k] * x[k];
        pull[1] += omega[k] * omega[k] * z[k];
      }
      for (int j = 0; j <= i; ++j) {
        rhs[j] += b.m * (x[j] * pull[1] - z[j] * pull[0]);
        for (int k = 0; k <= i; ++k) M[j][k] += b.m * (x[j] * x[k] + z[j] * z[k]);
      }
    }
    Elimination<Quad>(M).solve(rhs);
    for (int j = 0; j < n_; ++j) dydt[j] = omega[j], dydt[n_ + j] = rhs[j];
  }

 private:
  void addJoint(int j, const Quad* theta, const Quad* omega, std::vector<Quad>& N) const {
    const Body& b = s_.bodies[j];
    const Quad q = j > 0 ? theta[j] - theta[j - 1] : theta[0];
    const Quad qd = j > 0 ? omega[j] - omega[j - 1] : omega[0];
    const Quad torque = -b.k * (q - b.q0) - b.d * qd;
    N[j] += torque;
    if (j > 0) N[j - 1] -= torque;
  }

  const Scene& s_;
  int n_;
};

/// Relative [q, q̇] at the end.
std::vector<Quad> run(const Scene& scene, int stages, double tolerance) {
  Chain f(scene);
  std::vector<Quad> y = scene.y;
  Radau<Chain>(f, stages, tolerance).integrate(scene.end, y);
  const int n = int(scene.bodies.size());
  for (int i = n - 1; i > 0; --i) y[i] -= y[i - 1], y[n + i] -= y[n + i - 1];
  return y;
}

}  // namespace

int main() {
  const Scene scene = readScene();
  const std::vector<Quad> y = run(scene, 9, 1e-18), other = run(scene, 7, 1e-17);
  for (std::size_t i = 0; i < y.size(); ++i) {
    char text[64];
    quadmath_snprintf(text, sizeof text, "%.20Qg", y[i]);
    std::printf("%s %.2e\n", text, double(fabsq(y[i] - other[i])));
  }
}
