/// The kernels in SIMD lanes: every one that this CPU runs, against long double and the recursion link by
/// link.

#include "lanes/segments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "lanes/kernel.h"
#include "lanes/linearized_segments.h"
#include "lanes/short_chain.h"
#include "support/articulated.h"
#include "support/linearized.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

using test::Random;
using test::randomScene;

/// How far a is from exact, in units in the last place of exact.
double ulps(double a, long double exact) {
  const double size = std::abs(static_cast<double>(exact));
  return static_cast<double>(std::abs(a - exact)) / (std::nextafter(size, 2) - size);
}

TEST(Rotations, AreExactToAnUlpOrSoForAnyAngle) {
  // Small and large, near multiples of π/2, a million turns, and beyond where π/2 is taken off in lanes.
  Random random(1);
  for (const simd::Kernel* kernel : simd::kernels()) {
    for (const double size : {1e-300, 1e-8, 1.0, 30.0, 1e4, 6.3e6, 0.99e9, 1e15, 1e300}) {
      for (int k = 0; k < 4000; ++k) {
        constexpr int n = 11;
        double theta[n], e[2 * n];
        for (double& angle : theta) {
          angle = random.between(-size, size);
          if (k % 2 == 0 && size < 1e9) angle = std::round(angle / M_PI_2) * M_PI_2;
        }
        kernel->rotations(theta, e, n);
        for (int j = 0; j < n; ++j) {
          const long double exact = theta[j];
          ASSERT_LT(ulps(e[2 * j], std::cos(exact)), 1.5) << kernel->name << " cos " << theta[j];
          ASSERT_LT(ulps(e[2 * j + 1], std::sin(exact)), 1.5) << kernel->name << " sin " << theta[j];
        }
      }
    }
    double odd[3] = {std::numeric_limits<double>::infinity(), std::nan(""), -0.0}, e[6];
    kernel->rotations(odd, e, 3);
    EXPECT_TRUE(std::isnan(e[0]) && std::isnan(e[1]) && std::isnan(e[2]) && std::isnan(e[3]));
    EXPECT_EQ(e[4], 1);
    EXPECT_EQ(e[5], 0);  // of either sign
  }
}

/// Where body j stands among the segments, side by side.
std::size_t laneIndexOf(std::size_t j, const LaneOrder& order) {
  const auto steps = static_cast<std::size_t>(order.steps()), lanes = static_cast<std::size_t>(order.lanes());
  return j % steps * lanes + j / steps;
}

template <class T>
std::vector<T> laneOrdered(const std::vector<T>& values, const LaneOrder& order, T beyond = {}) {
  std::vector<T> all(static_cast<std::size_t>(order.paddedSize()), beyond);
  for (std::size_t j = 0; j < values.size(); ++j) all[laneIndexOf(j, order)] = values[j];
  return all;
}

template <class T>
std::vector<T> restored(const T* all, std::size_t n, const LaneOrder& order) {
  std::vector<T> values;
  for (std::size_t j = 0; j < n; ++j) values.push_back(all[laneIndexOf(j, order)]);
  return values;
}

TEST(LaneOrder, PutsSegmentsSideBySide) {
  for (const simd::Kernel* kernel : simd::kernels()) {
    for (const int n : {1, 2, 3, 4, 5, 7, 8, 9, 13, 31, 63, 64, 65, 100, 127, 129, 1000, 1024, 4096}) {
      const LaneOrder order(n, kernel->lanes);
      ASSERT_GE(order.paddedSize(), n);
      std::vector<double> values;
      std::vector<Vec2d> vectors;
      for (int j = 1; j <= n; ++j) values.push_back(j), vectors.push_back({1.0 * j, -2.0 * j});
      std::vector<double> there(static_cast<std::size_t>(order.paddedSize()) + 1, std::nan("")),
          back(values.size() + 1, -1);
      order.toLaneOrder(values.data(), there.data());
      ASSERT_TRUE(std::isnan(there.back())) << "written too far";
      there.pop_back();
      ASSERT_EQ(there, laneOrdered(values, order)) << kernel->name << " " << n;
      order.toChainOrder(there.data(), back.data());
      ASSERT_EQ(back.back(), -1) << "written too far";
      back.pop_back();
      ASSERT_EQ(back, values) << kernel->name << " " << n;

      std::vector<Vec2d> vectorsThere(there.size(), {1, 1});
      order.toLaneOrder(vectors.data(), vectorsThere.data());
      ASSERT_EQ(vectorsThere, laneOrdered(vectors, order));
    }
  }
}

