/// The exact solve of chains whose forces depend on place and velocity, against Newton's and Euler's
/// equations with all pin forces as unknowns, differentiated by complex step in long double.

#include "recursion/tangent_linearized.h"

#include <gtest/gtest.h>

#include "dense_chain.h"

namespace planar_chain {
namespace {

using test::Acting;
using test::crossed;
using test::Placed;
using test::quarter;
using test::Random;
using test::Vector2;
using test::Wide;
using test::WideComplex;

/// Chains of these are drawn.
struct Kind {
  double rotors, held, springs;
  double forces = 1;  ///< 0: none that depends on place or velocity
};

/// A law of all six numbers of a place: (F, N) = −A sin(B (x, θ, v, ω)).
struct General {
  Eigen::Matrix<Wide, 3, 4> A;
  Eigen::Matrix<Wide, 4, 6> B;

  Eigen::Matrix<WideComplex, 4, 1> phase(const Placed& at) const {
    Eigen::Matrix<WideComplex, 6, 1> place;
    place << at.x, at.theta, at.v, at.omega;
    return B.cast<WideComplex>() * place;
  }
};

/// A spring with a rest length from a point of the body to one of the ground, a drag in the axes of the body,
/// and a force that stays.
struct Attached {
  Vec2d point, anchor, sail, dead;
  double k, c, length, along, across;
};

class RandomChain : public test::DenseChain {
 public:
  RandomChain(int n, unsigned seed, const Kind& kind) : general_(index(n)), attached_(index(n)) {
    Random random(seed);
    for (int j = 0; j < n; ++j) {
      links.push_back(
          {"", random.between(0.3, 2), random.between(0.02, 0.3), random.vector(0.5), random.vector(0.8)});
      Coupling<double> joint;
      if (random.between(0, 1) < kind.rotors) joint.rotor = random.between(0.01, 0.5);
      joint.isHeld = random.between(0, 1) < kind.held;
      if (joint.isHeld) joint.acceleration = random.between(-3, 3);
      joints.push_back(joint);
      k.push_back(kind.springs * random.between(0, 40));
      d.push_back(kind.springs * random.between(0, 2));
      rest.push_back(random.between(-1, 1));
      torque.push_back(random.between(-2, 2));
      y.push_back(random.between(-3, 3));
      for (Wide* number = general_[index(j)].A.data(); number < general_[index(j)].A.data() + 12; ++number) {
        *number = kind.forces * random.between(-5, 5);
      }
      for (Wide* number = general_[index(j)].B.data(); number < general_[index(j)].B.data() + 24; ++number) {
        *number = random.between(-1, 1);
      }
      Attached& on = attached_[index(j)];
      on = {random.vector(0.5), random.vector(3), random.vector(0.5), random.vector(5), 0, 0, 0, 0, 0};
      on.k = kind.forces * random.between(10, 300);
      on.c = kind.forces * random.between(0, 5);
      on.length = random.between(0, 1);
      on.along = kind.forces * random.between(0, 1);
      on.across = kind.forces * random.between(0, 3);
    }
    for (int j = 0; j < n; ++j) y.push_back(random.between(-2, 2));
    gravity = random.vector(10);
    base = random.vector(1);
    baseVelocity = random.vector(1);
    baseAcceleration = random.vector(5);
    baseTurning = random.between(-2, 2);
  }

  std::vector<double> y;  ///< θ, ω

  Acting actingOn(int j, const Placed& at) const override {
    Acting sum;
    const Eigen::Matrix<WideComplex, 3, 1> given =
        general_[index(j)].A.cast<WideComplex>() * general_[index(j)].phase(at).array().sin().matrix();
    sum.F -= given.head<2>();
    sum.N -= given[2];
    const Attached& on = attached_[index(j)];
    const auto add = [&](Vec2d point, auto law) {
      const Vector2 X = test::turnedBy(at.theta, point);
      const Vector2 F = law(Vector2(at.x + X), Vector2(at.v + at.omega * quarter(X)));
      sum.F += F;
      sum.N += crossed(X, F);
    };
    add(on.point, [&](const Vector2& x, const Vector2& v) {
      const Vector2 D = x - wide(on.anchor);
      const WideComplex length = std::sqrt(D.x() * D.x() + D.y() * D.y());
      const Vector2 n = D / length;
      const WideComplex rate = n.x() * v.x() + n.y() * v.y();
      return Vector2(-(Wide(on.k) * (length - Wide(on.length)) + Wide(on.c) * rate) * n);
    });
    add(on.sail, [&](const Vector2&, const Vector2& v) {
      const Vector2 V = test::turnedBack(at.theta, v);
      const WideComplex size = std::sqrt(Wide(1) + V.x() * V.x() + V.y() * V.y());
      const Vector2 Phi{-Wide(on.along) * size * V.x(), -Wide(on.across) * size * V.y()};
      const WideComplex c = std::cos(at.theta), s = std::sin(at.theta);
      return Vector2(c * Phi.x() - s * Phi.y(), s * Phi.x() + c * Phi.y());
    });
    add(on.point, [&](const Vector2&, const Vector2&) { return wide(on.dead); });
    return sum;
  }

