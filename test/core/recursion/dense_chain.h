#pragma once

/// Newton's and Euler's equations of a chain, with every pin force and joint moment as an unknown: dense, and
/// independent of every recursion. The number type is complex, so that derivatives are exact by complex step.

#include <Eigen/Dense>
#include <cmath>
#include <complex>
#include <vector>

#include "planar_chain/chain.h"
#include "recursion/general.h"
#include "recursion/tip_constraint.h"
#include "support/random_scene.h"

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

/// The place of a body: its own point, angle, and their rates.
struct Placed {
  Vector2 x, v;
  WideComplex theta, omega;
};

/// The force on a body, and its moment about the own point.
struct Acting {
  Vector2 F = Vector2::Zero();
  WideComplex N = 0;
};

/// A chain with joints of any kind, on a base whose motion is given. A state has the coordinates, then their
/// rates: absolute angles of bodies behind revolute joints, displacements of prismatic ones.
struct DenseChain {
  std::vector<Link> links;
  std::vector<Joint> joints;  ///< isPrismatic and axis are read
  std::vector<JointLaw<double>> laws;
  std::vector<double> k, d, rest, torque;
  Tip<double> tip;  ///< its acceleration is that in the base frame, not less gravity
  Vec2d gravity, base, baseVelocity, baseAcceleration;
  double baseTurning = 0, baseRate = 0;  ///< angular acceleration and rate of the base; its angle is 0

  int size() const { return static_cast<int>(links.size()); }
  Coordinates coordinates() const { return Coordinates(joints); }

  /// What acts on body j there, without gravity. None has a moment on a body that turns with the base.
  virtual Acting actingOn(int j, const Placed& at) const = 0;
  virtual ~DenseChain() = default;

  /// ẍ of the coordinates; of each joint its moment, or its force along the axis, with springs and dampers;
  /// the forces on the own points (2n); the force on the tip, and the moment of the base about the ground
  /// pin.
  struct Answer {
    ComplexVector xdd, moments, forces;
    Vector2 tip;
    WideComplex baseMoment;
    ComplexVector all() const {
      ComplexVector sum(xdd.size() * 4 + 3);
      sum << xdd, moments, forces, tip, baseMoment;
      return sum;
    }
  };

  Answer solve(const ComplexVector& y) const {
    const Equations equations(*this, y);
    return equations.answer(equations.matrix().partialPivLu().solve(equations.rhs()));
  }

