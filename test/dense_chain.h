#pragma once

/// Newton's and Euler's equations of a chain, with every pin force and joint moment as an unknown: dense, and
/// independent of every recursion. The number type is complex, so that derivatives are exact by complex step.

#include <Eigen/Dense>
#include <cmath>
#include <complex>
#include <vector>

#include "random_scene.h"
#include "recursion/coupled.h"

namespace planar_chain::test {

using Wide = long double;
using WideComplex = std::complex<Wide>;
using Vector2 = Eigen::Matrix<WideComplex, 2, 1>;
using WideVector = Eigen::Matrix<Wide, Eigen::Dynamic, 1>;
using WideMatrix = Eigen::Matrix<Wide, Eigen::Dynamic, Eigen::Dynamic>;
using ComplexVector = Eigen::Matrix<WideComplex, Eigen::Dynamic, 1>;
using ComplexMatrix = Eigen::Matrix<WideComplex, Eigen::Dynamic, Eigen::Dynamic>;

inline Vector2 turnedBy(WideComplex angle, Vec2d a) {
  const WideComplex c = std::cos(angle), s = std::sin(angle);
  return {c * Wide(a.x) - s * Wide(a.y), s * Wide(a.x) + c * Wide(a.y)};
}
inline Vector2 turnedBack(WideComplex angle, const Vector2& a) {
  const WideComplex c = std::cos(angle), s = std::sin(angle);
  return {c * a.x() + s * a.y(), c * a.y() - s * a.x()};
}
inline Vector2 quarter(const Vector2& a) {
  return {-a.y(), a.x()};
}
/// a×b
inline WideComplex crossed(const Vector2& a, const Vector2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// The place of a body: its inner pin, angle, and their rates.
struct Placed {
  Vector2 x, v;
  WideComplex theta, omega;
};

/// The force on a body, and its moment about the inner pin.
struct Acting {
  Vector2 F = Vector2::Zero();
  WideComplex N = 0;
};

/// A chain on a base whose motion is given.
struct DenseChain {
  std::vector<Link> links;
  std::vector<Coupling<double>> joints;
  std::vector<double> k, d, rest, torque;
  Vec2d gravity, base, baseVelocity, baseAcceleration;
  double baseTurning = 0;  ///< angular acceleration of the base

  int size() const { return static_cast<int>(links.size()); }

  /// What acts on body j there, without gravity.
  virtual Acting actingOn(int j, const Placed& at) const = 0;
  virtual ~DenseChain() = default;

  /// α of the bodies, moments of the joints (with springs and dampers), forces of the pins (2n).
  struct Answer {
    ComplexVector alpha, moments, forces;
    ComplexVector all() const {
      ComplexVector sum(alpha.size() * 4);
      sum << alpha, moments, forces;
      return sum;
    }
  };

  /// y: θ_j, then ω_j.
  Answer solve(const ComplexVector& y) const {
    const int n = size();
    ComplexMatrix M = ComplexMatrix::Zero(6 * n, 6 * n);
    ComplexVector rhs = ComplexVector::Zero(6 * n);
    Placed at{wide(base), wide(baseVelocity), 0, 0};
    for (int j = 0; j < n; ++j) {
      const WideComplex before = at.theta, rateBefore = at.omega;
      at.theta = y[j];
      at.omega = y[n + j];
      const Link& link = links[index(j)];
      const Vector2 R = turnedBy(at.theta, link.com), P = turnedBy(at.theta, link.pin);
      const auto [F, N] = actingOn(j, at);
      const int row = 6 * j, a = 6 * j, alpha = a + 2, f = a + 3, mu = a + 5;
      const bool isLast = j + 1 == n;

      // Newton, and Euler about the centre of mass.
      for (int c = 0; c < 2; ++c) {
        M(row + c, a + c) = link.mass;
        M(row + c, f + c) = -1;
        if (!isLast) M(row + c, f + 6 + c) = 1;
        rhs[row + c] = F[c] + Wide(link.mass) * wide(gravity)[c];
      }
      M(row + 2, alpha) = link.inertia;
      addCross(M, row + 2, f, R);
      M(row + 2, mu) = -1;
      if (!isLast) addCross(M, row + 2, f + 6, Vector2(P - R));
      if (!isLast) M(row + 2, mu + 6) = 1;
      rhs[row + 2] = N - crossed(R, F);

      // The inner pin: a_c − iα R + ω² R is the acceleration of the pin.
      for (int c = 0; c < 2; ++c) {
        M(row + 3 + c, a + c) = 1;
        M(row + 3 + c, alpha) = -quarter(R)[c];
        rhs[row + 3 + c] = -at.omega * at.omega * R[c];
        if (j == 0) {
          rhs[row + 3 + c] += wide(baseAcceleration)[c];
        } else {
          const Vector2 outer =
              turnedBy(before, links[index(j - 1)].pin) - turnedBy(before, links[index(j - 1)].com);
          M(row + 3 + c, a - 6 + c) = -1;
          M(row + 3 + c, alpha - 6) = -quarter(outer)[c];
          rhs[row + 3 + c] -= rateBefore * rateBefore * outer[c];
        }
      }

      // The joint.
      const Coupling<double>& joint = joints[index(j)];
      const Wide J = joint.isHeld ? Wide(1) : Wide(joint.rotor);
      M(row + 5, alpha) = J;
      if (j > 0) M(row + 5, alpha - 6) = -J;
      if (j == 0) rhs[row + 5] += J * Wide(baseTurning);
      if (joint.isHeld) {
        rhs[row + 5] += Wide(joint.acceleration);
      } else {
        M(row + 5, mu) = 1;
        rhs[row + 5] += jointTorque(j, at.theta - before, at.omega - rateBefore);
      }
      at.x += P;
      at.v += at.omega * quarter(P);
    }
    return answerOf(M.partialPivLu().solve(rhs));
  }

  /// The derivatives of all() with respect to y: 4n × 2n.
  WideMatrix slopes(const WideVector& y) const {
    constexpr Wide h = 1e-300L;
    WideMatrix slope(2 * y.size(), y.size());
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      ComplexVector at = y.cast<WideComplex>();
      at[i] += WideComplex(0, h);
      slope.col(i) = solve(at).all().imag() / h;
    }
    return slope;
  }

  WideComplex jointTorque(int j, WideComplex q, WideComplex rate) const {
    const auto i = index(j);
    return Wide(torque[i]) - Wide(k[i]) * (q - Wide(rest[i])) - Wide(d[i]) * rate;
  }

  static Vector2 wide(Vec2d a) { return {Wide(a.x), Wide(a.y)}; }

 private:
  /// Adds X×f to a row.
  static void addCross(ComplexMatrix& M, int row, int f, const Vector2& X) {
    M(row, f) += -X.y();
    M(row, f + 1) += X.x();
  }
  Answer answerOf(const ComplexVector& x) const {
    const int n = size();
    Answer answer{ComplexVector(n), ComplexVector(n), ComplexVector(2 * n)};
    for (int j = 0; j < n; ++j) {
      answer.alpha[j] = x[6 * j + 2];
      answer.moments[j] = x[6 * j + 5];
      answer.forces.segment<2>(2 * j) = x.segment<2>(6 * j + 3);
    }
    return answer;
  }
};

}  // namespace planar_chain::test