/// A chain in motion, with what acts on it.
struct Moving {
  Chain chain;
  std::vector<Rotation<double>> e;
  std::vector<double> omega, N;
  std::vector<Vec2d> F;

  /// Only what acts.
  const double* moments(LoadKind acting) const { return acting == LoadKind::nothing ? nullptr : N.data(); }
  const Vec2d* forces(LoadKind acting) const { return acting == LoadKind::forces ? F.data() : nullptr; }
};

constexpr LoadKind everything[] = {LoadKind::nothing, LoadKind::moments, LoadKind::forces};

Moving randomMotion(int n, unsigned seed, double bend) {
  const Scene scene = randomScene(n, seed);
  Random random(seed);
  Moving moving{scene.chain, {}, {}, {}, {}};
  double theta = 0;
  for (int j = 0; j < n; ++j) {
    theta += random.between(-bend, bend);
    moving.e.push_back(Rotation<double>::of(theta));
    moving.omega.push_back(random.between(-3, 3));
    moving.N.push_back(random.between(-2, 2));
    moving.F.push_back(random.vector(5));
  }
  return moving;
}

template <class To, class From>
std::vector<To> converted(const std::vector<From>& from) {
  return {from.begin(), from.end()};
}

/// The recursion in long double.
std::vector<long double> exactly(const Moving& moving, LoadKind acting, Vec2d ground) {
  std::vector<Rotation<long double>> e;
  std::vector<Vec2<long double>> F;
  for (const auto& rotation : moving.e) e.push_back({rotation.c, rotation.s});
  for (const Vec2d& force : moving.F) F.push_back({force.x, force.y});
  const std::vector<long double> N = converted<long double>(moving.N);
  std::vector<long double> alpha(moving.e.size());
  Articulated<long double>(moving.chain)
      .accelerations(e.data(), converted<long double>(moving.omega).data(),
                     moving.moments(acting) ? N.data() : nullptr, moving.forces(acting) ? F.data() : nullptr,
                     {ground.x, ground.y}, alpha.data());
  return alpha;
}

/// Worst error of α, against the largest α.
double errorOf(const std::vector<double>& alpha, const std::vector<long double>& exact) {
  long double worst = 0, size = 0;
  for (std::size_t j = 0; j < alpha.size(); ++j) {
    worst = std::max(worst, std::abs(exact[j] - alpha[j]));
    size = std::max(size, std::abs(exact[j]));
  }
  return static_cast<double>(worst / size);
}

/// α by segments.
std::vector<double> bySegments(const Moving& moving, const simd::Kernel* kernel, const double* N,
                               const Vec2d* F, Vec2d ground) {
  Segments segments(moving.chain, *kernel);
  const LaneOrder& order = segments.laneOrder();
  const auto e = laneOrdered(moving.e, order, {1, 0});
  const auto omega = laneOrdered(moving.omega, order);
  const auto moments = N ? laneOrdered(moving.N, order) : std::vector<double>();
  const auto forces = F ? laneOrdered(moving.F, order) : std::vector<Vec2d>();
  std::vector<double> alpha(e.size(), std::nan(""));
  segments.accelerations(e.data(), omega.data(), N ? moments.data() : nullptr, F ? forces.data() : nullptr,
                         ground, alpha.data());
  std::vector<double> inOrder = restored(alpha.data(), moving.e.size(), order);
  EXPECT_EQ(laneOrdered(inOrder, order), alpha) << "0 beyond the end";
  return inOrder;
}

TEST(Segments, AreAsExactAsTheRecursionLinkByLink) {
  // Every length up to a few segments, so that the last ones are full, short or empty; then long ones,
  // straight and crooked, where what a segment passes on becomes too small to be told.
  std::vector<int> lengths;
  for (int n = 1; n <= 40; ++n) lengths.push_back(n);
  for (const int n : {100, 1000, 1024, 10000}) lengths.push_back(n);
  for (const int n : lengths) {
    for (const double bend : {0.01, 1.0}) {
      for (const LoadKind acting : everything) {
        const Moving moving = randomMotion(n, static_cast<unsigned>(n), bend);
        const Vec2d ground{1, 9.81};
        const std::vector<long double> exact = exactly(moving, acting, ground);
        const double* N = moving.moments(acting);
        const Vec2d* F = moving.forces(acting);
        std::vector<double> alpha(static_cast<std::size_t>(n));
        Articulated<double>(moving.chain)
            .accelerations(moving.e.data(), moving.omega.data(), N, F, ground, alpha.data());
        const double own = errorOf(alpha, exact);
        for (const simd::Kernel* kernel : simd::kernels()) {
          ASSERT_LT(errorOf(bySegments(moving, kernel, N, F, ground), exact), 20 * own + 1e-14)
              << kernel->name << " " << n << " " << bend;
        }
      }
    }
  }
}

