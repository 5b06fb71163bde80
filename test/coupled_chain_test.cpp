/// The kernels for coupled joints, link by link and in segments: every one that this CPU runs, against long
/// double and against the recursion in double.

#include "lanes/coupled_chain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "lanes/kernel.h"
#include "lanes/short_chain.h"
#include "random_scene.h"

namespace planar_chain {
namespace {

using test::Random;

/// A random chain in motion. Its joints are free, held, or have rotors.
struct Moving {
  Moving(int n, unsigned seed, double held, double rotors, double size)
      : chain(test::randomScene(n, seed).chain), joints(index(n)), e(index(ShortChain::roomFor(n))) {
    Random random(seed);
    for (auto& joint : joints) {
      joint.isHeld = random.between(0, 1) < held;
      if (joint.isHeld) joint.acceleration = random.between(-3, 3);
      if (random.between(0, 1) < rotors) joint.rotor = size * random.between(0.5, 2);
      theta.push_back(random.between(-3, 3));
      omega.push_back(random.between(-2, 2));
      N.push_back(random.between(-5, 5));
      F.push_back(random.vector(5));
    }
    ground = random.vector(10);
    turning = random.between(-3, 3);
    rotate();
  }
  /// slides, rows: so many. The ends are random.
  void end(int slides, int rows) {
    hasEnds = true;
    Random random(static_cast<unsigned>(joints.size()));
    const auto direction = [&] { return Rotation<double>::of(random.between(-3, 3)) * Vec2d{1, 0}; };
    inner.slides = slides;
    inner.slide[0] = {direction(), random.between(0.5, 2), random.between(-5, 5), false, 0};
    inner.slide[1] = {perp(inner.slide[0].d), 0, 0, slides + rows == 3, random.between(-3, 3)};
    tip = {rows, {direction(), {}}, random.vector(5)};
    tip.row[1] = perp(tip.row[0]);
  }
  void rotate() {
    for (std::size_t j = 0; j < theta.size(); ++j) e[j] = Rotation<double>::of(theta[j]);
  }

  Chain chain;
  std::vector<Coupling<double>> joints;
  std::vector<double> theta, omega, N;
  std::vector<Vec2d> F;
  std::vector<Rotation<double>> e;
  Vec2d ground;
  double turning;
  bool hasEnds = false;
  InnerEnd<double> inner;
  Tip<double> tip;
};

/// α, then μ, then the forces on the ends, and how slides move.
template <class Real>
struct Result {
  std::vector<Real> alpha, moments, ends;

