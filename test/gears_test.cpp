/// An energy that no single joint or body stores: a gear with an elastic tooth between the first joint and
/// the last, an effect of a program of its own.
///
///     V = ½ k (q_n − r q_1)²        τ_n = −k (q_n − r q_1)        τ_1 = −r τ_n

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "effect_laws.h"
#include "effects/effect_kind.h"
#include "planar_chain/scene_reader.h"

namespace planar_chain {
namespace {

struct Gear {
  double k, ratio;
  int first, last;

  explicit Gear(const Chain& chain)
      : k(chain.joints().back().other("gear_stiffness")),
        ratio(chain.joints().back().other("gear_ratio")),
        first(chain.coordinates().leading()),
        last(chain.size() - 1) {}

  double twist(double q1, double qn) const { return qn - ratio * q1; }
};

class Gears : public Effect {
 public:
  explicit Gears(const Scene& scene) : gear_(scene.chain), coordinates_(scene.chain.coordinates()) {}

  LoadKind mostActing() const override { return LoadKind::moments; }
  bool hasPower() const override { return false; }
  bool hasSeries() const override { return false; }
  Powers apply(const ChainState& at, const Actions& to) override {
    if (to.N) act(at.theta, [&](int joint, double torque) { coordinates_.addTorque(torque, joint, to.N); });
    return {};
  }
  void addTorques(const ChainState& at, double* tau) override {
    act(at.theta, [&](int joint, double torque) { tau[joint] += torque; });
  }

 private:
  template <class F>
  void act(const double* theta, F add) const {
    const double torque = -gear_.k * gear_.twist(coordinates_.relative(theta, gear_.first),
                                                 coordinates_.relative(theta, gear_.last));
    add(gear_.last, torque);
    add(gear_.first, -gear_.ratio * torque);
  }

  Gear gear_;
  Coordinates coordinates_;
};

class GearKind : public EffectKind {
 public:
  std::vector<JointKey> jointKeys() const override {
    return {{"gear_stiffness", nullptr, NumberRule::from(0, "N m/rad")},
            {"gear_ratio", nullptr, NumberRule::any("of rates")}};
  }
  std::unique_ptr<Effect> make(const Scene& scene) const override {
    return Gear(scene.chain).k > 0 ? std::make_unique<Gears>(scene) : nullptr;
  }
  void addDense(const Scene& scene, double /*t*/, const Eigen::VectorXd& q, const Eigen::VectorXd& /*qd*/,
                const DenseActions& to) const override {
    const Gear gear(scene.chain);
    const double torque = -gear.k * gear.twist(q[gear.first], q[gear.last]);
    to.tau[gear.last] += torque;
    to.tau[gear.first] -= gear.ratio * torque;
  }
  double energyBetween(const Chain& chain, const double* theta) const override {
    const Gear gear(chain);
    const Coordinates coordinates = chain.coordinates();
    const double twist =
        gear.twist(coordinates.relative(theta, gear.first), coordinates.relative(theta, gear.last));
    return gear.k / 2 * twist * twist;
  }
  double stiffnessOf(const Joint& joint) const override { return joint.other("gear_stiffness"); }
  void summarize(const Scene& /*scene*/, SceneWords& /*words*/) const override {}
};

std::string sceneOf(int links, const std::string& rest = "") {
  return "chain: [a, b, c]\nlinks:\n"
         "  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], initial: {angle: 0.4, velocity: 2}}\n"
         "  b: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], joint: {damping: 0.2}, repeat: " +
         std::to_string(links) +
         "}\n"
         "  c: {mass: 0.5, inertia: 0.05, com: [0.3, -0.05], pin: [0.6, 0.1],\n"
         "      initial: {angle: -0.5, velocity: -0.7}, joint: {gear_stiffness: 30, gear_ratio: -2}}\n" +
         rest;
}

class EnergyOfThePose : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    static const GearKind kind;
    effectKinds().push_back(&kind);
  }
};

TEST_F(EnergyOfThePose, ObeysTheLawsThatNeedNoTangent) {
  for (const int between : {1, 3, 18}) {
    SCOPED_TRACE(between);
    test::EffectLaws(readSceneText(sceneOf(between)), 0.1).expectAllButTangents();
  }
}

/// The guard on a run compares the same energy.
TEST_F(EnergyOfThePose, IsInTheBalance) {
  Simulation simulation(readSceneText(sceneOf(1, "integrator: {tolerance: 1e-9}\n")));
  simulation.advanceTo(2.0);
  EXPECT_LT(std::abs(simulation.energyBalance().residual), 1e-7);
}

}  // namespace
}  // namespace planar_chain