  /// K and D of body j by formula.
  ForceTangent tangentOf(int j, const Placed& at) const {
    ForceTangent tangent;
    const General& law = general_[index(j)];
    const Eigen::Matrix<Wide, 3, 6> slope =
        law.A * law.phase(at).real().array().cos().matrix().asDiagonal() * law.B;
    take(slope.leftCols<3>().cast<double>(), tangent.K);
    take(slope.rightCols<3>().cast<double>(), tangent.D);

    const Attached& on = attached_[index(j)];
    const auto e = Rotation<double>::of(real(at.theta));
    const double omega = real(at.omega);
    const auto velocity = [&](Vec2d X) { return narrow(at.v) + omega * perp(X); };
    {
      const Vec2d X = e * on.point, D = narrow(at.x) + X - on.anchor, v = velocity(X);
      const double l = length(D);
      const Vec2d n = (1 / l) * D, across = v - dot(n, v) * n;
      const double T = on.k * (l - on.length) + on.c * dot(n, v);
      const Matrix2d nn{n.x * n.x, n.x * n.y, n.x * n.y, n.y * n.y};
      const auto at2 = [&](double along, double sideways, double mixed) {
        return Matrix2d{-along * nn.xx - sideways * (1 - nn.xx) - mixed * n.x * across.x,
                        (sideways - along) * nn.xy - mixed * n.x * across.y,
                        (sideways - along) * nn.yx - mixed * n.y * across.x,
                        -along * nn.yy - sideways * (1 - nn.yy) - mixed * n.y * across.y};
      };
      addForce({X, -T * n, at2(on.k, T / l, on.c / l), at2(on.c, 0, 0), {}}, omega, tangent);
    }
    {
      const Vec2d X = e * on.sail, v = velocity(X), V = Rotation<double>{e.c, -e.s} * v;
      const double size = std::sqrt(1 + dot(V, V));
      const Matrix2d slopeOfPhi{-on.along * (size + V.x * V.x / size), -on.along * V.x * V.y / size,
                                -on.across * V.x * V.y / size, -on.across * (size + V.y * V.y / size)};
      addForce(forceInBodyAxes(e, X, v, {-on.along * size * V.x, -on.across * size * V.y}, slopeOfPhi), omega,
               tangent);
    }
    return tangent;
  }

  double deadXF(int j, const Placed& at) const {
    const Attached& on = attached_[index(j)];
    return dot(Rotation<double>::of(real(at.theta)) * on.point, on.dead);
  }

  static double real(WideComplex z) { return static_cast<double>(z.real()); }
  static Vec2d narrow(const Vector2& a) { return {real(a.x()), real(a.y())}; }

 private:
  static void take(const Eigen::Matrix3d& slope, PlaneTangent& to) {
    to = {{slope(0, 0), slope(0, 1), slope(1, 0), slope(1, 1)},
          {slope(0, 2), slope(1, 2)},
          {slope(2, 0), slope(2, 1)},
          slope(2, 2)};
  }

  std::vector<General> general_;
  std::vector<Attached> attached_;
};

/// The recursion at the state of a random chain.
struct Linear {
  explicit Linear(const RandomChain& of)
      : chain(named(of.links), plainJoints(of.size()), of.gravity),
        bodies(chain),
        tangents(index(of.size())) {
    const int n = of.size();
    Placed at{RandomChain::wide(of.base), RandomChain::wide(of.baseVelocity), 0, 0};
    for (int j = 0; j < n; ++j) {
      at.theta = Wide(of.y[index(j)]);
      at.omega = Wide(of.y[index(n + j)]);
      tangents[index(j)] = of.tangentOf(j, at);
      F.push_back(RandomChain::narrow(of.actingOn(j, at).F));
      XF.push_back(of.deadXF(j, at));
      e.push_back(Rotation<double>::of(of.y[index(j)]));
      const Vector2 P = test::turnedBy(at.theta, of.links[index(j)].pin);
      at.x += P;
      at.v += at.omega * quarter(P);
    }
    y = Eigen::Map<const Eigen::VectorXd>(of.y.data(), 2 * n).cast<Wide>();
    for (const WideComplex& z : of.solve(y.cast<WideComplex>()).alpha) alpha.push_back(RandomChain::real(z));
    bodies.take({e.data(), of.y.data() + n, alpha.data(), F.data(), XF.data(), of.k.data(), of.d.data(),
                 of.joints.data(), of.baseAcceleration - of.gravity});
  }
  static std::vector<Link> named(std::vector<Link> links) {
    for (std::size_t j = 0; j < links.size(); ++j) links[j].name = "link_" + std::to_string(j);
    return links;
  }
  static std::vector<Joint> plainJoints(int n) {
    std::vector<Joint> joints;
    for (int j = 0; j < n; ++j) joints.push_back({"joint_" + std::to_string(j)});
    return joints;
  }

