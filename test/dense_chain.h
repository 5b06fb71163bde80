#pragma once

/// Newton's and Euler's equations of a chain, with every pin force and joint moment as an unknown: dense, and
/// independent of every recursion. The number type is complex, so that derivatives are exact by complex step.

#include <Eigen/Dense>
#include <cmath>
#include <complex>
#include <vector>

#include "random_scene.h"
#include "recursion/coupled.h"
#include "recursion/ends.h"

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

/// A slide of the inner end with a spring and a damper along its rail. The next slide or the first body is at
/// `pin`. Forces −K x − D v act at its own point.
struct DenseSlide {
  Slide<double> of;
  double stiffness = 0, damping = 0;
  Vec2d pin{};
  Eigen::Matrix2d K = Eigen::Matrix2d::Zero(), D = K;
};

/// Of a point on the base or on slides: where it is, how fast, and its acceleration if no slide speeds up.
struct Carried {
  Vector2 x, v, a;
};

/// A chain with ends, on a base whose motion is given. A state is θ_1 … θ_n, s of the slides, and their
/// rates.
struct DenseChain {
  std::vector<Link> links;
  std::vector<Coupling<double>> joints;
  std::vector<double> k, d, rest, torque;
  std::vector<DenseSlide> slides;
  Tip<double> tip;  ///< its acceleration is that in the base frame, not less gravity
  Vec2d gravity, base, baseVelocity, baseAcceleration;
  double baseTurning = 0, baseRate = 0;  ///< angular acceleration and rate of the base; its angle is 0

  int size() const { return static_cast<int>(links.size()); }
  int places() const { return size() + static_cast<int>(slides.size()); }

  /// What acts on body j there, without gravity.
  virtual Acting actingOn(int j, const Placed& at) const = 0;
  virtual ~DenseChain() = default;

  /// α, moments of the joints (with springs and dampers), forces of the pins (2n), then s̈, forces along the
  /// rails, and the force on the tip.
  struct Answer {
    ComplexVector alpha, moments, forces, slides, slideForces;
    Vector2 tip;
    ComplexVector all() const {
      ComplexVector sum(alpha.size() * 4 + slides.size() * 2 + 2);
      sum << alpha, moments, forces, slides, slideForces, tip;
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
    WideMatrix slope(4 * size() + 2 * (places() - size()) + 2, y.size());
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      ComplexVector aside = y.cast<WideComplex>();
      aside[i] += WideComplex(0, h);
      const Equations there(*this, aside);
      const WideVector change = M.solve(WideVector((there.rhs() - there.matrix() * x).imag()));
      slope.col(i) = there.answer(x + WideComplex(0, 1) * change).all().imag() / h;
    }
    return slope;
  }

  /// The first pin, and the body there without its rates.
  Placed start(const ComplexVector& y) const {
    const Carried pin = carried(y, places() - size(), {});
    return {pin.x, pin.v, 0, 0};
  }

  /// The own point of slide i, or the first pin for i = the number of slides, moved by X.
  Carried carried(const ComplexVector& y, int i, Vec2d X) const {
    Vector2 arm = wide(X), w = Vector2::Zero();
    for (int j = 0; j <= i && j < places() - size(); ++j) {
      const DenseSlide& slide = slides[index(j)];
      arm += y[size() + j] * wide(slide.of.d);
      if (j < i) arm += wide(slide.pin);
      w += y[places() + size() + j] * wide(slide.of.d);
    }
    const Wide rate = baseRate;
    return {wide(base) + arm, wide(baseVelocity) + w + rate * quarter(arm),
            wide(baseAcceleration) + Wide(baseTurning) * quarter(arm) - rate * rate * arm +
                2 * rate * quarter(w)};
  }

  static Vector2 wide(Vec2d a) { return {Wide(a.x), Wide(a.y)}; }

