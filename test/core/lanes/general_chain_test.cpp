/// The kernels of the general recursion, link by link and in segments: every one that this CPU runs, against
/// long double and against the recursion in double.

#include "lanes/general_chain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "lanes/kernel.h"
#include "lanes/short_chain.h"
#include "recursion/pose.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

using test::Random;

/// What a random chain has: shares of joints.
struct Shares {
  double prescribed = 0, armatures = 0, size = 0.1;  ///< size: of the armatures, kg m²
  int carriages = 0;
  double prismatic = 0;
  int rows = 0;
  bool moves = true;  ///< the base does
};

/// A random chain in motion.
struct Moving {
  Moving(int n, unsigned seed, const Shares& of)
      : chain(chainOf(n, seed, of)), laws(index(n)), e(index(ShortChain::roomFor(n))), moves(of.moves) {
    Random random(seed);
    int free = 0;
    for (auto& law : laws) {
      law.isPrescribed = random.between(0, 1) < of.prescribed;
      if (law.isPrescribed) law.acceleration = random.between(-3, 3);
      if (random.between(0, 1) < of.armatures) law.armature = of.size * random.between(0.5, 2);
      free += !law.isPrescribed;
      x.push_back(random.between(-3, 3));
      rates.push_back(random.between(-2, 2));
      N.push_back(random.between(-5, 5));
      F.push_back(random.vector(5));
    }
    for (std::size_t i = laws.size(); free <= of.rows && i-- > 0;) {
      free += laws[i].isPrescribed;
      laws[i] = {laws[i].armature};
    }
    ground = random.vector(10);
    turning = moves ? random.between(-3, 3) : 0;
    rate = moves ? random.between(-2, 2) : 0;
    const Vec2d row = Rotation<double>::of(random.between(-3, 3)) * Vec2d{1, 0};
    tip = {of.rows, {row, perp(row)}, random.vector(5)};
    pose();
  }
  static Chain chainOf(int n, unsigned seed, const Shares& of) {
    Random random(seed + 1000);
    const Chain plain = test::randomScene(n, seed).chain;
    std::vector<Link> links = plain.links();
    std::vector<Joint> joints = plain.joints();
    for (int i = 0; i < n; ++i) {
      Joint& joint = joints[index(i)];
      joint.isPrismatic = i < of.carriages || random.between(0, 1) < of.prismatic;
      joint.axis = Rotation<double>::of(random.between(-3, 3)) * Vec2d{1, 0};
      links[index(i)].inertia = std::max(links[index(i)].inertia, 0.01);
    }
    return {links, joints, plain.gravity()};
  }
  void pose() {
    const Coordinates& coordinates = chain.coordinates();
    const auto n = laws.size();
    angles.resize(n);
    omega.resize(n);
    displaced.resize(n);
    for (std::size_t j = 0; j < n; ++j) {
      const int i = static_cast<int>(j);
      angles[j] = coordinates.angle(x.data(), i);
      omega[j] = coordinates.angle(rates.data(), i) + rate;
      e[j] = Rotation<double>::of(angles[j]);
      displaced[j] = coordinates.isPrismatic(i)
                         ? displacementOf(chain.joints()[j].axis, e[j], omega[j], x[j], rates[j])
                         : Displacement<double>{};
    }
  }

  Chain chain;
  std::vector<JointLaw<double>> laws;
  std::vector<double> x, rates, angles, omega, N;
  std::vector<Vec2d> F;
  std::vector<Rotation<double>> e;
  std::vector<Displacement<double>> displaced;
  Vec2d ground;
  bool moves;
  double turning = 0, rate = 0;
  Tip<double> tip;
};

