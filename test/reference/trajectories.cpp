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
/// Reads a scene as bare numbers (written by trajectories.py); writes q and q̇ at the end, the difference
/// to a second run of other order and other steps, and what rounding the scene to double changes.

#include <quadmath.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "extrapolation.h"

namespace {

using Quad = __float128;

Quad cosine(Quad x) {
  return cosq(x);
}
Quad sine(Quad x) {
  return sinq(x);
}
Quad root(Quad x) {
  return sqrtq(x);
}
long double cosine(long double x) {
  return std::cos(x);
}
long double sine(long double x) {
  return std::sin(x);
}
long double root(long double x) {
  return std::sqrt(x);
}

// ---- The scene -----------------------------------------------------------------------------------

template <class Real>
struct Vec {
  Real x{}, y{};
};

template <class Real>
Real dot(Vec<Real> a, Vec<Real> b) {
  return a.x * b.x + a.y * b.y;
}
/// i a
template <class Real>
Vec<Real> turned(Vec<Real> a) {
  return {-a.y, a.x};
}
/// exp(i θ) a
template <class Real>
Vec<Real> rotated(Vec<Real> z, Vec<Real> a) {
  return {z.x * a.x - z.y * a.y, z.y * a.x + z.x * a.y};
}

template <class Real>
struct Body {
  Real m, I;
  Vec<Real> r, p;
  Real k, d, q0;  // of the joint at the inner pin
};

template <class Real>
struct Load {
  int link;  // −1: none
  Vec<Real> force, point;
  Real moment;
  int joint;  // −1: none
  Real torque;
  double start, stop;
  std::string law;                // constant, sine, ramp
  std::vector<Real> numbers;      // frequency, phase; or the values at the corners
  std::vector<double> cornersAt;  // of a ramp
};

template <class Real>
struct Scene {
  Vec<Real> g;
  std::vector<Body<Real>> bodies;
  std::vector<Load<Real>> loads;
  std::vector<Real> y;  // q, q̇ at the start
  double end;
};

template <class Real>
Real number() {
  double value = 0;
  if (!(std::cin >> value)) throw std::runtime_error("number expected");
  return Real(value);
}
template <class Real>
Vec<Real> vec() {
  const Real x = number<Real>();
  return {x, number<Real>()};
}

template <class Real>
Scene<Real> readScene() {
  Scene<Real> scene;
  scene.g = vec<Real>();
  scene.end = number<double>();
  const int n = number<int>();
  scene.y.resize(2 * n);
  for (int i = 0; i < n; ++i) {
    Body<Real> b;
    b.m = number<Real>(), b.I = number<Real>(), b.r = vec<Real>(), b.p = vec<Real>();
    b.k = number<Real>(), b.d = number<Real>(), b.q0 = number<Real>();
    scene.y[i] = number<Real>(), scene.y[n + i] = number<Real>();
    scene.bodies.push_back(b);
  }
  const int loads = number<int>();
  for (int l = 0; l < loads; ++l) {
    Load<Real> load;
    load.link = number<int>(), load.force = vec<Real>(), load.point = vec<Real>();
    load.moment = number<Real>(), load.joint = number<int>(), load.torque = number<Real>();
    load.start = number<double>(), load.stop = number<double>();
    std::cin >> load.law;
    if (load.law == "sine") load.numbers = {number<Real>(), number<Real>()};
    const int corners = load.law == "ramp" ? number<int>() : 0;
    for (int c = 0; c < corners; ++c) {
      load.cornersAt.push_back(number<double>());
      load.numbers.push_back(number<Real>());
    }
    scene.loads.push_back(load);
  }
  return scene;
}

// ---- The equations -------------------------------------------------------------------------------

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
      if (now_ < load.start || now_ >= load.stop) continue;
      const Real c = factor(load, t);
      const int l = load.link;
      if (l >= 0) {
        for (int j = 0; j < l; ++j) Q[j] += c * dot(load.force, turned(P_[j]));
        Q[l] += c * dot(load.force, turned(rotated(z_[l], load.point))) + c * load.moment;
      }
      if (load.joint >= 0) addJoint(load.joint, c * load.torque, Q);
    }
  }

  Real factor(const Load<Real>& load, Real t) const {
    if (load.law == "sine") {
      const Real twoPi = Real(8 * atanq(1));
      return sine(twoPi * load.numbers[0] * t + load.numbers[1]);
    }
    if (load.law == "ramp") {
      const auto& at = load.cornersAt;
      const std::size_t k = std::size_t(std::upper_bound(at.begin(), at.end(), now_) - at.begin());
      if (k == 0) return load.numbers.front();
      if (k == at.size()) return load.numbers.back();
      const Real t0 = Real(at[k - 1]), t1 = Real(at[k]);
      return load.numbers[k - 1] + (load.numbers[k] - load.numbers[k - 1]) * (t - t0) / (t1 - t0);
    }
    return 1;
  }

  /// M x = b by Cholesky's method, in place; only M's lower triangle is set.
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

