/// A point drawn to a place: what it weighs against the dense form of kane.h, and how it comes.

#include "dynamics/pull.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "planar_chain/kane.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

using test::randomScene;

Chain withRotors(const Chain& chain, double J) {
  std::vector<Joint> joints = chain.joints();
  for (Joint& joint : joints) joint.others = {{"rotor_inertia", J}};
  return {chain.links(), joints, chain.gravity()};
}

/// Makes every third joint prismatic, from `first` on.
Chain withPrismatic(const Chain& chain, int first) {
  std::vector<Joint> joints = chain.joints();
  for (std::size_t i = static_cast<std::size_t>(first); i < joints.size(); i += 3) {
    joints[i].isPrismatic = true;
    joints[i].axis = Rotation<double>::of(static_cast<double>(i)) * Vec2d{1, 0};
  }
  return {chain.links(), joints, chain.gravity()};
}

struct Case {
  Scene scene;
  int link;
  Vec2d point;
  Eigen::VectorXd q, qd;
  PointMotion motion;
  Kane kane;
  Eigen::MatrixXd J;  ///< 2×n: v_X = J q̇

  /// rotors: J of each joint, kg m² or kg. prismatic: the first joint of withPrismatic; n: none.
  explicit Case(int n, double rotors = 0) : Case(n, rotors, n) {}
  Case(int n, double rotors, int prismatic) : scene(randomScene(n, 300 + static_cast<unsigned>(n))) {
    scene.chain = withPrismatic(withRotors(scene.chain, rotors), prismatic);
    test::Random random(static_cast<unsigned>(n));
    link = random.index(n);
    point = random.vector(1);
    q = Eigen::Map<const Eigen::VectorXd>(scene.q.data(), n);
    qd = Eigen::Map<const Eigen::VectorXd>(scene.qd.data(), n);
    motion = Pull(scene.chain).motionOf(scene.q.data(), scene.qd.data(), link, point);
    kane = planar_chain::kane(scene.chain, q, qd, activeForces(scene, 0, q, qd));

    // The point as a centre of mass: V_pd is ∂v/∂q̇ᵀ.
    std::vector<Link> links = scene.chain.links();
    links[static_cast<std::size_t>(link)].com = point;
    const Chain moved(links, scene.chain.joints(), {});
    J = planar_chain::kane(moved, q, qd, activeForces(scene, 0, q, qd))
            .V_pd.middleCols(2 * link, 2)
            .transpose();
  }

  /// What a force on the point adds to its acceleration, by M_q.
  Eigen::Vector2d added(Vec2d force) const {
    return J * kane.M_q.ldlt().solve(J.transpose() * Eigen::Vector2d(force.x, force.y));
  }
};

TEST(Pull, MobilityIsThatOfTheDenseMatrices) {
  // 1e-10 for the condition of M_q, up to 1e5 in these chains, n ulps each.
  for (int n = 1; n <= 20; ++n) {
    const Case c(n);
    const Eigen::Vector2d alongX = c.added({1, 0}), alongY = c.added({0, 1});
    EXPECT_NEAR(c.motion.mobility.xx, alongX.x(), 1e-10 * alongX.norm()) << n;
    EXPECT_NEAR(c.motion.mobility.xy, alongX.y(), 1e-10 * alongX.norm()) << n;
    EXPECT_NEAR(c.motion.mobility.yy, alongY.y(), 1e-10 * alongY.norm()) << n;
  }
}

TEST(Pull, MobilityHasTheRotors) {
  // 1e-12, though n is larger: with rotors the condition of M_q is below 1e3.
  for (const double J : {1., 100.}) {
    for (int n = 1; n <= 20; ++n) {
      const Case c(n, J);
      const Eigen::Vector2d alongX = c.added({1, 0}), alongY = c.added({0, 1});
      EXPECT_NEAR(c.motion.mobility.xx, alongX.x(), 1e-12 * alongX.norm()) << n;
      EXPECT_NEAR(c.motion.mobility.xy, alongX.y(), 1e-12 * alongX.norm()) << n;
      EXPECT_NEAR(c.motion.mobility.yy, alongY.y(), 1e-12 * alongY.norm()) << n;
    }
  }
}