  /// The derivatives of all() with respect to y: of M x = r, M δx = δr − δM x.
  WideMatrix slopes(const WideVector& y) const {
    constexpr Wide h = 1e-300L;
    const Equations at(*this, y.cast<WideComplex>());
    const Eigen::PartialPivLU<WideMatrix> M(at.matrix().real());
    const ComplexVector x = M.solve(WideVector(at.rhs().real())).cast<WideComplex>();
    WideMatrix slope(4 * size() + 3, y.size());
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      ComplexVector aside = y.cast<WideComplex>();
      aside[i] += WideComplex(0, h);
      const Equations there(*this, aside);
      const WideVector change = M.solve(WideVector((there.rhs() - there.matrix() * x).imag()));
      slope.col(i) = there.answer(x + WideComplex(0, 1) * change).all().imag() / h;
    }
    return slope;
  }

  /// The bodies at a state.
  std::vector<Placed> placed(const ComplexVector& y) const {
    const Coordinates all = coordinates();
    std::vector<Placed> bodies;
    Placed at{wide(base), wide(baseVelocity), 0, baseRate};
    for (int j = 0; j < size(); ++j) {
      if (all.isPrismatic(j)) {
        const Vector2 axis = turnedBy(at.theta, joints[index(j)].axis);
        at.x += y[j] * axis;
        at.v += at.omega * quarter(y[j] * axis) + y[size() + j] * axis;
      } else {
        at.theta = y[j];
        at.omega = y[size() + j];
      }
      bodies.push_back(at);
      const Vector2 P = turnedBy(at.theta, links[index(j)].pin);
      at.x += P;
      at.v += at.omega * quarter(P);
    }
    return bodies;
  }

  static Vector2 wide(Vec2d a) { return {Wide(a.x), Wide(a.y)}; }

 private:
  /// Unknown: of each body its acceleration (centre of mass), α, and the force and moment on it from inside,
  /// at its own point; the force on the tip.
  class Equations {
   public:
    Equations(const DenseChain& chain, const ComplexVector& y)
        : chain_(chain),
          y_(y),
          n_(chain.size()),
          at_(chain.placed(y)),
          M_(ComplexMatrix::Zero(6 * n_ + 2, 6 * n_ + 2)),
          rhs_(ComplexVector::Zero(M_.rows())) {
      for (int j = 0; j < n_; ++j) {
        addBody(j);
        chain.joints[index(j)].isPrismatic ? addPrismatic(j) : addRevolute(j);
      }
      addTip();
    }
    const ComplexMatrix& matrix() const { return M_; }
    const ComplexVector& rhs() const { return rhs_; }

    /// Takes the unknowns apart.
    Answer answer(const ComplexVector& x) const {
      Answer answer{ComplexVector(n_), ComplexVector(n_), ComplexVector(2 * n_), x.tail<2>(), 0};
      for (int j = 0; j < n_; ++j) {
        const Vector2 force = x.segment<2>(force_(j));
        answer.forces.segment<2>(2 * j) = force;
        answer.xdd[j] = x[6 * j + 2];
        answer.moments[j] = x[6 * j + 5];
        if (!chain_.joints[index(j)].isPrismatic) continue;
        const Vector2 d = axis(j);
        answer.moments[j] = d.cwiseProduct(force).sum();
        ComplexMatrix row = ComplexMatrix::Zero(1, x.size());
        WideComplex known = 0;
        addSlip(j, d, row, known);
        answer.xdd[j] = (row * x)[0] - known;
      }
      answer.baseMoment = x[5] + crossed(at_[0].x - wide(chain_.base), Vector2(x.segment<2>(force_(0))));
      return answer;
    }

   private:
    /// Newton, and Euler about the centre of mass; what acts from outside is less what acts on the next body.
    void addBody(int j) {
      const Link& link = chain_.links[index(j)];
      const Vector2 R = arm(j, link.com), P = arm(j, link.pin);
      const auto [F, N] = chain_.actingOn(j, at_[index(j)]);
      const int row = 6 * j, moment = row + 5;
      const bool isLast = j + 1 == n_;
      const int outer = isLast ? tip() : force_(j + 1);
      const Wide sign = isLast ? -1 : 1;
      const Vector2 at = isLast ? Vector2(P) : Vector2(at_[index(j + 1)].x - at_[index(j)].x);
      M_.block<2, 2>(row, row) = one(link.mass);
      M_.block<2, 2>(row, force_(j)) = one(-1);
      M_.block<2, 2>(row, outer) = one(sign);
      rhs_.segment<2>(row) = F + Wide(link.mass) * wide(chain_.gravity);
      M_(row + 2, row + 2) = link.inertia;
      M_.block<1, 2>(row + 2, force_(j)) = quarter(R).transpose();
      M_.block<1, 2>(row + 2, outer) = sign * quarter(at - R).transpose();
      M_(row + 2, moment) = -1;
      if (!isLast) M_(row + 2, moment + 6) = 1;
      rhs_[row + 2] = N - crossed(R, F);
    }

    /// The own point is the pin inside. The joint has its torque, or its acceleration.
    void addRevolute(int j) {
      const int row = 6 * j + 3, alpha = 6 * j + 2;
      addOwn(row, j, 1);
      addInside(row, j, -1);
      const JointLaw<double>& law = chain_.laws[index(j)];
      const Wide J = law.isPrescribed ? Wide(1) : Wide(law.armature);
      M_(row + 2, alpha) += J;
      rhs_[row + 2] += addTurning(row + 2, j, -J);
      if (law.isPrescribed) {
        rhs_[row + 2] += Wide(law.acceleration);
        return;
      }
      M_(row + 2, 6 * j + 5) += 1;
      const int inner = chain_.coordinates().inner(j);
      const WideComplex q = inner >= 0 ? y_[j] - y_[inner] : y_[j];
      rhs_[row + 2] += given(j, q, inner >= 0 ? y_[n_ + j] - y_[n_ + inner] : y_[n_ + j]);
    }

    /// The body turns as the one inside, and across the axis its own point moves with it.
    void addPrismatic(int j) {
      const int row = 6 * j + 3;
      const Vector2 d = axis(j);
      M_(row, 6 * j + 2) += 1;
      rhs_[row] += addTurning(row, j, -1);
      ComplexMatrix slip = ComplexMatrix::Zero(1, M_.cols());
      WideComplex known = 0;
      addSlip(j, quarter(d), slip, known);
      M_.row(row + 1) += slip;
      rhs_[row + 1] += known;
      slip.setZero();
      known = 0;
      addSlip(j, d, slip, known);
      const JointLaw<double>& law = chain_.laws[index(j)];
      const Wide J = law.isPrescribed ? Wide(1) : Wide(law.armature);
      M_.row(row + 2) += J * slip;
      rhs_[row + 2] += J * known;
      if (law.isPrescribed) {
        rhs_[row + 2] += Wide(law.acceleration);
        return;
      }
      M_.block<1, 2>(row + 2, force_(j)) += d.transpose();
      rhs_[row + 2] += given(j, y_[j], y_[n_ + j]);
    }

    /// The torque or force in joint j.
    WideComplex given(int j, WideComplex q, WideComplex rate) const {
      const auto i = index(j);
      return Wide(chain_.torque[i]) - Wide(chain_.k[i]) * (q - Wide(chain_.rest[i])) -
             Wide(chain_.d[i]) * rate;
    }
    /// Adds factor × the angular acceleration inside of joint j. Returns what is known of it, on the other
    /// side.
    WideComplex addTurning(int row, int j, Wide factor) {
      if (j == 0) return -factor * Wide(chain_.baseTurning);
      M_(row, 6 * j - 4) += factor;
      return 0;
    }
    /// The component along `way` of how the own point accelerates against the body inside, but for Coriolis':
    /// s̈ along the axis, 0 across it.
    void addSlip(int j, const Vector2& way, ComplexMatrix& row, WideComplex& known) const {
      const WideComplex omega = at_[index(j)].omega;
      const Vector2 S = y_[j] * axis(j), coriolis = Wide(2) * omega * y_[n_ + j] * quarter(axis(j));
      const auto dotted = [&](const Vector2& a) { return way.cwiseProduct(a).sum(); };
      const Vector2 R = arm(j, chain_.links[index(j)].com);
      row.block<1, 2>(0, 6 * j) += way.transpose();
      row(0, 6 * j + 2) -= dotted(quarter(R));
      known -= dotted(omega * omega * R);
      known += dotted(coriolis) - dotted(omega * omega * S);
      if (j == 0) {
        known += dotted(wide(chain_.baseAcceleration) + Wide(chain_.baseTurning) * quarter(S));
        return;
      }
      const Vector2 P = arm(j - 1, chain_.links[index(j - 1)].pin - chain_.links[index(j - 1)].com);
      row.block<1, 2>(0, 6 * j - 6) -= way.transpose();
      row(0, 6 * j - 4) -= dotted(quarter(P + S));
      known -= dotted(omega * omega * P);
    }

    /// The first rows of the tip set its acceleration, the others say that no force acts.
    void addTip() {
      const Tip<double>& end = chain_.tip;
      const Link& last = chain_.links.back();
      addPoint(tip(), n_ - 1, arm(n_ - 1, last.pin - last.com), 1);
      rhs_.tail<2>() += wide(end.acceleration);
      const Vec2d c = end.rows > 0 ? end.row[0] : Vec2d{1, 0};
      Eigen::Matrix<WideComplex, 2, 2> rows;
      rows << wide(c).transpose(), wide(perp(c)).transpose();
      M_.bottomRows<2>() = (rows * M_.bottomRows<2>()).eval();
      rhs_.tail<2>() = (rows * rhs_.tail<2>()).eval();
      for (int i = end.rows; i < 2; ++i) {
        M_.row(tip() + i).setZero();
        M_.block<1, 2>(tip() + i, tip()) = rows.row(i);
        rhs_[tip() + i] = 0;
      }
    }

    static int force_(int j) { return 6 * j + 3; }
    int tip() const { return 6 * n_; }
    static Eigen::Matrix<WideComplex, 2, 2> one(Wide factor) {
      return WideComplex(factor) * Eigen::Matrix<WideComplex, 2, 2>::Identity();
    }
    Vector2 arm(int j, Vec2d a) const { return turnedBy(at_[index(j)].theta, a); }
    Vector2 axis(int j) const { return arm(j, chain_.joints[index(j)].axis); }

    /// Adds sign × the acceleration of the point at X from the centre of mass of body j to two rows.
    void addPoint(int row, int j, const Vector2& X, Wide sign) {
      const WideComplex omega = at_[index(j)].omega;
      M_.block<2, 2>(row, 6 * j) += one(sign);
      M_.block<2, 1>(row, 6 * j + 2) += sign * quarter(X);
      rhs_.segment<2>(row) += sign * omega * omega * X;
    }
    void addOwn(int row, int j, Wide sign) { addPoint(row, j, -arm(j, chain_.links[index(j)].com), sign); }
    /// The pin inside of joint j.
    void addInside(int row, int j, Wide sign) {
      if (j == 0) {
        rhs_.segment<2>(row) -= sign * wide(chain_.baseAcceleration);
        return;
      }
      const Link& inside = chain_.links[index(j - 1)];
      addPoint(row, j - 1, arm(j - 1, inside.pin - inside.com), sign);
    }

    const DenseChain& chain_;
    const ComplexVector y_;
    int n_;
    std::vector<Placed> at_;
    ComplexMatrix M_;
    ComplexVector rhs_;
  };
};

}  // namespace planar_chain::test