/// Changes the last digit of every number.
Moving nudged(Moving at, unsigned seed) {
  Random random(seed);
  constexpr double digit = std::numeric_limits<double>::epsilon();
  const auto nudge = [&](double& a) { a *= 1 + std::copysign(digit, random.between(-1, 1)); };
  const auto nudgeBoth = [&](Vec2d& a) { nudge(a.x), nudge(a.y); };
  std::vector<Link> links = at.chain.links();
  for (std::size_t j = 0; j < links.size(); ++j) {
    nudge(links[j].mass), nudge(links[j].inertia), nudgeBoth(links[j].com), nudgeBoth(links[j].pin);
    nudge(at.e[j].c), nudge(at.e[j].s), nudge(at.omega[j]), nudge(at.N[j]), nudgeBoth(at.F[j]);
    auto& [d, S, gamma] = at.displaced[j];
    nudgeBoth(d), nudgeBoth(S), nudgeBoth(gamma);
    nudge(at.laws[j].armature), nudge(at.laws[j].acceleration);
  }
  nudgeBoth(at.ground), nudge(at.turning), nudgeBoth(at.tip.acceleration);
  at.chain = Chain(links, at.chain.joints(), at.chain.gravity());
  return at;
}

/// ẍ, then μ, then the forces on the ends.
template <class Real>
struct Result {
  std::vector<Real> alpha, moments, ends;

  void take(const EndForces<Real>& of, bool hasWrench) {
    ends = {of.tip.force.x, of.tip.force.y};
    if (hasWrench) ends.insert(ends.end(), {of.baseForce.x, of.baseForce.y, of.baseMoment});
  }
};

template <class Real>
Vec2<Real> as(Vec2d a) {
  return {a.x, a.y};
}

template <class Real>
Result<Real> reference(const Moving& at, bool hasForces) {
  const std::size_t n = at.laws.size();
  Result<Real> result{std::vector<Real>(n), std::vector<Real>(n), {}};
  std::vector<Rotation<Real>> e;
  std::vector<Vec2<Real>> F;
  std::vector<JointLaw<Real>> laws;
  std::vector<Displacement<Real>> displaced;
  for (std::size_t j = 0; j < n; ++j) {
    e.push_back({at.e[j].c, at.e[j].s});
    F.push_back(as<Real>(at.F[j]));
    laws.push_back({at.laws[j].armature, at.laws[j].isPrescribed, at.laws[j].acceleration});
    const auto& [d, S, gamma] = at.displaced[j];
    displaced.push_back({as<Real>(d), as<Real>(S), as<Real>(gamma)});
  }
  const std::vector<Real> omega(at.omega.begin(), at.omega.end()), N(at.N.begin(), at.N.end());
  result.take(
      GeneralRecursion<Real>(at.chain).accelerations(
          {e.data(), omega.data(), displaced.data()},
          {N.data(), hasForces ? F.data() : nullptr, laws.data(), as<Real>(at.ground), Real(at.turning)},
          {at.tip.rows, {as<Real>(at.tip.row[0]), as<Real>(at.tip.row[1])}, as<Real>(at.tip.acceleration)},
          result.alpha.data(), result.moments.data()),
      at.moves);
  return result;
}