TEST(Pull, MobilityHasPrismaticJointsAnywhere) {
  for (const double J : {1., 100.}) {
    for (int n = 2; n <= 12; ++n) {
      for (const int first : {0, 1, 2}) {
        const Case c(n, J, std::min(first, n - 1));
        const Eigen::Vector2d alongX = c.added({1, 0}), alongY = c.added({0, 1});
        EXPECT_NEAR(c.motion.mobility.xx, alongX.x(), 1e-12 * alongX.norm()) << n << " " << first;
        EXPECT_NEAR(c.motion.mobility.xy, alongX.y(), 1e-12 * alongX.norm()) << n << " " << first;
        EXPECT_NEAR(c.motion.mobility.yy, alongY.y(), 1e-12 * alongY.norm()) << n << " " << first;
        const Eigen::Vector2d v = c.J * c.qd;
        EXPECT_NEAR(c.motion.velocity.x, v.x(), 1e-12 * v.norm()) << n << " " << first;
        EXPECT_NEAR(c.motion.velocity.y, v.y(), 1e-12 * v.norm()) << n << " " << first;
      }
    }
  }
}

/// Rotors of a chain on a carriage.
TEST(Pull, MobilityHasTheRotorsOfAChainOnACart) {
  const Scene scene = readSceneText(
      "chain: [cart, rod, tool]\nlinks:\n  cart: {mass: 2, joint: {type: prismatic, axis: [1, 0.4]}}\n"
      "  rod: {mass: 1, inertia: 0.1, com: [0.4, 0.1], pin: [0.9, 0], joint: {rotor_inertia: 5}}\n"
      "  tool: {mass: 0.4, inertia: 0.02, com: [0.2, 0], pin: [0.5, 0], joint: {rotor_inertia: 0.3}}\n");
  const Eigen::Vector3d q(0.3, 0.7, -0.4), qd(0, 0, 0);
  const Kane k = kane(scene.chain, q, qd, activeForces(scene, 0, q, qd));
  const Eigen::MatrixXd J = k.V_pd.middleCols(4, 2).transpose();  // of the tool's centre of mass
  const Eigen::Matrix2d wanted = J * k.M_q.ldlt().solve(J.transpose());
  const Sym2<double> found = Pull(scene.chain).motionOf(q.data(), qd.data(), 2, {0.2, 0}).mobility;
  EXPECT_NEAR(found.xx, wanted(0, 0), 1e-12);
  EXPECT_NEAR(found.xy, wanted(0, 1), 1e-12);
  EXPECT_NEAR(found.yy, wanted(1, 1), 1e-12);
}

