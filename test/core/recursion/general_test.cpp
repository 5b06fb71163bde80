/// Chains with joints of any kind anywhere against Newton's and Euler's equations with all pin forces as
/// unknowns, in long double: revolute and prismatic, free, with armature, prescribed; a base that moves;
/// every tip.

#include <gtest/gtest.h>

#include "random_dense_chain.h"
#include "recursion/general_recursion.h"

namespace planar_chain {
namespace {

using test::AtState;
using test::ComplexVector;
using test::errorOf;
using test::forAllKinds;
using test::Kind;
using test::Random;
using test::RandomChain;
using test::WideComplex;

ComplexVector wide(const std::vector<double>& a) {
  return Eigen::Map<const Eigen::VectorXd>(a.data(), static_cast<Eigen::Index>(a.size())).cast<WideComplex>();
}
ComplexVector wide(Vec2d a) {
  return wide(std::vector<double>{a.x, a.y});
}

TEST(General, MovesAsNewtonAndEulerSay) {
  // Rounding: 1e-13 at most, but where the rows hold all that can move, or nearly so.
  const auto check = [](const RandomChain& chain, unsigned) {
    const AtState at(chain);
    const auto n = index(chain.size());
    const std::vector<double> torques = chain.torques();
    std::vector<double> xdd(n), moments(n), N = at.N;
    for (int j = 0; j < chain.size(); ++j) at.chain.coordinates().addTorque(torques[index(j)], j, N.data());
    const EndForces<double> ends = GeneralRecursion<double>(at.chain).accelerations(
        {at.e.data(), at.omega.data(), at.displaced.data()},
        {N.data(), at.F.data(), chain.laws.data(), at.base, chain.baseTurning}, chain.heldTip(), xdd.data(),
        moments.data());
    for (std::size_t j = 0; j < n; ++j) moments[j] += torques[j];

    const test::DenseChain::Answer& exact = at.answer;
    ComplexVector forces(exact.forces.size() + chain.size() + exact.moments.size());
    forces << exact.forces, wide(at.N), exact.moments;
    EXPECT_EQ(ends.tip.acting.rows, chain.tip.rows);
    EXPECT_LT(errorOf(wide(xdd), exact.xdd), 1e-12);
    EXPECT_LT(errorOf(wide(moments), exact.moments, forces), 1e-12);
    EXPECT_LT(errorOf(wide(ends.baseForce), exact.forces.head<2>(), forces), 1e-12);
    EXPECT_LT(errorOf(wide(ends.tip.force), exact.tip, forces), 1e-12);
    // The recursion has no torques of the joints in the moment of the base: add that of the first one that
    // turns.
    const int first = at.chain.coordinates().leading();
    const double moment = ends.baseMoment + (first < chain.size() ? torques[index(first)] : 0);
    EXPECT_LT(
        errorOf(wide(std::vector<double>{moment}), ComplexVector::Constant(1, exact.baseMoment), forces),
        1e-12);
  };
  forAllKinds(1, check);
}

/// n rods in a row, at rest, of mass and length 1, behind carriages.
struct Rods {
  explicit Rods(int n, double angle = 0, const std::vector<std::pair<double, Vec2d>>& carriages = {})
      : chain(links(n, carriages), joints(n, carriages), {0, -9.81}),
        recursion(chain),
        e(index(chain.size()), Rotation<double>::of(angle)),
        omega(e.size(), 0.0),
        xdd(omega),
        moments(omega),
        displaced(e.size()),
        laws(e.size()) {
    for (std::size_t i = 0; i < carriages.size(); ++i) displaced[i].d = chain.joints()[i].axis;
  }

  EndForces<double> accelerations(const Tip<double>& tip) {
    return recursion.accelerations({e.data(), omega.data(), displaced.data()},
                                   {omega.data(), nullptr, laws.data(), {0, 9.81}, 0}, tip, xdd.data(),
                                   moments.data());
  }

  static std::vector<Link> links(int n, const std::vector<std::pair<double, Vec2d>>& carriages) {
    std::vector<Link> all;
    for (const auto& carriage : carriages)
      all.push_back({"c" + std::to_string(all.size()), carriage.first, 0, {}, {}});
    for (int i = 0; i < n; ++i) all.push_back({"l" + std::to_string(i), 1, 1. / 12, {0.5, 0}, {1, 0}});
    return all;
  }
  static std::vector<Joint> joints(int n, const std::vector<std::pair<double, Vec2d>>& carriages) {
    std::vector<Joint> all;
    for (const auto& carriage : carriages) {
      all.push_back({"s" + std::to_string(all.size())});
      all.back().isPrismatic = true;
      all.back().axis = carriage.second;
    }
    for (int i = 0; i < n; ++i) all.push_back({"j" + std::to_string(i)});
    return all;
  }