 private:
  /// Unknown: of each body its acceleration (centre of mass), α, pin force and moment; of each slide its
  /// acceleration and the force on it from further in; the force on the tip.
  class Equations {
   public:
    Equations(const DenseChain& chain, const ComplexVector& y)
        : chain_(chain),
          y_(y),
          n_(chain.size()),
          slides_(chain.places() - n_),
          at_(chain.start(y)),
          M_(ComplexMatrix::Zero(6 * n_ + 4 * slides_ + 2, 6 * n_ + 4 * slides_ + 2)),
          rhs_(ComplexVector::Zero(M_.rows())) {
      for (int j = 0; j < n_; ++j) addBody(j);
      for (int i = 0; i < slides_; ++i) addSlide(i);
      addTip();
    }
    const ComplexMatrix& matrix() const { return M_; }
    const ComplexVector& rhs() const { return rhs_; }

    /// Takes the unknowns apart.
    Answer answer(const ComplexVector& x) const {
      Answer answer{ComplexVector(n_),      ComplexVector(n_),      ComplexVector(2 * n_),
                    ComplexVector(slides_), ComplexVector(slides_), x.tail<2>()};
      for (int j = 0; j < n_; ++j) {
        answer.alpha[j] = x[6 * j + 2];
        answer.moments[j] = x[6 * j + 5];
        answer.forces.segment<2>(2 * j) = x.segment<2>(pin(j));
      }
      Vector2 inner = Vector2::Zero();
      for (int i = 0; i < slides_; ++i) {
        const Vector2 d = wide(chain_.slides[index(i)].of.d),
                      a = x.segment<2>(slideAt(i)) - chain_.carried(y_, i, {}).a;
        answer.slides[i] = d.cwiseProduct(a - inner).sum();
        answer.slideForces[i] = d.cwiseProduct(x.segment<2>(slideAt(i) + 2)).sum();
        inner = a;
      }
      return answer;
    }

   private:
    void addBody(int j) {
      const WideComplex before = at_.theta, rateBefore = at_.omega;
      at_.theta = y_[j];
      at_.omega = y_[chain_.places() + j];
      const Link& link = chain_.links[index(j)];
      const Vector2 R = turnedBy(at_.theta, link.com), P = turnedBy(at_.theta, link.pin);
      const auto [F, N] = chain_.actingOn(j, at_);
      const int row = 6 * j, a = row, alpha = a + 2, mu = a + 5;

      // Newton, and Euler about the centre of mass; the force on the outer pin is −(next pin force), or λ.
      const bool isLast = j + 1 == n_;
      const int outer = isLast ? tip() : pin(j + 1);
      const Wide sign = isLast ? -1 : 1;
      M_.block<2, 2>(row, a) = one(link.mass);
      M_.block<2, 2>(row, pin(j)) = one(-1);
      M_.block<2, 2>(row, outer) = one(sign);
      rhs_.segment<2>(row) = F + Wide(link.mass) * wide(chain_.gravity);
      M_(row + 2, alpha) = link.inertia;
      M_.block<1, 2>(row + 2, pin(j)) = quarter(R).transpose();
      M_.block<1, 2>(row + 2, outer) = sign * quarter(P - R).transpose();
      M_(row + 2, mu) = -1;
      if (!isLast) M_(row + 2, mu + 6) = 1;
      rhs_[row + 2] = N - crossed(R, F);

      // The inner pin, by the acceleration of this body, is where it is by that of the one before.
      addPoint(row + 3, j, -R, 1, at_.omega);
      if (j > 0) {
        addPoint(row + 3, j - 1, before_, -1, rateBefore);
      } else {
        addBase(row + 3, slides_ - 1, -1);
      }
      addJoint(j, at_.theta - before, at_.omega - rateBefore);
      before_ = P - R;
      at_.x += P;
      at_.v += at_.omega * quarter(P);
    }

