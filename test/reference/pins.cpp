/// Reference trajectories of long chains in quadruple precision, apart from the program and from the
/// equations of trajectories.cpp: Newton's and Euler's equations of every body with the forces in the pins as
/// unknowns.
///
/// Body i, with R = exp(i θ) r from its inner pin to the centre of mass, Q = exp(i θ) (p − r) from there to
/// the outer pin, outer force W and moment N about the centre of mass, and f_i, f_i+1 in its pins:
///
///     m a = W + f_i − f_i+1          I α = N − (iR)·f_i − (iQ)·f_i+1
///
/// The outer pin of body i−1 and the inner pin of body i move together; the ground pin stands still:
///
///     a_i − α_i iR_i + ω_i² R_i = a_i−1 + α_i−1 iQ_i−1 − ω_i−1² Q_i−1         (0 for i = 1)
///
/// which is a symmetric block tridiagonal system for f_1 … f_n, solved in O(n). No body may have I = 0.
///
/// Reads a scene as bare numbers (written by report.py); writes absolute θ and ω, as trajectory.h says.

#include "trajectory.h"

namespace {

template <class Real>
struct Matrix {
  Real a{}, b{}, c{}, d{};  // [[a, b], [c, d]]
};
template <class Real>
Matrix<Real> plus(Matrix<Real> A, Real s, Vec<Real> u, Vec<Real> v) {
  return {A.a + s * u.x * v.x, A.b + s * u.x * v.y, A.c + s * u.y * v.x, A.d + s * u.y * v.y};
}
template <class Real>
Vec<Real> times(const Matrix<Real>& A, Vec<Real> x) {
  return {A.a * x.x + A.b * x.y, A.c * x.x + A.d * x.y};
}
template <class Real>
Matrix<Real> times(const Matrix<Real>& A, const Matrix<Real>& B) {
  return {A.a * B.a + A.b * B.c, A.a * B.b + A.b * B.d, A.c * B.a + A.d * B.c, A.c * B.b + A.d * B.d};
}
template <class Real>
Matrix<Real> transposed(const Matrix<Real>& A) {
  return {A.a, A.c, A.b, A.d};
}
template <class Real>
Matrix<Real> inverse(const Matrix<Real>& A) {
  const Real s = 1 / (A.a * A.d - A.b * A.c);
  return {s * A.d, -s * A.b, -s * A.c, s * A.a};
}

/// y = [θ, ω], absolute.
template <class Real>
class Pins {
 public:
  explicit Pins(const Scene<Real>& scene)
      : s_(scene),
        n_(int(scene.bodies.size())),
        R_(n_),
        Q_(n_),
        W_(n_),
        f_(n_ + 1),
        N_(n_),
        w_(n_),
        v_(n_),
        D_(n_),
        upper_(n_) {
    for (int i = 0; i < n_; ++i) w_[i] = 1 / s_.bodies[i].m, v_[i] = 1 / s_.bodies[i].I;
  }

  void enter(double t) { now_ = t; }