  Chain chain;
  GeneralRecursion<double> recursion;
  std::vector<Rotation<double>> e;
  std::vector<double> omega, xdd, moments;
  std::vector<Displacement<double>> displaced;
  std::vector<JointLaw<double>> laws;
};

TEST(General, NoForceActsAlongAStretchedChain) {
  // Along the chain the tip cannot move, whatever pulls. Across it the beam of two rods falls: each end bears
  // what it bears of a rod that is pinned at that end and falls at the other: m g/4 each.
  for (const double angle : {0.0, 0.4, 1.5707963267948966, -2.3}) {
    Rods rods(2, angle);
    const Vec2d along = rods.e[0] * Vec2d{1, 0}, across = perp(along);
    const TipReaction<double> both = rods.accelerations(pinnedTip<double>({0, 9.81})).tip;
    EXPECT_EQ(both.acting.rows, 1);
    EXPECT_NEAR(dot(along, both.force), 0, 1e-12);
    EXPECT_NEAR(dot(across, both.force), 9.81 / 4 * dot(across, Vec2d{0, 1}), 1e-12);
    const TipReaction<double> one = rods.accelerations({1, {along, {}}, {0, 9.81}}).tip;
    EXPECT_EQ(one.acting.rows, 0);
    EXPECT_EQ(one.force, Vec2d{});
  }
}

TEST(General, ACarriageRunsDownItsRail) {
  // The chain hangs at right angles to the rail: it runs as one body, at −g sin β along the rail, and the
  // angles stay.
  for (const double mass : {0.0, 3.0}) {
    const double beta = 0.3;
    Rods rods(5, beta - pi / 2, {{mass, Rotation<double>::of(beta) * Vec2d{1, 0}}});
    rods.accelerations({});
    EXPECT_NEAR(rods.xdd[0], -9.81 * std::sin(beta), 1e-12);
    for (std::size_t i = 1; i < rods.xdd.size(); ++i) EXPECT_NEAR(rods.xdd[i], 0, 1e-12);
  }
}

TEST(General, AScrewsMotorResistsButHasNoWeight) {
  // A carriage of mass m with an armature J on a vertical rail falls at m g/(m + J).
  std::vector<Link> links{{"c", 2, 0, {}, {}}};
  std::vector<Joint> joints{{"s"}};
  joints[0].isPrismatic = true;
  joints[0].axis = {0, 1};
  const Chain chain(links, joints, {0, -9.81});
  const Rotation<double> e;
  const double none = 0;
  const Displacement<double> at{{0, 1}, {}, {}};
  const JointLaw<double> law{3};
  double xdd = 0, moment = 0;
  GeneralRecursion<double>(chain).accelerations({&e, &none, &at}, {&none, nullptr, &law, {0, 9.81}}, {}, &xdd,
                                                &moment);
  EXPECT_NEAR(xdd, -2 * 9.81 / 5, 1e-14);
  EXPECT_NEAR(moment, 3 * 2 * 9.81 / 5, 1e-14);
}

TEST(General, AFreeChainKeepsItsMomenta) {
  // Σ m a = 0 and Σ c×(m a) + I α = 0 without outer forces, however it spins and whatever its joints do.
  for (int n = 3; n <= 12; ++n) {
    Kind kind{0, 0, 0, 0, 0, 0, true};
    const RandomChain random(n, static_cast<unsigned>(n), kind);
    const AtState at(random);
    std::vector<double> xdd(index(n)), moments(index(n)), N(index(n), 0.0);
    for (int j = 3; j < n; ++j) at.chain.coordinates().addTorque(random.torque[index(j)], j, N.data());
    GeneralRecursion<double>(at.chain).accelerations({at.e.data(), at.omega.data(), at.displaced.data()},
                                                     {N.data(), nullptr, random.laws.data(), {}, 0}, {},
                                                     xdd.data(), moments.data());
    Vec2d a{xdd[0], xdd[1]}, force, x;
    double moment = 0, size = 0;
    for (std::size_t j = 2; j < xdd.size(); ++j) {
      const Link& link = random.links[j];
      const Vec2d R = at.e[j] * link.com, P = at.e[j] * link.pin;
      const auto move = [&](Vec2d X) { return xdd[j] * perp(X) - (at.omega[j] * at.omega[j]) * X; };
      const Vec2d f = link.mass * (a + move(R));
      force += f;
      moment += cross(x + R, f) + link.inertia * xdd[j];
      size += link.mass * (length(a) + length(move(R))) * (1 + length(x + R));
      a += move(P);
      x += P;
    }
    EXPECT_LT(length(force), 1e-13 * size) << n;
    EXPECT_LT(std::abs(moment), 1e-13 * size) << n;
  }
}

TEST(General, KeepsItsDigitsOnALongSlackChain) {
  // A thousand rods between two pins, each bent a little. In long double the same recursion is 2000 times
  // finer.
  constexpr int n = 1000;
  Rods rods(n);
  Random random(1);
  GeneralRecursion<long double> recursion(rods.chain);
  std::vector<Rotation<long double>> e;
  for (Rotation<double>& turn : rods.e) {
    turn = Rotation<double>::of(random.between(-0.1, 0.1));
    e.push_back({static_cast<long double>(turn.c), static_cast<long double>(turn.s)});
  }
  const Vec2d is = rods.accelerations(pinnedTip<double>({0, 9.81})).tip.force;
  std::vector<long double> zero(n, 0), xdd(n), moments(n);
  const std::vector<JointLaw<long double>> laws(n);
  const auto exact =
      recursion
          .accelerations({e.data(), zero.data(), nullptr}, {zero.data(), nullptr, laws.data(), {0, 9.81}, 0},
                         pinnedTip<long double>({0, 9.81}), xdd.data(), moments.data())
          .tip.force;
  long double worst = 0, size = 0;
  for (std::size_t i = 0; i < n; ++i) {
    worst = std::max(worst, std::abs(xdd[i] - static_cast<long double>(rods.xdd[i])));
    size = std::max(size, std::abs(xdd[i]));
  }
  EXPECT_LT(worst, 1e-11L * size);
  EXPECT_NEAR(is.x, static_cast<double>(exact.x), 1e-11 * length(is));
  EXPECT_NEAR(is.y, static_cast<double>(exact.y), 1e-11 * length(is));
}

}  // namespace
}  // namespace planar_chain