// ---- A run ----------------------------------------------------------------------------------------

/// Relative [q, q̇] at the scene's end.
template <class Real>
std::vector<Real> run(const Scene<Real>& scene, int columns, double tolerance) {
  const std::size_t n = scene.bodies.size();
  std::vector<Real> y = scene.y;
  for (std::size_t i = 1; i < n; ++i) {
    y[i] += y[i - 1];
    y[n + i] += y[n + i - 1];
  }

  std::vector<double> landings{0, scene.end};
  for (const Load<Real>& load : scene.loads) {
    landings.push_back(load.start);
    landings.push_back(load.stop);
    landings.insert(landings.end(), load.cornersAt.begin(), load.cornersAt.end());
  }
  std::sort(landings.begin(), landings.end());

  Lagrange<Real> f(scene);
  for (std::size_t k = 1; k < landings.size(); ++k) {
    const double from = landings[k - 1], to = landings[k];
    if (from < 0 || to > scene.end || from == to) continue;
    f.enter(from + (to - from) / 2);
    Extrapolation<Real, Lagrange<Real>>(f, columns, tolerance).integrate(from, to, y);
  }

  for (std::size_t i = n - 1; i > 0; --i) {
    y[i] -= y[i - 1];
    y[n + i] -= y[n + i - 1];
  }
  return y;
}

// ---- What double allows --------------------------------------------------------------------------

Scene<long double> narrowed(const Scene<Quad>& s) {
  const auto vec = [](Vec<Quad> a) { return Vec<long double>{(long double)a.x, (long double)a.y}; };
  const auto list = [](const std::vector<Quad>& a) { return std::vector<long double>(a.begin(), a.end()); };
  Scene<long double> result{vec(s.g), {}, {}, list(s.y), s.end};
  for (const auto& b : s.bodies) {
    result.bodies.push_back({(long double)b.m, (long double)b.I, vec(b.r), vec(b.p), (long double)b.k,
                             (long double)b.d, (long double)b.q0});
  }
  for (const auto& l : s.loads) {
    result.loads.push_back({l.link, vec(l.force), vec(l.point), (long double)l.moment, l.joint,
                            (long double)l.torque, l.start, l.stop, l.law, list(l.numbers), l.cornersAt});
  }
  return result;
}

/// The largest change of [q, q̇] over some draws when every parameter is off by a relative ±2^-53 and every
/// initial value by ±2^-53 max(1, |value|): taken 2^20 times as large and scaled back.
std::vector<double> changeByRounding(const Scene<Quad>& scene, int draws) {
  const double enlarged = 0x1p-33, scaleBack = 0x1p-20;
  const Scene<long double> exact = narrowed(scene);
  const std::vector<long double> y = run(exact, 8, 1e-14);
  std::vector<double> change(y.size(), 0);
  std::mt19937 random(1);
  const auto sign = [&] { return random() % 2 ? enlarged : -enlarged; };
  for (int draw = 0; draw < draws; ++draw) {
    Scene<long double> other = exact;
    const auto disturb = [&](long double& x) { x *= 1 + sign(); };
    const auto disturbVec = [&](Vec<long double>& a) { disturb(a.x), disturb(a.y); };
    disturbVec(other.g);
    for (auto& b : other.bodies) {
      disturb(b.m), disturb(b.I), disturbVec(b.r), disturbVec(b.p);
      disturb(b.k), disturb(b.d), disturb(b.q0);
    }
    for (auto& l : other.loads) {
      disturbVec(l.force), disturbVec(l.point), disturb(l.moment), disturb(l.torque);
    }
    for (auto& value : other.y) value += sign() * std::max(1.0L, magnitude(value));
    const std::vector<long double> disturbed = run(other, 8, 1e-14);
    for (std::size_t i = 0; i < y.size(); ++i) {
      change[i] = std::max(change[i], scaleBack * double(magnitude(disturbed[i] - y[i])));
    }
  }
  return change;
}

}  // namespace

int main() {
  const Scene<Quad> scene = readScene<Quad>();
  const std::vector<Quad> y = run(scene, 12, 1e-28);
  const std::vector<Quad> other = run(scene, 9, 1e-26);
  const std::vector<double> change = changeByRounding(scene, 8);
  for (std::size_t i = 0; i < y.size(); ++i) {
    char text[64];
    quadmath_snprintf(text, sizeof text, "%.20Qg", y[i]);
    std::printf("%s %.2e %.2e\n", text, double(magnitude(y[i] - other[i])), change[i]);
  }
}
