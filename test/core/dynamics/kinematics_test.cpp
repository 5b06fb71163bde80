/// Places, velocities, accelerations and Jacobians against the chain drawn by complex numbers of long double:
/// rates by central differences of order 8, which err by less than 1e-15. Joint angles for a place against
/// that place.

#include "planar_chain/kinematics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "planar_chain/kane.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Long = long double;
using Place = std::complex<Long>;  // x + iy
using Angles = std::vector<Long>;
using test::Random;

constexpr double t0 = 0.3;

/// Any chain: prismatic joints anywhere, a base that moves.
Scene anyChain(unsigned seed, bool baseMoves) {
  Random random(seed);
  const int n = 1 + random.index(6);
  std::vector<Link> links;
  std::vector<Joint> joints;
  Scene scene = test::randomScene(n, seed, {false, false, false});
  for (int i = 0; i < n; ++i) {
    links.push_back(scene.chain.links()[index(i)]);
    joints.push_back(scene.chain.joints()[index(i)]);
    joints.back().isPrismatic = random.index(3) == 0;
    joints.back().axis = random.vector(1);
  }
  scene.chain = Chain(links, joints, {});
  const auto law = [&] {
    return MotionLaw::sine(random.between(-1, 1), random.between(0.1, 1), random.between(-3, 3),
                           random.between(-1, 1));
  };
  if (baseMoves) scene.base = BaseLaws{law(), law(), law()};
  return scene;
}

/// A law at a time near t0, in long double.
Long lawAt(const MotionLaw& law, Long t) {
  const Long turn = 8 * std::atan(1.0L) * static_cast<Long>(law.frequency()) * t;
  return static_cast<Long>(law.pieces()[0].c[0]) +
         static_cast<Long>(law.amplitude()) * std::sin(turn + static_cast<Long>(law.phase()));
}

struct Drawn {
  Place place;
  Long angle;
};

/// The frame of a chain with these q, by hand.
Drawn draw(const Scene& scene, const Frame& frame, Long t, const Angles& q) {
  Place at = 0;
  Long angle = 0;
  if (scene.base) {
    at = {lawAt(scene.base->x, t), lawAt(scene.base->y, t)};
    angle = lawAt(scene.base->angle, t);
  }
  const auto along = [&](Vec2d v) { return Place(v.x, v.y) * std::polar(1.0L, angle); };
  for (int i = 0;; ++i) {
    const Joint& joint = scene.chain.joints()[index(i)];
    if (joint.isPrismatic) {
      at += q[index(i)] * along(joint.axis);
    } else {
      angle += q[index(i)];
    }
    if (i == frame.link) break;
    at += along(scene.chain.links()[index(i)].pin);
  }
  return {at + along(frame.point), angle + static_cast<Long>(frame.angle)};
}

/// f'(0) and f''(0), of order 8.
Place slope(const std::function<Place(Long)>& f) {
  constexpr Long h = 2e-3L;
  return (4.0L / 5 * (f(h) - f(-h)) - 1.0L / 5 * (f(2 * h) - f(-2 * h)) +
          4.0L / 105 * (f(3 * h) - f(-3 * h)) - 1.0L / 280 * (f(4 * h) - f(-4 * h))) /
         h;
}
Place bend(const std::function<Place(Long)>& f) {
  constexpr Long h = 2e-3L;
  return (-205.0L / 72 * f(0) + 8.0L / 5 * (f(h) + f(-h)) - 1.0L / 5 * (f(2 * h) + f(-2 * h)) +
          8.0L / 315 * (f(3 * h) + f(-3 * h)) - 1.0L / 560 * (f(4 * h) + f(-4 * h))) /
         (h * h);
}

void expectNear(Vec2d found, Place exact, const char* what) {
  const Long size = 1 + std::abs(exact);
  EXPECT_NEAR(found.x, static_cast<double>(exact.real()), static_cast<double>(1e-12L * size)) << what;
  EXPECT_NEAR(found.y, static_cast<double>(exact.imag()), static_cast<double>(1e-12L * size)) << what;
}

