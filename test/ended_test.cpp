/// Chains with ends against Newton's and Euler's equations with all pin forces as unknowns, in long double:
/// every combination of ends, with free and held joints and slides, rotors, forces.

#include "recursion/ended.h"

#include <gtest/gtest.h>

#include "random_dense_chain.h"

namespace planar_chain {
namespace {

using test::AtState;
using test::ComplexVector;
using test::errorOf;
using test::forAllEnds;
using test::Kind;
using test::Random;
using test::RandomChain;
using test::Wide;
using test::WideComplex;

/// N about the inner pins, with the torques of the joints.
std::vector<double> momentsOf(const RandomChain& chain, const AtState& at, std::vector<double>& torques) {
  std::vector<double> N = at.N, theta(chain.y.begin(), chain.y.begin() + chain.size());
  for (int j = 0; j < chain.size(); ++j) {
    const auto i = index(j);
    torques.push_back(chain.torque[i] - chain.k[i] * (relative(theta.data(), j) - chain.rest[i]) -
                      chain.d[i] * relative(at.omega, j));
    N[i] += torques[i];
    if (j > 0) N[i - 1] -= torques[i];
  }
  return N;
}

ComplexVector wide(const std::vector<double>& a) {
  return Eigen::Map<const Eigen::VectorXd>(a.data(), static_cast<Eigen::Index>(a.size())).cast<WideComplex>();
}
ComplexVector wide(Vec2d a) {
  return wide(std::vector<double>{a.x, a.y});
}
ComplexVector wide(const PerEnd<double>& a, Eigen::Index n) {
  return wide(std::vector<double>(a.begin(), a.begin() + n));
}

/// Two slides without mass.
InnerEnd<double> freeInnerEnd() {
  InnerEnd<double> end;
  end.slides = 2;
  end.slide[1].d = {0, 1};
  return end;
}

TEST(Ended, MovesAsNewtonAndEulerSay) {
  // Rounding: 1e-13 at most, but where the rows hold all that can move, or nearly so.
  const auto check = [](const RandomChain& chain, unsigned) {
    const AtState at(chain);
    const auto n = index(chain.size());
    std::vector<double> alpha(n), moments(n), torques;
    const std::vector<double> N = momentsOf(chain, at, torques);
    const EndsMotion<double> motion = Ended<double>(at.chain).accelerations(
        at.e.data(), at.omega,
        {N.data(), at.F.data(), chain.joints.data(), chain.pinAcceleration(), chain.baseTurning},
        chain.innerEnd(), chain.heldTip(), alpha.data(), moments.data());
    for (std::size_t j = 0; j < n; ++j) moments[j] += torques[j];

    const test::DenseChain::Answer& exact = at.answer;
    const Eigen::Index slides = exact.slides.size();
    ComplexVector forces(exact.forces.size() + chain.size());
    forces << exact.forces, wide(at.N);
    EXPECT_EQ(motion.acting.rows, chain.tip.rows);
    EXPECT_LT(errorOf(wide(alpha), exact.alpha), 1e-12);
    EXPECT_LT(errorOf(wide(moments), exact.moments), 1e-12);
    EXPECT_LT(errorOf(wide(motion.pinForce), exact.forces.head<2>(), forces), 1e-12);
    EXPECT_LT(errorOf(wide(motion.tipForce), exact.tip), 1e-12);
    if (slides == 0) return;
    EXPECT_LT(errorOf(wide(motion.acceleration, slides), exact.slides), 1e-12);
    PerEnd<double> force = motion.force;
    for (int i = 0; i < slides; ++i) force[index(i)] -= chain.pushOn(i);
    EXPECT_LT(errorOf(wide(force, slides), exact.slideForces, forces), 1e-12);
  };
  forAllEnds(1, check, 1);
}

/// n rods in a row, at rest, of mass and length 1.
struct Rods {
  explicit Rods(int n, double angle = 0)
      : chain(links(n), joints(n), {0, -9.81}),
        ended(chain),
        e(index(n), Rotation<double>::of(angle)),
        omega(index(n), 0.0),
        alpha(omega),
        moments(omega),
        couplings(index(n)) {}

  EndsMotion<double> accelerations(const InnerEnd<double>& inner, const Tip<double>& tip) {
    return ended.accelerations(e.data(), omega.data(),
                               {omega.data(), nullptr, couplings.data(), {0, 9.81}, 0}, inner, tip,
                               alpha.data(), moments.data());
  }

  static std::vector<Link> links(int n) {
    std::vector<Link> all;
    for (int i = 0; i < n; ++i) all.push_back({"l" + std::to_string(i), 1, 1. / 12, {0.5, 0}, {1, 0}});
    return all;
  }
  static std::vector<Joint> joints(int n) {
    std::vector<Joint> all;
    for (int i = 0; i < n; ++i) all.push_back({"j" + std::to_string(i)});
    return all;
  }

