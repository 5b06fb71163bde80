/// The exact solve of chains with joints of any kind anywhere, against Newton's and Euler's equations with
/// all pin forces as unknowns, differentiated by complex step in long double.

#include "recursion/general_linearized.h"

#include <gtest/gtest.h>

#include "random_dense_chain.h"

namespace planar_chain {
namespace {

using test::AtState;
using test::ComplexVector;
using test::errorOf;
using test::Random;
using test::RandomChain;
using test::WideComplex;

template <class Scalar>
ComplexVector wide(const std::vector<Scalar>& a) {
  ComplexVector to(static_cast<Eigen::Index>(a.size()));
  for (std::size_t i = 0; i < a.size(); ++i) to[static_cast<Eigen::Index>(i)] = WideComplex(a[i]);
  return to;
}

template <std::size_t kinds, class Scalar>
void compare(const RandomChain& chain, const AtState& at, const test::WideMatrix& slopes, Scalar s,
             unsigned seed, double tolerance) {
  const auto n = index(chain.size());
  const auto size = static_cast<Eigen::Index>(n);
  Random random(seed);
  std::vector<Scalar> rhs, x(2 * n);
  for (std::size_t i = 0; i < 2 * n; ++i) {
    Scalar number(random.between(-1, 1));
    if constexpr (!std::is_same_v<Scalar, double>) number.imag(random.between(-1, 1));
    rhs.push_back(number);
  }
  GeneralBodies bodies(at.chain);
  bodies.take(at.state);
  const auto solve =
      makeGeneralSolve<Scalar>(bodies, kinds == 3 ? at.tangents.data() : nullptr, chain.tip.rows > 0, true);
  GeneralSolve<Scalar>& linearized = *solve;
  linearized.factor(s);
  linearized.solve(rhs.data(), rhs.data() + n, x.data(), x.data() + n);

  test::ComplexMatrix system = test::ComplexMatrix::Identity(2 * size, 2 * size) * WideComplex(s);
  system.topRightCorner(size, size) -= test::ComplexMatrix::Identity(size, size);
  system.bottomRows(size) -= slopes.topRows(size).cast<WideComplex>();
  const ComplexVector exact = system.partialPivLu().solve(wide(rhs)), is = wide(x);
  EXPECT_LT(errorOf(is.head(size), exact.head(size)), tolerance) << "u, s = " << s;
  EXPECT_LT(errorOf(is.tail(size), exact.tail(size)), tolerance) << "v, s = " << s;

  // How moments and forces change along it.
  const ComplexVector change = slopes.cast<WideComplex>() * exact, all = change.tail(change.size() - size);
  std::vector<Scalar> moments;
  for (int i = 0; i < size; ++i) {
    const bool isAsked = chain.laws[index(i)].isPrescribed;
    moments.push_back(isAsked ? linearized.moment(i) : Scalar{});
  }
  ComplexVector asked = change.segment(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    if (!chain.laws[index(static_cast<int>(i))].isPrescribed) asked[i] = 0;
  }
  EXPECT_LT(errorOf(wide(moments), asked, all), tolerance) << "moments, s = " << s;
  const Vec2<Scalar> base = linearized.baseForce(), tip = linearized.tipForce();
  EXPECT_LT(errorOf(wide(std::vector{base.x, base.y}), change.segment(2 * size, 2), all), tolerance) << s;
  EXPECT_LT(errorOf(wide(std::vector{tip.x, tip.y}), change.segment(4 * size, 2), all), tolerance) << s;
  EXPECT_LT(errorOf(wide(std::vector{linearized.baseMoment()}), change.tail(1), all), tolerance) << s;
  linearized.solve(rhs.data(), rhs.data() + n, rhs.data(), rhs.data() + n);
  EXPECT_EQ(rhs, x) << "in place";
}

template <std::size_t kinds>
void compareAll(double forces, bool tips, double tolerance) {
  test::forAllKinds(
      forces,
      [=](const RandomChain& chain, unsigned seed) {
        const AtState at(chain);
        const test::WideMatrix slopes = chain.slopes(chain.state());
        for (const double s : {2.3, 40.0, 1e3}) {
          compare<kinds>(chain, at, slopes, s, seed, tolerance);
          compare<kinds>(chain, at, slopes, std::complex<double>(s, 2 * s), seed, tolerance);
        }
      },
      tips);
}

// The dense road has 19 digits, so this is the recursion's rounding, largest for small s where s·1 − J may be
// nearly singular, and beside tips whose rows hold nearly all that can move.

TEST(GeneralLinearized, InvertsTheJacobianWhereForcesDependOnPositionAndVelocity) {
  compareAll<3>(1, true, 1e-9);
}

TEST(GeneralLinearized, InvertsTheJacobianWhereTheyDoNot) {
  compareAll<1>(0, true, 1e-9);
}

TEST(GeneralLinearized, TakesOneKindOfMotionWithoutSuchForces) {
  // The sums are equal but for their order.
  for (int n = 1; n <= 12; ++n) {
    const RandomChain chain(n, static_cast<unsigned>(n), {0.5, 0.3, 1, 0, 0.3});
    const AtState at(chain);
    GeneralBodies bodies(at.chain);
    bodies.take(at.state);
    GeneralLinearized<double, 1, true> one(bodies, nullptr, false, true);
    GeneralLinearized<double, 3, true> three(bodies, at.tangents.data(), false, true);
    Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(2 * n, -1, 2), other = x;
    one.factor(30);
    three.factor(30);
    one.solve(x.data(), x.data() + n, x.data(), x.data() + n);
    three.solve(other.data(), other.data() + n, other.data(), other.data() + n);
    EXPECT_LT((x - other).cwiseAbs().maxCoeff(), 1e-13 * x.cwiseAbs().maxCoeff()) << n << " bodies";
  }
}

TEST(GeneralLinearized, AsksNothingOfWhatDoesNotTurn) {
  // The general road where a base at rest might turn: as far as nothing inside turns, the same sums.
  int carriages = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    RandomChain chain(4 + static_cast<int>(seed % 4), seed,
                      {0.5, 0.2, 1, 1, 0.8, static_cast<int>(seed % 3)});
    chain.baseTurning = chain.baseRate = 0;
    const AtState at(chain);
    carriages += at.chain.coordinates().leading();
    GeneralBodies bodies(at.chain);
    bodies.take(at.state);
    const auto compareAs = [&](auto kinds) {
      using Solve = GeneralLinearized<double, kinds(), true>;
      const bool holdsTip = chain.tip.rows > 0;
      Solve less(bodies, at.tangents.data(), holdsTip, false),
          whole(bodies, at.tangents.data(), holdsTip, true);
      const int n = chain.size();
      Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(2 * n, -1, 2), other = x;
      less.factor(30);
      whole.factor(30);
      less.solve(x.data(), x.data() + n, x.data(), x.data() + n);
      whole.solve(other.data(), other.data() + n, other.data(), other.data() + n);
      EXPECT_LT((x - other).cwiseAbs().maxCoeff(), 1e-12 * x.cwiseAbs().maxCoeff()) << seed;
      for (int i = 0; i < n; ++i) {
        if (!chain.laws[index(i)].isPrescribed) continue;
        EXPECT_NEAR(less.moment(i), whole.moment(i), 1e-11 * (1 + std::abs(whole.moment(i)))) << seed;
      }
    };
    compareAs(std::integral_constant<std::size_t, 1>());
    compareAs(std::integral_constant<std::size_t, 3>());
  }
  EXPECT_GT(carriages, 20);
}

}  // namespace
}  // namespace planar_chain