TEST(ShortChains, AreAsExactAsTheRecursionLinkByLink) {
  for (int n = 1; n <= ShortChain::most; ++n) {
    const auto size = static_cast<std::size_t>(n);
    for (const double bend : {0.01, 1.0}) {
      for (const LoadKind acting : everything) {
        Moving moving = randomMotion(n, static_cast<unsigned>(100 + n), bend);
        std::vector<double> y, dydt(2 * size), alpha(size);
        for (Rotation<double>& e : moving.e) {
          y.push_back(std::atan2(e.s, e.c));
          e = Rotation<double>::of(y.back());
        }
        y.insert(y.end(), moving.omega.begin(), moving.omega.end());
        const Vec2d ground{1, 9.81};
        const std::vector<long double> exact = exactly(moving, acting, ground);
        Articulated<double>(moving.chain)
            .accelerations(moving.e.data(), moving.omega.data(), moving.moments(acting),
                           moving.forces(acting), ground, alpha.data());
        const double own = errorOf(alpha, exact);
        for (const simd::Kernel* kernel : simd::kernels()) {
          std::vector<Rotation<double>> e(static_cast<std::size_t>(ShortChain::roomFor(n)), {0, 0});
          if (acting == LoadKind::forces) std::copy(moving.e.begin(), moving.e.end(), e.begin());
          std::fill(dydt.begin(), dydt.end(), std::nan(""));
          ShortChain(moving.chain, *kernel)
              .derivative(acting, {e.data(), moving.moments(acting), moving.forces(acting), ground}, y.data(),
                          dydt.data());
          std::copy(dydt.begin() + n, dydt.end(), alpha.begin());
          ASSERT_LT(errorOf(alpha, exact), 20 * own + 1e-14) << kernel->name << " " << n << " " << bend;
          for (std::size_t j = 0; j < size; ++j) {
            ASSERT_EQ(dydt[j], moving.omega[j]);
            ASSERT_NEAR(e[j].c, moving.e[j].c, 3e-16);
            ASSERT_NEAR(e[j].s, moving.e[j].s, 3e-16);
          }
        }
      }
    }
  }
}

TEST(ShortChains, KnowAngleAndNumberOfAnySize) {
  // Beyond what is reduced in lanes the library is asked; what is not finite comes out as not finite.
  for (int n = 1; n <= ShortChain::most; ++n) {
    const auto size = static_cast<std::size_t>(n);
    const Moving moving = randomMotion(n, 1, 1);
    std::vector<Rotation<double>> e(static_cast<std::size_t>(ShortChain::roomFor(n)));
    std::vector<double> y(2 * size, 1e15), dydt(2 * size);
    for (const simd::Kernel* kernel : simd::kernels()) {
      ShortChain chain(moving.chain, *kernel);
      const auto run = [&] {
        chain.derivative(LoadKind::nothing, {e.data(), nullptr, nullptr, {0, 9.81}}, y.data(), dydt.data());
      };
      run();
      for (std::size_t j = 0; j < size; ++j) EXPECT_EQ(e[j].c, std::cos(1e15));
      y[size - 1] = std::nan("");
      run();
      EXPECT_TRUE(std::isnan(dydt[size]));
      y[size - 1] = 1e15;
    }
  }
}