  void operator()(Real t, const std::vector<Real>& y, std::vector<Real>& dydt) {
    const Real *theta = y.data(), *omega = theta + n_;
    for (int i = 0; i < n_; ++i) {
      const Body<Real>& b = s_.bodies[i];
      const Vec<Real> e{cosine(theta[i]), sine(theta[i])};
      R_[i] = rotated(e, b.r);
      Q_[i] = rotated(e, Vec<Real>{b.p.x - b.r.x, b.p.y - b.r.y});
      W_[i] = {b.m * s_.g.x, b.m * s_.g.y};
      N_[i] = 0;
    }
    addOuter(t, theta, omega);

    // Rows: what each pin's two sides would do apart, and how its own and the neighbours' forces move them.
    for (int i = 0; i < n_; ++i) {
      const Vec<Real> iR = turned(R_[i]), iQ = turned(Q_[i]);
      const Real ww = omega[i] * omega[i], w = w_[i], v = v_[i];
      D_[i] = plus(Matrix<Real>{w, 0, 0, w}, v, iR, iR);
      f_[i] = {-(W_[i].x * w - iR.x * N_[i] * v + ww * R_[i].x),
               -(W_[i].y * w - iR.y * N_[i] * v + ww * R_[i].y)};
      upper_[i] = plus(Matrix<Real>{-w, 0, 0, -w}, v, iR, iQ);
      if (i == 0) continue;
      const Vec<Real> iQin = turned(Q_[i - 1]);
      const Real wwIn = omega[i - 1] * omega[i - 1], wIn = w_[i - 1], vIn = v_[i - 1];
      D_[i] = plus(Matrix<Real>{D_[i].a + wIn, D_[i].b, D_[i].c, D_[i].d + wIn}, vIn, iQin, iQin);
      f_[i].x += W_[i - 1].x * wIn + iQin.x * N_[i - 1] * vIn - wwIn * Q_[i - 1].x;
      f_[i].y += W_[i - 1].y * wIn + iQin.y * N_[i - 1] * vIn - wwIn * Q_[i - 1].y;
    }

    // Gauss, from the tip inwards, and back; D_ becomes the inverse of what is left of it.
    for (int i = n_ - 1; i > 0; --i) {
      D_[i] = inverse(D_[i]);
      const Matrix<Real> factor = times(upper_[i - 1], D_[i]);
      const Matrix<Real> less = times(factor, transposed(upper_[i - 1]));
      const Vec<Real> shift = times(factor, f_[i]);
      D_[i - 1] = {D_[i - 1].a - less.a, D_[i - 1].b - less.b, D_[i - 1].c - less.c, D_[i - 1].d - less.d};
      f_[i - 1] = {f_[i - 1].x - shift.x, f_[i - 1].y - shift.y};
    }
    D_[0] = inverse(D_[0]);
    f_[n_] = {};
    for (int i = 0; i < n_; ++i) {
      if (i > 0) {
        const Vec<Real> shift = times(transposed(upper_[i - 1]), f_[i - 1]);
        f_[i] = {f_[i].x - shift.x, f_[i].y - shift.y};
      }
      f_[i] = times(D_[i], f_[i]);
    }
    for (int i = 0; i < n_; ++i) {
      dydt[i] = omega[i];
      dydt[n_ + i] = (N_[i] - dot(turned(R_[i]), f_[i]) - dot(turned(Q_[i]), f_[i + 1])) * v_[i];
    }
  }

 private:
  void addJoint(int j, Real tau) {
    N_[j] += tau;
    if (j > 0) N_[j - 1] -= tau;
  }

  void addOuter(Real t, const Real* theta, const Real* omega) {
    for (int j = 0; j < n_; ++j) {
      const Body<Real>& b = s_.bodies[j];
      if (b.k == 0 && b.d == 0) continue;
      const Real q = j > 0 ? theta[j] - theta[j - 1] : theta[j];
      const Real qd = j > 0 ? omega[j] - omega[j - 1] : omega[j];
      addJoint(j, -b.k * (q - b.q0) - b.d * qd);
    }
    for (const Load<Real>& load : s_.loads) {
      if (!acts(load, now_)) continue;
      const Real c = factor(load, t, now_);
      if (load.joint >= 0) addJoint(load.joint, c * load.torque);
      const int l = load.link;
      if (l < 0) continue;
      const Vec<Real> r = s_.bodies[l].r;
      const Vec<Real> e{cosine(theta[l]), sine(theta[l])};
      const Vec<Real> X = rotated(e, Vec<Real>{load.point.x - r.x, load.point.y - r.y});
      W_[l] = {W_[l].x + c * load.force.x, W_[l].y + c * load.force.y};
      N_[l] += c * dot(load.force, turned(X)) + c * load.moment;
    }
  }

  const Scene<Real>& s_;
  int n_;
  double now_ = 0;
  std::vector<Vec<Real>> R_, Q_, W_, f_;
  std::vector<Real> N_, w_, v_;  // w, v: 1/m, 1/I
  std::vector<Matrix<Real>> D_, upper_;
};

}  // namespace

/// pins COLUMNS TOLERANCE COLUMNS TOLERANCE DRAWS: of the run, of a second one. For tolerances that need no
/// quadruple precision: in 80-bit arithmetic, which is some twenty times faster.
int main(int, char** argv) {
  constexpr double needsQuad = 1e-14;
  const Effort effort{
      {std::stoi(argv[1]), std::stod(argv[2])}, {std::stoi(argv[3]), std::stod(argv[4])}, std::stoi(argv[5])};
  effort.first.tolerance < needsQuad ? writeReference<Pins, Quad>(false, effort)
                                     : writeReference<Pins, long double>(false, effort);
}