Result<double> inLanes(Moving at, bool hasForces, const simd::Kernel& kernel, bool inSegments, bool turns) {
  const std::size_t n = at.laws.size();
  Result<double> result{std::vector<double>(n), std::vector<double>(n), {}};
  if (turns) std::fill(at.e.begin(), at.e.end(), Rotation<double>{});
  GeneralChain chain(at.chain, kernel, inSegments, at.moves);
  chain.take(at.laws.data());
  const Loads external{at.e.data(), at.N.data(), hasForces ? at.F.data() : nullptr, at.ground};
  EndForces<double> ends;
  chain.accelerations(external, turns ? at.angles.data() : nullptr, at.omega.data(), at.displaced.data(),
                      at.turning, at.tip, result.alpha.data(), result.moments.data(), ends);
  result.take(ends, at.moves);
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

/// The kernels may lose as many digits as the condition of the problem lets roundings of its numbers grow,
/// and as the recursion in double loses: some roundings each.
void compare(const Moving& at, bool hasForces) {
  const auto exact = reference<long double>(at, hasForces);
  const auto other = reference<long double>(nudged(at, 1), hasForces);
  const auto plain = reference<double>(at, hasForces);
  const int n = at.chain.size();
  const auto expectClose = [&](const Result<double>& is, double least, const std::string& name) {
    const auto allowed = [&](auto part) {
      return 20 * std::max(errorOf(part(plain), part(exact)), errorOf(part(other), part(exact))) + least;
    };
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

/// Long double takes most of the time for the longest chains: a fifth of their cases are enough.
bool isSpared(int n, unsigned seed) {
  return n == 1000 && seed % 5 != 0;
}

TEST(GeneralChain, MovesAsTheRecursionWithArmaturesAndPrescribedJoints) {
  unsigned seed = 0;
  for (const int n : {1, 2, 3, 4, 5, 8, 9, 12, 13, 20, 33, 100, 1000}) {
    for (const bool hasForces : {false, true}) {
      for (const double prescribed : {0.0, 0.3, 1.0}) {
        for (const double armatures : {0.0, 0.2, 1.0}) {
          for (const double size : {1e-6, 0.1, 1e4}) {
            SCOPED_TRACE(testing::Message()
                         << "prescribed " << prescribed << ", armatures " << armatures << " of " << size);
            ++seed;
            if (!isSpared(n, seed)) compare(Moving(n, seed, {prescribed, armatures, size}), hasForces);
          }
        }
      }
    }
  }
}

TEST(GeneralChain, MovesWithPrismaticJointsAndHeldTips) {
  unsigned seed = 0;
  for (const int n : {2, 3, 5, 8, 12, 13, 20, 33, 100, 1000}) {
    for (const int carriages : {0, 1, 2}) {
      for (const double prismatic : {0.0, 0.3, 1.0}) {
        for (const int rows : {0, 1, 2}) {
          for (const bool moves : {false, true}) {
            SCOPED_TRACE(testing::Message() << carriages << " carriages, prismatic " << prismatic << ", rows "
                                            << rows << ", the base moves: " << moves);
            const double some = seed % 3 == 0 ? 0.2 : 0;
            ++seed;
            if (isSpared(n, seed)) continue;
            compare(Moving(n, seed, {some, some, 0.1, carriages, prismatic, rows, moves}), seed % 2 == 0);
          }
        }
      }
    }
  }
}

/// Between its ends no force acts along a chain that is straight, however long.
TEST(GeneralChain, NoForceActsAlongAStretchedChain) {
  for (const int n : {2, 12, 13, 100, 1000}) {
    for (const double angle : {0.0, 0.4, -2.3}) {
      std::vector<Link> links;
      std::vector<Joint> joints;
      for (int i = 0; i < n; ++i) {
        links.push_back({"l" + std::to_string(i), 1, 1. / 12, {0.5, 0}, {1, 0}});
        joints.push_back({"j" + std::to_string(i)});
      }
      Moving at(n, 1, {});
      at.chain = Chain(links, joints, {});
      at.rate = 0;
      std::fill(at.x.begin(), at.x.end(), angle);
      at.pose();
      for (const simd::Kernel* kernel : simd::kernels()) {
        GeneralChain chain(at.chain, *kernel, n > ShortChain::most);
        chain.take(at.laws.data());
        std::vector<double> alpha(index(n)), moments(index(n));
        EndForces<double> ends;
        chain.accelerations({at.e.data(), at.N.data(), nullptr, at.ground}, nullptr, at.omega.data(),
                            at.displaced.data(), 0, pinnedTip<double>(at.ground), alpha.data(),
                            moments.data(), ends);
        const TipReaction<double>& reaction = ends.tip;
        EXPECT_EQ(reaction.acting.rows, 1) << kernel->name << ", " << n << " links";
        EXPECT_LT(std::abs(dot(at.e[0] * Vec2d{1, 0}, reaction.force)), 1e-9 * length(reaction.force));
      }
    }
  }
}

/// A nearly straight chain is the hardest: see segments.h.
TEST(GeneralChain, MovesAsTheRecursionIfTaut) {
  for (const int n : {13, 100, 1000}) {
    for (const double armatures : {0.0, 0.1, 1.0}) {
      Moving at(n, 1, {0.1, armatures, 0.1});
      Random random(7);
      for (double& x : at.x) x = random.between(-1e-3, 1e-3);
      at.pose();
      compare(at, false);
    }
  }
}

}  // namespace
}  // namespace planar_chain
