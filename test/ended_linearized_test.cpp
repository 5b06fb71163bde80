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
using test::Vector2;
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

/// The change of the force on the base, and of its moment about the ground pin: of that on the first body,
/// and of what moves the slides.
struct OnBase {
  Vector2 force;
  WideComplex moment;
};
OnBase onBase(const RandomChain& chain, const test::DenseChain::Answer& answer, const ComplexVector& along,
              const ComplexVector& change) {
  const Eigen::Index n = chain.size(), slides = chain.places() - n;
  const ComplexVector at = chain.state().cast<WideComplex>();
  const Vector2 base = test::DenseChain::wide(chain.base);
  Vector2 slid = Vector2::Zero(), pushed = Vector2::Zero();
  OnBase sum{};
  // What is carried is linear in the state.
  const ComplexVector more = at + along;
  const auto slope = [&](auto of) { return Vector2(of(more) - of(at)); };
  for (Eigen::Index i = 0; i <= slides; ++i) {
    const int k = static_cast<int>(i);
    const auto carried = [&](const ComplexVector& y) { return chain.carried(y, k, {}); };
    const Vector2 X = carried(at).x - base, dX = slope([&](const ComplexVector&y) { return carried(y).x; });
    Vector2 f, df;
    if (i == slides) {
      f = answer.forces.head<2>();
      df = change.segment<2>(2 * n);
    } else {
      const test::DenseSlide& slide = chain.slides[index(k)];
      const Vector2 d = test::DenseChain::wide(slide.of.d), v = carried(at).v;
      slid += answer.slides[i] * d;
      pushed += change[4 * n + i] * d;
      const auto Kd = slide.K.cast<WideComplex>(), Dd = slide.D.cast<WideComplex>();
      const WideComplex m(slide.of.mass);
      f = m * (carried(at).a + slid - test::DenseChain::wide(chain.gravity)) + Kd * carried(at).x + Dd * v;
      df = m * (slope([&](const ComplexVector& y) { return carried(y).a; }) + pushed) + Kd * dX +
           Dd * slope([&](const ComplexVector& y) { return carried(y).v; });
    }
    sum.force += df;
    sum.moment += test::crossed(X, df) + test::crossed(dX, f);
  }
  return sum;
}

/// On a base that turns.
void turn(const RandomChain& chain, const AtState& at, EndsTangent& ends) {
  const ComplexVector state = chain.state().cast<WideComplex>();
  ends.turns = true;
  ends.rate = chain.baseRate;
  ends.turning = chain.baseTurning;
  Vec2d a;
  for (std::size_t i = 0; i <= chain.slides.size(); ++i) {
    const test::Carried own = chain.carried(state, static_cast<int>(i), {});
    const Vec2d X = RandomChain::narrow(own.x) - chain.base;
    if (i == chain.slides.size()) {
      ends.firstPin = X;
      continue;
    }
    const test::DenseSlide& slide = chain.slides[i];
    a += RandomChain::real(at.answer.slides[static_cast<Eigen::Index>(i)]) * slide.of.d;
    ends.place[i] = X;
    ends.force[i] =
        slide.of.mass * (RandomChain::narrow(own.a) + a - chain.gravity) +
        RandomChain::narrow(slide.K.cast<WideComplex>() * own.x + slide.D.cast<WideComplex>() * own.v);
  }
  ends.pinForce = RandomChain::narrow(at.answer.forces.head<2>());
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
  EndsTangent ends;
  ends.inner = chain.innerEnd();
  ends.tip = chain.heldTip();
  for (std::size_t i = 0; i < chain.slides.size(); ++i) {
    ends.stiffness[i] = chain.slides[i].stiffness;
    ends.damping[i] = chain.slides[i].damping;
    const auto matrix = [](const Eigen::Matrix2d& M) { return Matrix2d{M(0, 0), M(0, 1), M(1, 0), M(1, 1)}; };
    ends.ofPlace[i] = matrix(chain.slides[i].K);
    ends.ofVelocity[i] = matrix(chain.slides[i].D);
  }
  turn(chain, at, ends);
  EndedLinearized<Scalar, kinds> linearized(bodies, at.tangents.data(), ends);
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
  const OnBase base = onBase(chain, at.answer, exact, change);
  EXPECT_LT(errorOf(wide(std::vector{pin.x, pin.y}), base.force, all), tolerance) << "s = " << s;
  if (slides > 0) {
    ComplexVector moment(1);
    moment << base.moment;
    EXPECT_LT(errorOf(wide(std::vector{linearized.baseMoment()}), moment, all), tolerance) << "s = " << s;
  }
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
  test::forAllEnds(
      forces,
      [](const RandomChain& chain, unsigned seed) {
        const AtState at(chain);
        const test::WideMatrix slopes = chain.slopes(chain.state());
        for (const double s : {2.3, 40.0, 1e3}) {
          compare<kinds>(chain, at, slopes, s, seed);
          compare<kinds>(chain, at, slopes, std::complex<double>(s, 2 * s), seed);
        }
      },
      1);
}

TEST(EndedLinearized, InvertsTheJacobianWhereForcesDependOnPlaceAndVelocity) {
  compareAll<3>(1);
}

TEST(EndedLinearized, InvertsTheJacobianWhereTheyDoNot) {
  compareAll<1>(0);
}

}  // namespace
}  // namespace planar_chain