/// A taut thread of rods in rotation, bent a little.
Moving taut(int n, double tipMass, double bend, unsigned seed) {
  const double l = 1.0 / n;
  std::vector<Link> links(static_cast<std::size_t>(n), {"", 1, l * l / 12, {l / 2, 0}, {l, 0}});
  std::vector<Joint> joints(links.size());
  for (std::size_t j = 0; j < links.size(); ++j) {
    links[j].name = "link" + std::to_string(j);
    joints[j].name = "joint" + std::to_string(j);
  }
  links.back().mass = tipMass;
  Moving moving{Chain(links, joints, {9.81, 0}), {}, {}, std::vector<double>(links.size()), {}};
  Random random(seed);
  for (int j = 0; j < n; ++j) {
    moving.e.push_back(
        Rotation<double>::of(0.4 + 0.1 * seed + bend * (std::sin(7 * j * l) + random.between(-0.01, 0.01))));
    moving.omega.push_back(1.3 + bend * std::cos(9 * j * l));
  }
  return moving;
}

double medianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

TEST(Segments, AreAsExactWhereTheThreadIsTaut) {
  // What a segment gives way along a thread that is all but straight is next to nothing, and met by all the
  // mass outside.
  for (const int n : {20, 200, 10000}) {
    for (const double tipMass : {1.0, 1e5, 2e8}) {
      for (const double bend : {1e-9, 1e-6, 1e-3}) {
        // Where rounding alone decides, one state says nothing: the median of several does.
        constexpr unsigned states = 15;
        const Vec2d ground{-9.81, 0};
        std::vector<double> own;
        std::map<const simd::Kernel*, std::vector<double>> inSegments;
        for (unsigned seed = 0; seed < states; ++seed) {
          const Moving moving = taut(n, tipMass, bend, seed);
          const std::vector<long double> exact = exactly(moving, LoadKind::moments, ground);
          std::vector<double> alpha(static_cast<std::size_t>(n));
          Articulated<double>(moving.chain)
              .accelerations(moving.e.data(), moving.omega.data(), moving.N.data(), nullptr, ground,
                             alpha.data());
          own.push_back(errorOf(alpha, exact));
          for (const simd::Kernel* kernel : simd::kernels()) {
            inSegments[kernel].push_back(
                errorOf(bySegments(moving, kernel, moving.N.data(), nullptr, ground), exact));
          }
        }
        for (const auto& [kernel, errors] : inSegments) {
          EXPECT_LT(medianOf(errors), 3 * medianOf(own))
              << kernel->name << " " << n << " " << tipMass << " " << bend;
        }
      }
    }
  }
}

// ---- The exact solve -----------------------------------------------------------------------------

/// A state to linearize at, and a right-hand side.
struct Linear {
  Moving moving;
  std::vector<double> alpha, XF, k, d;
  double size;  ///< of s
};

Linear linearOf(Moving moving, double k, double d, double size) {
  const std::size_t n = moving.e.size();
  Linear at{std::move(moving), std::vector<double>(n), {}, {}, {}, size};
  Articulated<double>(at.moving.chain)
      .accelerations(at.moving.e.data(), at.moving.omega.data(), at.moving.N.data(), at.moving.F.data(),
                     -1.0 * at.moving.chain.gravity(), at.alpha.data());
  Random random(static_cast<unsigned>(n));
  for (std::size_t j = 0; j < n; ++j) {
    at.XF.push_back(random.between(-1, 1));
    at.k.push_back(j % 3 == 2 ? 0 : k * random.between(0.5, 1));
    at.d.push_back(j % 5 == 4 ? 0 : d * random.between(0.5, 1));
  }
  return at;
}

template <class Scalar>
std::vector<Scalar> randomSide(std::size_t n) {
  Random random(7);
  std::vector<Scalar> side(n);
  for (Scalar& component : side) component = static_cast<Scalar>(random.between(-1, 1));
  return side;
}

/// (s − J)⁻¹ of a right-hand side link by link, u and v in a row.
template <class Scalar>
std::vector<Scalar> solution(Linearized<Scalar>& solver, const Linear& at, Scalar s) {
  const std::size_t n = at.alpha.size();
  solver.setJoints(at.k.data(), at.d.data());
  solver.linearize(at.moving.e.data(), at.moving.omega.data(), at.alpha.data(), at.moving.F.data(),
                   at.XF.data());
  solver.factor(s);
  std::vector<Scalar> x = randomSide<Scalar>(2 * n);
  solver.solve(x.data(), x.data() + n, x.data(), x.data() + n);
  return x;
}