  Chain chain;
  CoupledBodies bodies;
  std::vector<ForceTangent> tangents;
  std::vector<Rotation<double>> e;
  std::vector<Vec2d> F;
  std::vector<double> XF, alpha;
  test::WideVector y;
};

/// The largest difference over the largest number.
double errorOf(const test::ComplexVector& is, const test::ComplexVector& exact) {
  return static_cast<double>((is - exact).cwiseAbs().maxCoeff() / (1e-3L + exact.cwiseAbs().maxCoeff()));
}

template <class Scalar>
void compare(const Linear& at, const test::WideMatrix& slopes, Scalar s, Random& random, double tolerance) {
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  const Eigen::Index n = at.y.size() / 2;
  Vector rhs(2 * n), x(2 * n);
  for (Scalar& number : rhs) {
    number = random.between(-1, 1);
    if constexpr (!std::is_same_v<Scalar, double>) number.imag(random.between(-1, 1));
  }
  TangentLinearized<Scalar> linearized(at.bodies, at.tangents);
  linearized.factor(s);
  linearized.solve(rhs.data(), rhs.data() + n, x.data(), x.data() + n);

  const auto wide = [](const Vector& a) {
    return test::ComplexVector(a.template cast<std::complex<double>>().template cast<WideComplex>());
  };
  test::ComplexMatrix system = test::ComplexMatrix::Identity(2 * n, 2 * n) * WideComplex(s);
  system.topRightCorner(n, n) -= test::ComplexMatrix::Identity(n, n);
  system.bottomRows(n) -= slopes.topRows(n).cast<WideComplex>();
  const test::ComplexVector exact = system.partialPivLu().solve(wide(rhs));
  EXPECT_LT(errorOf(wide(x).head(n), exact.head(n)), tolerance) << "u, s = " << s;
  EXPECT_LT(errorOf(wide(x).tail(n), exact.tail(n)), tolerance) << "v, s = " << s;

  // δμ and δF_pin along it
  const test::ComplexVector change = slopes.cast<WideComplex>() * exact;
  const Vector moments = Eigen::Map<const Vector>(linearized.moments().data(), n);
  EXPECT_LT(errorOf(wide(moments), change.segment(n, n)), tolerance) << "moments, s = " << s;
  const Vector force = (Vector(2) << linearized.pinForce().x, linearized.pinForce().y).finished();
  EXPECT_LT(errorOf(wide(force), change.segment(2 * n, 2)), tolerance) << "force of the base, s = " << s;

  linearized.solve(rhs.data(), rhs.data() + n, rhs.data(), rhs.data() + n);
  EXPECT_EQ(rhs, x) << "in place";
}

TEST(TangentLinearized, InvertsTheJacobianOfRandomChains) {
  // The dense road has 19 digits, so this is the recursion's rounding: at most 5e-13, for small s where
  // s·1 − J may be nearly singular.
  const Kind free{0, 0, 0}, springs{0, 0, 1}, rotors{0.5, 0, 1}, all{0.5, 0.3, 1}, held{0, 1, 1};
  unsigned seed = 0;
  for (const Kind& kind : {free, springs, rotors, all, held}) {
    for (int n = 1; n <= 12; ++n) {
      const RandomChain chain(n, ++seed, kind);
      const Linear at(chain);
      const test::WideMatrix slopes = chain.slopes(at.y);
      Random random(seed);
      for (const double s : {2.3, 40.0, 1e3}) {
        SCOPED_TRACE(testing::Message() << n << " bodies, seed " << seed);
        compare(at, slopes, s, random, 4e-12);
        compare(at, slopes, std::complex<double>(s, 2 * s), random, 4e-12);
      }
    }
  }
}

TEST(TangentLinearized, IsTheCoupledOneWithoutSuchForces) {
  // The same sums in another order.
  for (int n = 1; n <= 12; ++n) {
    const RandomChain chain(n, static_cast<unsigned>(n), {0.5, 0.3, 1, 0});
    const Linear at(chain);
    CoupledLinearized<double> coupled(at.bodies);
    TangentLinearized<double> tangent(at.bodies, at.tangents);
    Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(2 * n, -1, 2), other = x;
    coupled.factor(30);
    tangent.factor(30);
    coupled.solve(x.data(), x.data() + n, x.data(), x.data() + n);
    tangent.solve(other.data(), other.data() + n, other.data(), other.data() + n);
    EXPECT_LT((x - other).cwiseAbs().maxCoeff(), 1e-13 * x.cwiseAbs().maxCoeff()) << n << " bodies";
  }
}

}  // namespace
}  // namespace planar_chain