    void addSlide(int i) {
      const DenseSlide& slide = chain_.slides[index(i)];
      const Vector2 d = wide(slide.of.d), across = quarter(d);
      const int row = slideAt(i), a = row, f = a + 2;
      M_.block<2, 2>(row, a) = one(slide.of.mass);
      M_.block<2, 2>(row, f) = one(-1);
      M_.block<2, 2>(row, i + 1 < slides_ ? slideAt(i + 1) + 2 : pin(0)) = one(1);
      const Carried own = chain_.carried(y_, i, {});
      rhs_.segment<2>(row) = Wide(slide.of.mass) * wide(chain_.gravity) -
                             slide.K.cast<WideComplex>() * own.x - slide.D.cast<WideComplex>() * own.v;
      // Across the rail it moves with what is further in.
      const auto relative = [&](int to, const Vector2& along) {
        M_.block<1, 2>(to, a) = along.transpose();
        if (i > 0) M_.block<1, 2>(to, slideAt(i - 1)) = -along.transpose();
        const Vector2 inner = i > 0 ? chain_.carried(y_, i - 1, {}).a : Vector2(Vector2::Zero());
        rhs_[to] += along.cwiseProduct(own.a - inner).sum();
      };
      relative(row + 2, across);
      if (slide.of.isHeld) {
        relative(row + 3, d);
        rhs_[row + 3] += Wide(slide.of.acceleration);
      } else {
        M_.block<1, 2>(row + 3, f) = d.transpose();
        rhs_[row + 3] = Wide(slide.of.force) - Wide(slide.stiffness) * y_[n_ + i] -
                        Wide(slide.damping) * y_[chain_.places() + n_ + i];
      }
    }

    /// The first rows of the tip set its acceleration, the others say that no force acts.
    void addTip() {
      const Tip<double>& end = chain_.tip;
      addPoint(tip(), n_ - 1, before_, 1, at_.omega);
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

    static int pin(int j) { return 6 * j + 3; }
    int slideAt(int i) const { return 6 * n_ + 4 * i; }
    int tip() const { return 6 * n_ + 4 * slides_; }
    static Eigen::Matrix<WideComplex, 2, 2> one(Wide factor) {
      return WideComplex(factor) * Eigen::Matrix<WideComplex, 2, 2>::Identity();
    }

    /// Adds sign × the acceleration of the point at X from the centre of mass of body j to two rows.
    /// omega: its rate.
    void addPoint(int row, int j, const Vector2& X, Wide sign, WideComplex omega) {
      M_.block<2, 2>(row, 6 * j) += one(sign);
      M_.block<2, 1>(row, 6 * j + 2) += sign * quarter(X);
      rhs_.segment<2>(row) += sign * omega * omega * X;
    }
    /// Adds sign × the acceleration of slide i, or of the base for i = −1, to two rows.
    void addBase(int row, int i, Wide sign) {
      if (i >= 0) M_.block<2, 2>(row, slideAt(i)) += one(sign);
      const Vector2 inner = i >= 0 ? chain_.carried(y_, i, {}).a : Vector2(Vector2::Zero());
      rhs_.segment<2>(row) -= sign * (chain_.carried(y_, slides_, {}).a - inner);
    }
    void addJoint(int j, WideComplex q, WideComplex rate) {
      const Coupling<double>& joint = chain_.joints[index(j)];
      const int row = 6 * j + 5, alpha = 6 * j + 2;
      const Wide J = joint.isHeld ? Wide(1) : Wide(joint.rotor);
      M_(row, alpha) += J;
      if (j > 0) M_(row, alpha - 6) -= J;
      if (j == 0) rhs_[row] += J * Wide(chain_.baseTurning);
      if (joint.isHeld) {
        rhs_[row] += Wide(joint.acceleration);
        return;
      }
      const auto i = index(j);
      M_(row, alpha + 3) += 1;
      rhs_[row] +=
          Wide(chain_.torque[i]) - Wide(chain_.k[i]) * (q - Wide(chain_.rest[i])) - Wide(chain_.d[i]) * rate;
    }

    const DenseChain& chain_;
    const ComplexVector y_;
    int n_, slides_;
    Placed at_;                         ///< the body after the last one added
    Vector2 before_ = Vector2::Zero();  ///< its outer pin, from the centre of mass
    ComplexMatrix M_;
    ComplexVector rhs_;
  };
};

}  // namespace planar_chain::test