  Chain chain;
  Ended<double> ended;
  std::vector<Rotation<double>> e;
  std::vector<double> omega, alpha, moments;
  std::vector<Coupling<double>> couplings;
};

TEST(Ended, NoForceActsAlongAStretchedChain) {
  // Along the chain the tip cannot move, whatever pulls. Across it the beam of two rods falls: each end bears
  // what it bears of a rod that is pinned at that end and falls at the other: m g/4 each.
  for (const double angle : {0.0, 0.4, 1.5707963267948966, -2.3}) {
    Rods rods(2, angle);
    const Vec2d along = rods.e[0] * Vec2d{1, 0}, across = perp(along);
    const EndsMotion<double> both = rods.accelerations({}, pinnedTip<double>({0, 9.81}));
    EXPECT_EQ(both.acting.rows, 1);
    EXPECT_NEAR(dot(along, both.tipForce), 0, 1e-12);
    EXPECT_NEAR(dot(across, both.tipForce), 9.81 / 4 * dot(across, Vec2d{0, 1}), 1e-12);
    const EndsMotion<double> one = rods.accelerations({}, {1, {along, {}}, {0, 9.81}});
    EXPECT_EQ(one.acting.rows, 0);
    EXPECT_EQ(one.tipForce, Vec2d{});
  }
}

TEST(Ended, ACarriageRunsDownItsRail) {
  // The chain hangs at right angles to the rail: it runs as one body, at −g sin β along the rail, and the
  // angles stay.
  for (const double mass : {0.0, 3.0}) {
    const double beta = 0.3;
    Rods rods(5, beta - pi / 2);
    InnerEnd<double> cart;
    cart.slides = 1;
    cart.slide[0].d = Rotation<double>::of(beta) * Vec2d{1, 0};
    cart.slide[0].mass = mass;
    const EndsMotion<double> motion = rods.accelerations(cart, {});
    EXPECT_NEAR(motion.acceleration[0], -9.81 * std::sin(beta), 1e-12);
    for (const double alpha : rods.alpha) EXPECT_NEAR(alpha, 0, 1e-12);
  }
}

TEST(Ended, AFreeChainKeepsItsMomenta) {
  // Σ m a = 0 and Σ c×(m a) + I α = 0 without outer forces, however it spins and whatever its joints do.
  for (int n = 1; n <= 12; ++n) {
    Kind kind{0, 0, 0, 0, 2, 0, true};
    RandomChain random(n, static_cast<unsigned>(n), kind);
    const AtState at(random);
    std::vector<double> alpha(index(n)), moments(index(n)), N(index(n), 0.0);
    for (int j = 1; j < n; ++j) {
      N[index(j)] += random.torque[index(j)];
      N[index(j - 1)] -= random.torque[index(j)];
    }
    Vec2d a = Ended<double>(at.chain)
                  .accelerations(at.e.data(), at.omega, {N.data(), nullptr, random.joints.data(), {}, 0},
                                 freeInnerEnd(), {}, alpha.data(), moments.data())
                  .pinAcceleration;
    Vec2d force, x;
    double moment = 0, size = 0;
    for (std::size_t j = 0; j < alpha.size(); ++j) {
      const Link& link = random.links[j];
      const Vec2d R = at.e[j] * link.com, P = at.e[j] * link.pin;
      const auto move = [&](Vec2d X) { return alpha[j] * perp(X) - (at.omega[j] * at.omega[j]) * X; };
      const Vec2d f = link.mass * (a + move(R));
      force += f;
      moment += cross(x + R, f) + link.inertia * alpha[j];
      size += link.mass * (length(a) + length(move(R))) * (1 + length(x + R));
      a += move(P);
      x += P;
    }
    EXPECT_LT(length(force), 1e-13 * size) << n;
    EXPECT_LT(std::abs(moment), 1e-13 * size) << n;
  }
}

TEST(Ended, KeepsItsDigitsOnALongSlackChain) {
  // A thousand rods between two pins, each bent a little. In long double the same recursion is 2000 times
  // finer.
  constexpr int n = 1000;
  Rods rods(n);
  Random random(1);
  Ended<long double> ended(rods.chain);
  std::vector<Rotation<long double>> e;
  for (Rotation<double>& turn : rods.e) {
    turn = Rotation<double>::of(random.between(-0.1, 0.1));
    e.push_back({static_cast<long double>(turn.c), static_cast<long double>(turn.s)});
  }
  const EndsMotion<double> is = rods.accelerations({}, pinnedTip<double>({0, 9.81}));
  std::vector<long double> zero(n, 0), alpha(n), moments(n);
  const std::vector<Coupling<long double>> couplings(n);
  const EndsMotion<long double> exact =
      ended.accelerations(e.data(), zero.data(), {zero.data(), nullptr, couplings.data(), {0, 9.81}, 0}, {},
                          pinnedTip<long double>({0, 9.81}), alpha.data(), moments.data());
  long double worst = 0, size = 0;
  for (std::size_t i = 0; i < n; ++i) {
    worst = std::max(worst, std::abs(alpha[i] - static_cast<long double>(rods.alpha[i])));
    size = std::max(size, std::abs(alpha[i]));
  }
  EXPECT_LT(worst, 1e-11L * size);
  EXPECT_NEAR(is.tipForce.x, static_cast<double>(exact.tipForce.x), 1e-11 * length(is.tipForce));
  EXPECT_NEAR(is.tipForce.y, static_cast<double>(exact.tipForce.y), 1e-11 * length(is.tipForce));
}

}  // namespace
}  // namespace planar_chain