/// The point, its velocity and mobility turn with the base.
TEST(Pull, MovesWithTheBase) {
  const std::string links =
      "links:\n  cart: {mass: 2, com: [0.2, -0.1], pin: [0, 0.1], joint: {type: prismatic, axis: [1, 0.4]}, "
      "initial: "
      "{position: 0.3, velocity: 0.5}}\n  rod: {mass: 1, inertia: 0.1, com: [0.4, 0.1], pin: [0.9, 0], "
      "initial: "
      "{angle: 0.7, velocity: -1}}\n  tool: {mass: 0.4, inertia: 0.02, com: [0.2, 0], pin: [0.5, 0], "
      "initial: "
      "{angle: -0.4, velocity: 2}}\n";
  const std::string rods = links.substr(links.find("  rod"));
  const std::string within =  // the chain
      "  tube: {mass: 0.7, inertia: 0.1, com: [0.1, 0.2], pin: [0.3, 0.1], joint: {type: prismatic, axis: "
      "[1, -2], rotor_inertia: 3}, initial: {position: 0.4, velocity: -0.8}}\n";
  for (const std::string& text : {"chain: [cart, rod, tool]\n" + links, "chain: [rod, tool]\nlinks:\n" + rods,
                                  "chain: [rod, tube, tool]\nlinks:\n" + rods + within}) {
    const Scene scene =
        readSceneText(text + "base: {angle: {offset: 2.5}, x: {amplitude: 0.3, frequency: 1}}\n");
    const int n = scene.chain.size();
    Simulation simulation(scene);
    std::vector<LinkMotion> motions(static_cast<std::size_t>(n));
    simulation.linkMotions(motions.data());
    std::vector<double> angles;
    for (const LinkMotion& motion : motions) angles.push_back(motion.angle);
    Pull pull(scene.chain);
    const Vec2d tip{0.3, 0.2};
    const auto turn = Rotation<double>::of(2.5);
    const Vec2d baseVelocity{0.3 * 2 * pi, 0};
    for (int link = 0; link < n; ++link) {
      const LinkMotion& its = motions[static_cast<std::size_t>(link)];
      const PointMotion still = pull.motionOf(scene.q.data(), scene.qd.data(), link, tip);
      const PointMotion moved =
          pull.motionOf(angles.data(), scene.q.data(), {its.com, its.velocity, its.omega}, link, tip);
      EXPECT_LT(length(moved.position - turn * still.position), 1e-14) << link;
      EXPECT_LT(length(moved.velocity - turn * still.velocity - baseVelocity), 1e-13) << link;
      EXPECT_LT(length(moved.turn * Vec2d{1, 0} - turn * (still.turn * Vec2d{1, 0})), 1e-14) << link;
      const Vec2d target = turn * Vec2d{1, -2};
      const Vec2d force = pull.force(moved, target + moved.position, 3);
      PointMotion same = still;
      same.velocity = Rotation<double>::of(-2.5) * moved.velocity;
      EXPECT_LT(length(force - turn * pull.force(same, Vec2d{1, -2} + still.position, 3)), 1e-11) << link;
    }
  }
}

TEST(Pull, PointMovesAsItsPositionChanges) {
  constexpr double h = 1e-6;
  for (int n = 1; n <= 20; ++n) {
    const Case c(n);
    const auto positionAfter = [&](double t) {
      const Eigen::VectorXd q = c.q + t * c.qd;
      return Pull(c.scene.chain).motionOf(q.data(), c.qd.data(), c.link, c.point).position;
    };
    const Vec2d rate = 1 / (2 * h) * (positionAfter(h) - positionAfter(-h));
    EXPECT_NEAR(c.motion.velocity.x, rate.x, 1e-7 * n) << n;
    EXPECT_NEAR(c.motion.velocity.y, rate.y, 1e-7 * n) << n;
  }
}

TEST(Pull, ForceAddsTheAccelerationOfCriticalDamping) {
  constexpr double pulsation = 7;
  const Vec2d target{0.3, -0.4};
  int bounded = 0;
  for (int n = 1; n <= 20; ++n) {
    const Case c(n);
    const Vec2d force = Pull(c.scene.chain).force(c.motion, target, pulsation);
    const Vec2d wanted =
        pulsation * pulsation * (target - c.motion.position) - 2 * pulsation * c.motion.velocity;
    Eigen::Matrix2d mobility;
    mobility << c.motion.mobility.xx, c.motion.mobility.xy, c.motion.mobility.xy, c.motion.mobility.yy;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(mobility);
    double mass = 0;
    for (const Link& link : c.scene.chain.links()) mass += link.mass;
    const Eigen::Vector2d added = c.added(force);
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector2d u = axes.eigenvectors().col(k);
      const double along = u.dot(Eigen::Vector2d(wanted.x, wanted.y));
      if (axes.eigenvalues()(k) > 1 / mass) {
        EXPECT_NEAR(u.dot(added), along, 1e-9 * length(wanted)) << n;
      } else {
        ++bounded;
        EXPECT_NEAR(u.dot(Eigen::Vector2d(force.x, force.y)), mass * along, 1e-9 * mass * length(wanted))
            << n;
      }
    }
  }
  EXPECT_GT(bounded, 0);
  EXPECT_LT(bounded, 20);
}

