/// The exact solve of chains whose forces depend on place and velocity, against Newton's and Euler's
/// equations with all pin forces as unknowns, differentiated by complex step in long double.

#include <gtest/gtest.h>

#include "random_dense_chain.h"
#include "recursion/coupled_linearized.h"

namespace planar_chain {
namespace {

using test::AtState;
using test::errorOf;
using test::Kind;
using test::Random;
using test::RandomChain;
using test::WideComplex;

template <class Scalar>
void compare(const AtState& at, const test::WideMatrix& slopes, Scalar s, Random& random, double tolerance) {
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  const Eigen::Index n = slopes.cols() / 2;
  Vector rhs(2 * n), x(2 * n);
  for (Eigen::Index i = 0; i < rhs.size(); ++i) {
    rhs[i] = random.between(-1, 1);
    if constexpr (!std::is_same_v<Scalar, double>) rhs[i].imag(random.between(-1, 1));
  }
  CoupledBodies bodies(at.chain);
  bodies.take(at.state);
  CoupledLinearized<Scalar, 3> linearized(bodies, at.tangents.data());
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
  Vector moments(n);
  for (int i = 0; i < n; ++i) moments[i] = linearized.moment(i);
  EXPECT_LT(errorOf(wide(moments), change.segment(n, n)), tolerance) << "moments, s = " << s;
  const Vector force = (Vector(2) << linearized.pinForce().x, linearized.pinForce().y).finished();
  EXPECT_LT(errorOf(wide(force), change.segment(2 * n, 2)), tolerance) << "force of the base, s = " << s;

  linearized.solve(rhs.data(), rhs.data() + n, rhs.data(), rhs.data() + n);
  EXPECT_EQ(rhs, x) << "in place";
}

TEST(CoupledLinearized, InvertsTheJacobianOfRandomChains) {
  // The dense road has 19 digits, so this is the recursion's rounding: at most 5e-13, for small s where
  // s·1 − J may be nearly singular.
  const Kind free{0, 0, 0}, springs{0, 0, 1}, rotors{0.5, 0, 1}, all{0.5, 0.3, 1}, held{0, 1, 1};
  unsigned seed = 0;
  for (const Kind& kind : {free, springs, rotors, all, held}) {
    for (int n = 1; n <= 12; ++n) {
      const RandomChain chain(n, ++seed, kind);
      const AtState at(chain);
      const test::WideMatrix slopes = chain.slopes(chain.state());
      Random random(seed);
      for (const double s : {2.3, 40.0, 1e3}) {
        SCOPED_TRACE(testing::Message() << n << " bodies, seed " << seed);
        compare(at, slopes, s, random, 4e-12);
        compare(at, slopes, std::complex<double>(s, 2 * s), random, 4e-12);
      }
    }
  }
}

TEST(CoupledLinearized, TakesOneKindOfMotionWithoutSuchForces) {
  // The same sums in another order.
  for (int n = 1; n <= 12; ++n) {
    const RandomChain chain(n, static_cast<unsigned>(n), {0.5, 0.3, 1, 0});
    const AtState at(chain);
    CoupledBodies bodies(at.chain);
    bodies.take(at.state);
    CoupledLinearized<double, 1> coupled(bodies, at.tangents.data());
    CoupledLinearized<double, 3> tangent(bodies, at.tangents.data());
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