TEST(Kinematics, AgreesWithDifferencesInLongDouble) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = anyChain(seed, seed % 3 == 0);
    Random random(seed);
    const auto n = static_cast<Eigen::Index>(scene.q.size());
    VectorXd q(n), qd(n), qdd(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      q[i] = random.between(-3, 3);
      qd[i] = random.between(-1, 1);
      qdd[i] = random.between(-1, 1);
    }
    const Frame frame{"point", random.index(scene.chain.size()), random.vector(1), random.between(-1, 1)};
    const auto along = [&](Long t, double speeds) {
      Angles at;
      for (Eigen::Index i = 0; i < n; ++i)
        at.push_back(q[i] + t * static_cast<Long>(speeds * qd[i]) +
                     t * t / 2 * static_cast<Long>(speeds * qdd[i]));
      return at;
    };
    const auto place = [&](Long t) { return draw(scene, frame, t0 + t, along(t, 1)).place; };
    const auto angle = [&](Long t) { return Place(draw(scene, frame, t0 + t, along(t, 1)).angle); };

    const FrameMotion found = motionOf(scene, frame, t0, q, qd, qdd);
    expectNear(found.position, place(0), "position");
    expectNear(found.velocity, slope(place), "velocity");
    expectNear(found.acceleration, bend(place), "acceleration");
    expectNear({found.angle, found.rate}, {angle(0).real(), slope(angle).real()}, "angle, rate");
    expectNear({found.angularAcceleration, 0}, bend(angle), "angular acceleration");

    const MatrixXd J = jacobianOf(scene, frame, t0, q);
    ASSERT_EQ(J.rows(), 3);
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto nudged = [&](Long by) {
        Angles at = along(0, 0);
        at[static_cast<std::size_t>(j)] += by;
        return draw(scene, frame, t0, at);
      };
      expectNear({J(0, j), J(1, j)}, slope([&](Long by) { return nudged(by).place; }), "J");
      expectNear({J(2, j), 0}, slope([&](Long by) { return Place(nudged(by).angle); }), "J of the angle");
    }
  }
}

TEST(Kinematics, OfASimulationIsThatOfItsState) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const Scene scene = anyChain(seed, seed % 3 == 0);
    Simulation simulation(scene);
    ASSERT_TRUE(simulation.advanceTo(t0)) << simulation.fault();
    const auto n = static_cast<Eigen::Index>(scene.q.size());
    VectorXd qdd(n);
    simulation.accelerations(qdd.data());
    const Frame tip = frameNamed(scene, "tip");
    const FrameMotion found = simulation.motion(tip);
    const FrameMotion exact = motionOf(scene, tip, t0, VectorXd::Map(simulation.q().data(), n),
                                       VectorXd::Map(simulation.qd().data(), n), qdd);
    const double size = 1 + length(exact.acceleration);
    for (const auto& [a, b] : {std::pair(found.position, exact.position),
                               {found.velocity, exact.velocity},
                               {found.acceleration, exact.acceleration}}) {
      EXPECT_LT(length(a - b), 1e-11 * size) << seed;
    }
    EXPECT_NEAR(found.angle, exact.angle, 1e-12);
    EXPECT_NEAR(found.angularAcceleration, exact.angularAcceleration, 1e-11 * size);
  }
}

// ---- Joint angles for a place -----------------------------------------------------------------------

const std::string arm = R"(
chain: [boom, stick, bucket]
links:
  boom: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {lower: -1, upper: 2}}
  stick: {mass: 1, inertia: 0.1, com: [0.4, 0], pin: [0.8, 0.1], joint: {type: prismatic, axis: [1, 0.2], lower: -0.2, upper: 0.5}}
  bucket: {mass: 1, inertia: 0.1, com: [0.2, 0], pin: [0.4, 0], joint: {lower: -2.5, upper: 0.1}}
frames: {gripper: {link: bucket, point: [0.3, -0.1], angle: 0.5}}
)";