/// That solution by segments. inPlace: it overwrites the right-hand side.
template <class Scalar>
std::vector<Scalar> solution(LinearizedSegments<double>& real, LinearizedSegments<Scalar>& solver,
                             const Linear& at, Scalar s, bool inPlace) {
  const std::size_t n = at.alpha.size();
  const LaneOrder& order = solver.laneOrder();
  real.setJoints(laneOrdered(at.k, order).data(), laneOrdered(at.d, order).data());
  real.linearize(laneOrdered(at.moving.e, order, {1, 0}).data(), laneOrdered(at.moving.omega, order).data(),
                 laneOrdered(at.alpha, order).data(), laneOrdered(at.moving.F, order).data(),
                 laneOrdered(at.XF, order).data());
  solver.factor(s);
  const std::vector<Scalar> side = randomSide<Scalar>(2 * n);
  const auto half = static_cast<std::ptrdiff_t>(n);
  std::vector<Scalar> x = laneOrdered(std::vector<Scalar>(side.begin(), side.begin() + half), order);
  const std::vector<Scalar> rates = laneOrdered(std::vector<Scalar>(side.begin() + half, side.end()), order);
  const std::size_t paddedSize = x.size();
  x.insert(x.end(), rates.begin(), rates.end());
  std::vector<Scalar> apart(inPlace ? 0 : x.size());
  Scalar* to = inPlace ? x.data() : apart.data();
  solver.solve(x.data(), x.data() + paddedSize, to, to + paddedSize);
  std::vector<Scalar> found = restored(to, n, order);
  EXPECT_EQ(laneOrdered(found, order), std::vector<Scalar>(to, to + paddedSize)) << "0 beyond the end";
  const std::vector<Scalar> v = restored(to + paddedSize, n, order);
  found.insert(found.end(), v.begin(), v.end());
  return found;
}

template <class Scalar, class Exact>
double worstOf(const std::vector<Scalar>& x, const std::vector<Exact>& exact) {
  double worst = 0, size = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    worst = std::max(worst, static_cast<double>(std::abs(Exact(x[i]) - exact[i])));
    size = std::max(size, static_cast<double>(std::abs(exact[i])));
    if (!(worst >= 0)) return worst;
  }
  return worst / size;
}

template <class Scalar, class Long>
void compareSolves(const Linear& at, Scalar s, double factor) {
  Linearized<Long> exactSolver(at.moving.chain);
  const std::vector<Long> exact = solution(exactSolver, at, Long(s));
  Linearized<Scalar> sequential(at.moving.chain);
  const double own = worstOf(solution(sequential, at, s), exact);
  for (const simd::Kernel* kernel : simd::kernels()) {
    for (const bool inSegments : {true, false}) {
      LinearizedSegments<double> real(at.moving.chain, inSegments, *kernel);
      LinearizedSegments<Scalar> keeping(real, Kept::all), computing(real, Kept::least);
      const std::vector<Scalar> x = solution(real, keeping, at, s, true);
      EXPECT_LT(worstOf(x, exact), factor * own + 1e-14) << kernel->name << " " << at.alpha.size();
      EXPECT_EQ(solution(real, keeping, at, s, false), x);
      EXPECT_EQ(solution(real, computing, at, s, true), x);
    }
  }
}

TEST(LinearizedSegments, AreAsExactAsTheSolveLinkByLink) {
  std::vector<int> lengths;
  for (int n = 1; n <= 20; ++n) lengths.push_back(n);
  for (const int n : {33, 100, 1000, 1024, 10000}) lengths.push_back(n);
  for (const int n : lengths) {
    for (const double bend : {0.01, 1.0}) {
      for (const double k : {0.0, 1e3, 1e9}) {
        for (const double size : {100.0, 1e4}) {
          const Linear at = linearOf(randomMotion(n, static_cast<unsigned>(n), bend), k, 1e-3 * k, size);
          compareSolves<double, long double>(at, size, 100);
          compareSolves<std::complex<double>, std::complex<long double>>(at, {size, -0.7 * size}, 100);
        }
      }
    }
  }
}

TEST(LinearizedSegments, AreAsExactWhereTheThreadIsTaut) {
  for (const double tipMass : {1.0, 1e5, 2e8}) {
    for (const double bend : {1e-9, 1e-3}) {
      Moving moving = taut(200, tipMass, bend, 7);
      moving.F.assign(200, {});
      const Linear at = linearOf(moving, 0, 0, 100);
      compareSolves<double, long double>(at, 100, 30);
      compareSolves<std::complex<double>, std::complex<long double>>(at, {100, 60}, 30);
    }
  }
}

}  // namespace
}  // namespace planar_chain