/// A uniform rod with a rotor is bounded as a rod that has its inertia and the rotor's.
TEST(Pull, RodWithARotorIsBoundedAsAHeavierRod) {
  constexpr double J = 8;
  const Link rod{"rod", 3, 1, {1, 0}, {2, 0}};
  const Link heavier{"rod", 3 + 3 * J / 4, 1 + J / 4, {1, 0}, {2, 0}};
  const Chain chain = withRotors({{rod}, {{"pin"}}, {}}, J), alike({heavier}, {{"pin"}}, {});
  Pull pull(chain), other(alike);
  const double q = 0.4, qd = 0.3;
  const Vec2d target{1, 2};
  for (const double x : {0.5, 2.}) {
    const Vec2d wanted = other.force(other.motionOf(&q, &qd, 0, {x, 0}), target, 10);
    const Vec2d force = pull.force(pull.motionOf(&q, &qd, 0, {x, 0}), target, 10);
    EXPECT_NEAR(force.x, wanted.x, 1e-12 * length(wanted));
    EXPECT_NEAR(force.y, wanted.y, 1e-12 * length(wanted));
  }
}

TEST(Pull, RodIsBoundedAlongItselfAndLightAcross) {
  // J = I + m r² = 1 about the pin: at 2 m it weighs 1/4 kg across.
  const Chain chain({{"rod", 3, 0.25, {0.5, 0}, {2, 0}}}, {{"pin"}}, {});
  Pull pull(chain);
  const double q = 0, qd = 0;
  const PointMotion tip = pull.motionOf(&q, &qd, 0, {2, 0});
  EXPECT_NEAR(tip.mobility.yy, 4, 1e-15);
  EXPECT_EQ(tip.mobility.xx, 0);
  const Vec2d force = pull.force(tip, {3, 1}, 10);
  EXPECT_NEAR(force.x, 3 * 100, 1e-12);
  EXPECT_NEAR(force.y, 0.25 * 100, 1e-13);
}

/// Ten links without gravity, the tip drawn 0.02 m aside from rest, the force anew each millisecond: the
/// exact solution d (1 − (1 + ωt) exp(−ωt)), but for the force that is held and what the chain does
/// meanwhile.
void expectCriticalDamping(double rotors) {
  constexpr double pulsation = 10, d = 0.02, tick = 1e-3;
  std::vector<Link> links;
  std::vector<Joint> joints;
  Scene scene{Chain({{"only", 1, 1, {}, {1, 0}}}, {{"only_joint"}}, {}), {}, {}, {}, {}, {}, 0};
  for (int i = 0; i < 10; ++i) {
    links.push_back({"link_" + std::to_string(i), 1, 1. / 12, {0.5, 0}, {1, 0}});
    joints.push_back({"joint_" + std::to_string(i)});
    scene.q.push_back(i % 2 == 0 ? 0.6 : -0.6);
    scene.qd.push_back(0);
  }
  scene.chain = withRotors({links, joints, {}}, rotors);
  Simulation simulation(scene, 16);
  Pull pull(scene.chain);
  const Vec2d tip{1, 0};
  const auto now = [&] { return pull.motionOf(simulation.q().data(), simulation.qd().data(), 9, tip); };
  const Vec2d begin = now().position, target = begin + Vec2d{0.6 * d, 0.8 * d};
  double farthest = 0;
  for (int k = 0; k < 1500; ++k) {
    const double t = k * tick;
    const Vec2d gone = now().position - begin;
    const double along = 0.6 * gone.x + 0.8 * gone.y;
    EXPECT_NEAR(along, d * (1 - (1 + pulsation * t) * std::exp(-pulsation * t)), 0.02 * d) << t;
    EXPECT_NEAR(0.8 * gone.x - 0.6 * gone.y, 0, 0.02 * d) << t;
    farthest = std::fmax(farthest, along);
    simulation.addForce(9, tip, pull.force(now(), target, pulsation), 0, tick);
    ASSERT_TRUE(simulation.advanceTo((k + 1) * tick));
  }
  EXPECT_LT(farthest, 1.001 * d);
  EXPECT_GT(farthest, 0.999 * d);
}

TEST(Pull, PointComesToItsPlaceAsFastAsItCanWithoutPassing) {
  expectCriticalDamping(0);
}

/// Rotors that are 60 times the inertia of a link about its pin.
TEST(Pull, PointDoesSoWithLargeRotors) {
  expectCriticalDamping(20);
}

}  // namespace
}  // namespace planar_chain