TEST(InverseKinematics, GetsToEveryPlaceThatAStateHas) {
  const Scene scene = readSceneText(arm);
  const Frame gripper = frameNamed(scene, "gripper");
  Random random(1);
  for (int k = 0; k < 50; ++k) {
    VectorXd q(3);
    q << random.between(-1, 2), random.between(-0.2, 0.5), random.between(-2.5, 0.1);
    const VectorXd still = VectorXd::Zero(3);
    const FrameMotion there = motionOf(scene, gripper, 0, q, still, still);
    for (const bool hasAngle : {false, true}) {
      const auto angle = hasAngle ? std::optional(there.angle + 2 * pi) : std::nullopt;
      const Reached reached = inverseKinematics(scene, gripper, there.position, angle);
      ASSERT_TRUE(reached.isReached) << k << ": " << reached.distance << " m, " << reached.turn << " rad";
      const FrameMotion found = motionOf(scene, gripper, 0, reached.q, still, still);
      EXPECT_LT(length(found.position - there.position), 4e-12);
      if (hasAngle) {
        EXPECT_NEAR(found.angle, there.angle, 1e-11);
      }
      for (Eigen::Index i = 0; i < 3; ++i) {
        const Joint& joint = scene.chain.joints()[static_cast<std::size_t>(i)];
        EXPECT_GE(reached.q[i], joint.lower);
        EXPECT_LE(reached.q[i], joint.upper);
      }
    }
  }
}

TEST(InverseKinematics, TellsTheDistanceThatIsLeft) {
  // Two rods of 1 m: stretched towards the place, or, if it is too near, folded as far as the limit lets
  // them.
  const std::string rod = "{mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]";
  const std::string rods = "chain: [a, b]\nlinks: {a: " + rod + "}, b: " + rod;
  const Scene free = readSceneText(rods + "}}"),
              limited = readSceneText(rods + ", joint: {lower: -1, upper: 1}}}");
  const Reached far = inverseKinematics(free, frameNamed(free, "tip"), {3, 4});
  EXPECT_FALSE(far.isReached);
  EXPECT_NEAR(far.distance, 3, 1e-12);
  EXPECT_NEAR(far.q[0], std::atan2(4, 3), 1e-5);
  const Reached near = inverseKinematics(limited, frameNamed(limited, "tip"), {0, 0.5});
  EXPECT_FALSE(near.isReached);
  EXPECT_NEAR(near.distance, 2 * std::cos(0.5) - 0.5, 1e-12);
  EXPECT_NEAR(std::abs(near.q[1]), 1, 1e-12);
}

TEST(InverseKinematics, LeavesDrivenJointsWhereTheyAre) {
  const Scene scene = readSceneText(R"(
chain: [a, b, c]
links:
  a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {drive: {amplitude: 0.4, frequency: 1}}}
  b: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]}
  c: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]}
base: {x: {offset: 0.2, amplitude: 0.1, frequency: 1}}
)");
  const double when = 0.2, driven = 0.4 * std::sin(2 * pi * when);
  const Reached reached = inverseKinematics(scene, frameNamed(scene, "tip"), {0.5, 1.1}, {}, {}, when);
  EXPECT_TRUE(reached.isReached);
  EXPECT_NEAR(reached.q[0], driven, 1e-15);
  const VectorXd still = VectorXd::Zero(3);
  const Vec2d there = motionOf(scene, frameNamed(scene, "tip"), when, reached.q, still, still).position;
  EXPECT_LT(length(there - Vec2d{0.5, 1.1}), 4e-12);
}

TEST(Kinematics, RefusesWhatIsNotThere) {
  const Scene scene = readSceneText(arm);
  const VectorXd q = VectorXd::Zero(3), two = VectorXd::Zero(2);
  EXPECT_THROW(frameNamed(scene, "griper"), Refused);
  EXPECT_THROW(jacobianOf(scene, {"", 3, {}}, 0, q), Refused);
  EXPECT_THROW(jacobianOf(scene, {"", 0, {}}, 0, two), Refused);
  EXPECT_THROW(motionOf(scene, {"", 0, {}}, 0, q, two, q), Refused);
  EXPECT_THROW(inverseKinematics(scene, {"", 0, {}}, {NAN, 0}), Refused);
}

}  // namespace
}  // namespace planar_chain