  void take(const EndsMotion<Real>& motion) {
    ends = {motion.pinForce.x, motion.pinForce.y, motion.tipForce.x, motion.tipForce.y};
    for (const auto& of : {motion.acceleration, motion.force}) ends.insert(ends.end(), of.begin(), of.end());
  }
};

template <class Real>
Vec2<Real> as(Vec2d a) {
  return {a.x, a.y};
}
template <class Real>
Slide<Real> as(const Slide<double>& of) {
  return {as<Real>(of.d), of.mass, of.force, of.isHeld, of.acceleration};
}

template <class Real>
Result<Real> reference(const Moving& at, bool hasForces) {
  const std::size_t n = at.joints.size();
  Result<Real> result{std::vector<Real>(n), std::vector<Real>(n), {}};
  std::vector<Rotation<Real>> e;
  std::vector<Vec2<Real>> F;
  std::vector<Coupling<Real>> joints;
  for (std::size_t j = 0; j < n; ++j) {
    e.push_back({at.e[j].c, at.e[j].s});
    F.push_back({at.F[j].x, at.F[j].y});
    joints.push_back({at.joints[j].rotor, at.joints[j].isHeld, at.joints[j].acceleration});
  }
  const std::vector<Real> omega(at.omega.begin(), at.omega.end()), N(at.N.begin(), at.N.end());
  result.take(Ended<Real>(at.chain).accelerations(
      e.data(), omega.data(),
      {N.data(), hasForces ? F.data() : nullptr, joints.data(), as<Real>(at.ground), Real(at.turning)},
      {at.inner.slides, {as<Real>(at.inner.slide[0]), as<Real>(at.inner.slide[1])}},
      {at.tip.rows, {as<Real>(at.tip.row[0]), as<Real>(at.tip.row[1])}, as<Real>(at.tip.acceleration)},
      result.alpha.data(), result.moments.data()));
  return result;
}

Result<double> inLanes(Moving at, bool hasForces, const simd::Kernel& kernel, bool inSegments, bool turns) {
  const std::size_t n = at.joints.size();
  Result<double> result{std::vector<double>(n), std::vector<double>(n), {}};
  if (turns) std::fill(at.e.begin(), at.e.end(), Rotation<double>{});
  CoupledChain chain(at.chain, kernel, inSegments);
  chain.couple(at.joints.data());
  const Outside outside{at.e.data(), at.N.data(), hasForces ? at.F.data() : nullptr, at.ground};
  const double* theta = turns ? at.theta.data() : nullptr;
  EndsMotion<double> motion;
  if (at.hasEnds) {
    chain.accelerations(outside, theta, at.omega.data(), at.turning, at.inner, at.tip, result.alpha.data(),
                        result.moments.data(), motion);
  } else {
    motion.pinForce = chain.accelerations(outside, theta, at.omega.data(), at.turning, result.alpha.data(),
                                          result.moments.data());
  }
  result.take(motion);
  return result;
}

/// The largest difference over the largest number.
template <class Real>
double errorOf(const std::vector<Real>& is, const std::vector<long double>& exact) {
  long double most = 0, largest = 1;
  for (std::size_t j = 0; j < is.size(); ++j) {
    most = std::max(most, std::abs(is[j] - exact[j]));
    largest = std::max(largest, std::abs(exact[j]));
  }
  return static_cast<double>(most / largest);
}

void compare(const Moving& at, bool hasForces) {
  const auto exact = reference<long double>(at, hasForces);
  const auto plain = reference<double>(at, hasForces);
  const int n = at.chain.size();
  const auto expectClose = [&](const Result<double>& is, double least, const std::string& name) {
    const auto allowed = [&](auto part) { return 20 * errorOf(part(plain), part(exact)) + least; };
    const auto alpha = [](const auto& of) { return of.alpha; };
    const auto moments = [](const auto& of) { return of.moments; };
    const auto ends = [](const auto& of) { return of.ends; };
    EXPECT_LE(errorOf(alpha(is), alpha(exact)), allowed(alpha)) << name << ", " << n << " links";
    EXPECT_LE(errorOf(moments(is), moments(exact)), allowed(moments)) << name << ", " << n << " links";
    EXPECT_LE(errorOf(ends(is), ends(exact)), allowed(ends)) << name << ", " << n << " links";
  };
  for (const simd::Kernel* kernel : simd::kernels()) {
    const std::string name = kernel->name;
    // Where a segment of hardly any free joint ends at a held one, the join loses three digits.
    expectClose(inLanes(at, hasForces, *kernel, true, false), 1e-12, "segments, " + name);
    expectClose(inLanes(at, hasForces, *kernel, true, true), 1e-12, "segments, turning, " + name);
    if (n > ShortChain::most) continue;
    expectClose(inLanes(at, hasForces, *kernel, false, false), 1e-15, "link by link, " + name);
    expectClose(inLanes(at, hasForces, *kernel, false, true), 1e-15, "turning, " + name);
  }
}

TEST(CoupledChain, MovesAsTheRecursionWithRotorsAndHeldJoints) {
  unsigned seed = 0;
  for (const int n : {1, 2, 3, 4, 5, 8, 9, 12, 13, 20, 33, 100, 1000}) {
    for (const bool hasForces : {false, true}) {
      for (const double held : {0.0, 0.3, 1.0}) {
        for (const double rotors : {0.0, 0.2, 1.0}) {
          for (const double size : {1e-6, 0.1, 1e4}) {
            SCOPED_TRACE(testing::Message() << "held " << held << ", rotors " << rotors << " of " << size);
            compare(Moving(n, ++seed, held, rotors, size), hasForces);
          }
        }
      }
    }
  }
}

TEST(CoupledChain, MovesBetweenEnds) {
  unsigned seed = 0;
  for (const int n : {2, 3, 5, 8, 12, 13, 20, 33, 100, 1000}) {
    for (const int slides : {0, 1, 2}) {
      for (const int rows : {0, 1, 2}) {
        for (const double coupled : {0.0, 0.2}) {
          SCOPED_TRACE(testing::Message() << slides << " slides, rows " << rows << ", coupled " << coupled);
          Moving at(n, ++seed, n > 3 ? coupled : 0, coupled, 0.1);
          at.end(slides, rows);
          compare(at, seed % 2 == 0);
        }
      }
    }
  }
}

/// Between its ends no force acts along a chain that is straight, however long.
TEST(CoupledChain, NoForceActsAlongAStretchedChain) {
  for (const int n : {2, 12, 13, 100, 1000}) {
    for (const double angle : {0.0, 0.4, -2.3}) {
      std::vector<Link> links;
      std::vector<Joint> joints;
      for (int i = 0; i < n; ++i) {
        links.push_back({"l" + std::to_string(i), 1, 1. / 12, {0.5, 0}, {1, 0}});
        joints.push_back({"j" + std::to_string(i)});
      }
      Moving at(n, 1, 0, 0, 0);
      at.chain = Chain(links, joints, {});
      at.hasEnds = true;
      at.tip = pinnedTip<double>(at.ground);
      for (double& theta : at.theta) theta = angle;
      at.rotate();
      for (const simd::Kernel* kernel : simd::kernels()) {
        CoupledChain chain(at.chain, *kernel, n > ShortChain::most);
        chain.couple(at.joints.data());
        std::vector<double> alpha(index(n)), moments(index(n));
        EndsMotion<double> motion;
        chain.accelerations({at.e.data(), at.N.data(), nullptr, at.ground}, nullptr, at.omega.data(), 0, {},
                            at.tip, alpha.data(), moments.data(), motion);
        EXPECT_EQ(motion.acting.rows, 1) << kernel->name << ", " << n << " links";
        EXPECT_LT(std::abs(dot(at.e[0] * Vec2d{1, 0}, motion.tipForce)), 1e-9 * length(motion.tipForce));
      }
    }
  }
}

/// A nearly straight chain is the hardest: see segments.h.
TEST(CoupledChain, MovesAsTheRecursionIfTaut) {
  for (const int n : {13, 100, 1000}) {
    for (const double rotors : {0.0, 0.1, 1.0}) {
      Moving at(n, 1, 0.1, rotors, 0.1);
      Random random(7);
      for (double& theta : at.theta) theta = random.between(-1e-3, 1e-3);
      at.rotate();
      compare(at, false);
    }
  }
}

}  // namespace
}  // namespace planar_chain
