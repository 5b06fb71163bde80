/// The exact solve of chains with ends, against Newton's and Euler's equations with all pin forces as
/// unknowns, differentiated by complex step in long double.

#include "recursion/ended_linearized.h"

#include <gtest/gtest.h>

#include <algorithm>

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

/// x has the slides before the bodies, the dense equations behind them.
template <class Scalar>
ComplexVector bodiesFirst(std::vector<Scalar> x, std::size_t slides) {
  const auto half = static_cast<std::ptrdiff_t>(x.size() / 2), first = static_cast<std::ptrdiff_t>(slides);
  std::rotate(x.begin(), x.begin() + first, x.begin() + half);
  std::rotate(x.begin() + half, x.begin() + half + first, x.end());
  return wide(x);
}

/// J, of the places of bodies and slides and their rates.
test::ComplexMatrix jacobian(const RandomChain& chain, const test::WideMatrix& slopes) {
  const Eigen::Index n = chain.size(), places = chain.places(), slides = places - n;
  test::ComplexMatrix J = test::ComplexMatrix::Zero(2 * places, 2 * places);
  J.topRightCorner(places, places).setIdentity();
  J.middleRows(places, n) = slopes.topRows(n).cast<WideComplex>();
  J.bottomRows(slides) = slopes.middleRows(4 * n, slides).cast<WideComplex>();
  return J;
}

/// The change of the force on the base: of that on the first body, and of what moves the slides.
ComplexVector onBase(const RandomChain& chain, const ComplexVector& change) {
  const Eigen::Index n = chain.size(), slides = chain.places() - n;
  const InnerEnd<double> inner = chain.innerEnd();
  ComplexVector force = change.segment(2 * n, 2), acceleration = ComplexVector::Zero(2);
  for (Eigen::Index i = 0; i < slides; ++i) {
    const Slide<double>& slide = inner.slide[index(static_cast<int>(i))];
    acceleration += change[4 * n + i] * Eigen::Vector2d(slide.d.x, slide.d.y).cast<WideComplex>();
    force += WideComplex(slide.mass) * acceleration;
  }
  return force;
}

template <std::size_t kinds, class Scalar>
void compare(const RandomChain& chain, const AtState& at, const test::WideMatrix& slopes, Scalar s,
             unsigned seed) {
  const auto n = index(chain.size()), places = index(chain.places());
  Random random(seed);
  std::vector<Scalar> rhs, x(2 * places);
  for (std::size_t i = 0; i < 2 * places; ++i) {
    Scalar number(random.between(-1, 1));
    if constexpr (!std::is_same_v<Scalar, double>) number.imag(random.between(-1, 1));
    rhs.push_back(number);
  }
  CoupledBodies bodies(at.chain);
  bodies.take(at.state);
  EndsTangent ends{chain.innerEnd(), {}, {}, chain.heldTip()};
  for (std::size_t i = 0; i < chain.slides.size(); ++i) {
    ends.stiffness[i] = chain.slides[i].stiffness;
    ends.damping[i] = chain.slides[i].damping;
  }
  EndedLinearized<Scalar, kinds> linearized(bodies, at.tangents, ends);
  linearized.factor(s);
  linearized.solve(rhs.data(), rhs.data() + places, x.data(), x.data() + places);

  const test::ComplexMatrix J = jacobian(chain, slopes);
  const test::ComplexMatrix system = test::ComplexMatrix::Identity(J.rows(), J.cols()) * WideComplex(s) - J;
  const ComplexVector exact = system.partialPivLu().solve(bodiesFirst(rhs, places - n)),
                      is = bodiesFirst(x, places - n);
  const auto size = static_cast<Eigen::Index>(places), count = static_cast<Eigen::Index>(n);
  const double tolerance = 1e-9;
  EXPECT_LT(errorOf(is.head(size), exact.head(size)), tolerance) << "u, s = " << s;
  EXPECT_LT(errorOf(is.tail(size), exact.tail(size)), tolerance) << "v, s = " << s;

  // How moments and forces change along it.
  const ComplexVector change = slopes.cast<WideComplex>() * exact, all = change.tail(change.size() - count);
  const auto slides = size - count;
  std::vector<Scalar> slideForces, moments;
  for (int i = 0; i < size; ++i) (i < slides ? slideForces : moments).push_back(linearized.moment(i));
  const Vec2<Scalar> pin = linearized.pinForce(), tip = linearized.tipForce();
  EXPECT_LT(errorOf(wide(moments), change.segment(count, count), all), tolerance) << "s = " << s;
  EXPECT_LT(errorOf(wide(std::vector{pin.x, pin.y}), onBase(chain, change), all), tolerance) << "s = " << s;
  EXPECT_LT(errorOf(wide(std::vector{tip.x, tip.y}), change.tail(2), all), tolerance) << "s = " << s;
  if (slides > 0) {
    EXPECT_LT(errorOf(wide(slideForces), change.segment(4 * count + slides, slides), all), tolerance)
        << "s = " << s;
  }
  linearized.solve(rhs.data(), rhs.data() + places, rhs.data(), rhs.data() + places);
  EXPECT_EQ(rhs, x) << "in place";
}

template <std::size_t kinds>
void compareAll(double forces) {
  test::forAllEnds(forces, [](const RandomChain& chain, unsigned seed) {
    const AtState at(chain);
    const test::WideMatrix slopes = chain.slopes(chain.state());
    for (const double s : {2.3, 40.0, 1e3}) {
      compare<kinds>(chain, at, slopes, s, seed);
      compare<kinds>(chain, at, slopes, std::complex<double>(s, 2 * s), seed);
    }
  });
}

TEST(EndedLinearized, InvertsTheJacobianWhereForcesDependOnPlaceAndVelocity) {
  compareAll<3>(1);
}

TEST(EndedLinearized, InvertsTheJacobianWhereTheyDoNot) {
  compareAll<1>(0);
}

}  // namespace
}  // namespace planar_chain
