/// The laws of effect_laws.h for each kind of effect that ships, alone and all together.

#include "effect_laws.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "effects/effect_kind.h"
#include "ode/methods.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"

namespace planar_chain {
namespace {

struct Acting {
  const char *name, *joint, *rest;
  int links = 5;
};

std::ostream& operator<<(std::ostream& out, const Acting& acting) {
  return out << acting.name;
}

/// A crooked chain that moves in all joints.
Scene sceneOf(const Acting& acting) {
  const std::string joint(acting.joint);
  return readSceneText(
      "chain: [a, b]\n"
      "links:\n"
      "  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], joint: {" +
      joint +
      "}, initial: {angle: 0.4, velocity: 2}}\n"
      "  b: {mass: 0.5, inertia: 0.05, com: [0.3, -0.05], pin: [0.6, 0.1], repeat: " +
      std::to_string(acting.links - 1) + ", joint: {" + joint +
      "}, initial: {angle: -0.5, velocity: -0.7}}\n" + acting.rest);
}

class EachEffect : public testing::TestWithParam<Acting> {};

TEST_P(EachEffect, ObeysTheLaws) {
  test::EffectLaws(sceneOf(GetParam()), 0.1).expectAll();
}

constexpr const char* loads =
    "loads:\n"
    "  push: {link: b_2, force: [3, -1], point: [0.2, 0.1], frequency: 1.5, phase: 0.3}\n"
    "  turn: {link: a, moment: 0.7}\n"
    "  ramp: {joint: b_1_joint, torque: 2, times: [0, 1], values: [0, 1]}\n";
constexpr const char* base =
    "base:\n"
    "  x: {amplitude: 0.2, frequency: 1.1, phase: 0.4}\n"
    "  y: {times: [0, 0.5, 1], values: [0, 0.3, 0.1]}\n"
    "  angle: {amplitude: 0.3, frequency: 0.8, phase: 0.2}\n";

INSTANTIATE_TEST_SUITE_P(
    Kinds, EachEffect,
    testing::Values(Acting{"none", "", ""},
                    Acting{"springs", "stiffness: 3, rest_angle: 0.2, damping: 0.4", ""},
                    Acting{"springs in lanes", "stiffness: 3, rest_angle: 0.2, damping: 0.4", "", 20},
                    Acting{"stops", "lower: -0.2, upper: 0.1, stop_stiffness: 50, stop_damping: 0.5", ""},
                    Acting{"friction", "friction: 0.3", ""}, Acting{"drag", "drag: 0.3", ""},
                    Acting{"drag of long chains", "drag: 0.3", "", 20},
                    Acting{"friction of long chains", "friction: 0.3", "", 20},
                    Acting{"rotors", "rotor_inertia: 0.2", ""}, Acting{"loads", "", loads},
                    Acting{"loads of long chains", "", loads, 20}, Acting{"a base", "", base},
                    Acting{"a base of long chains", "stiffness: 3", base, 20},
                    Acting{"a base with springs, rotors and friction",
                           "stiffness: 3, damping: 0.1, friction: 0.2, rotor_inertia: 0.1", base}));

TEST(AllEffects, ObeyTheLawsTogether) {
  Scene scene =
      sceneOf({"", "stiffness: 2, damping: 0.3, friction: 0.1, drag: 0.2, rotor_inertia: 0.05", base});
  const Scene loaded = sceneOf({"", "", loads});
  scene.loads = loaded.loads;
  test::EffectLaws(scene, 0.1).expectAll();
}

TEST(ADrive, ObeysTheLaws) {
  const Scene scene = readSceneText(
      std::string(
          "chain: [a, b, c]\n"
          "links:\n"
          "  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], initial: {angle: 0.4, velocity: 2}}\n"
          "  b: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], joint: {rotor_inertia: 0.1,\n"
          "      drive: {amplitude: 0.5, frequency: 0.7, phase: 0.3}}}\n"
          "  c: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], joint: {damping: 0.2},\n"
          "      initial: {angle: 1, velocity: 1}}\n") +
      base);
  test::EffectLaws(scene, 0.1).expectAll();
}

/// A spring k in the first joint from t = 0.5 s on, which is no switch: enter() changes its stiffness.
class LateSpring : public Effect {
 public:
  explicit LateSpring(double k) : most_(k) {}
  LoadKind mostActing() const override { return LoadKind::moments; }
  Powers apply(const ChainState& at, const Actions& to) override {
    to.N[0] -= k_ * at.theta[0];
    return {-k_ * at.theta[0] * at.omega[0], 0};
  }
  void addTorques(const ChainState& at, double* tau) override { tau[0] -= k_ * at.theta[0]; }
  void addStiffness(double* k, double* /*d*/) const override { k[0] += k_; }
  Powers powersAlong(const ChainState& at, const StateChange& along) override {
    return {-k_ * (at.theta[0] * along.v[0] + along.u[0] * at.omega[0]), 0};
  }
  void enter(double t) override { k_ = t < start ? 0 : most_; }
  double until() const override { return k_ > 0 ? std::numeric_limits<double>::infinity() : start; }

  static constexpr double start = 0.5;

 private:
  double most_, k_ = 0;
};

class LateSpringKind : public EffectKind {
 public:
  const std::vector<JointKey>& jointKeys() const override {
    static const std::vector<JointKey> keys{{"late", nullptr, NumberRule::from(0, "N m/rad")}};
    return keys;
  }
  std::unique_ptr<Effect> make(const Scene& scene) const override {
    const double k = scene.chain.joints().front().other("late");
    return k > 0 ? std::make_unique<LateSpring>(k) : nullptr;
  }
  void summarize(const Scene& /*scene*/, SceneWords& /*words*/) const override {}
};

TEST(AStiffnessThatChangesWithTime, IsKnownToEveryMethod) {
  static const LateSpringKind kind;
  const OtherEffectKinds kinds(kind);
  std::map<std::string, long long> steps;
  for (const std::string& method : ode::methodNames()) {
    SCOPED_TRACE(method);
    Simulation simulation(
        readSceneText("chain: [wheel]\n"
                      "gravity: [0, 0]\n"
                      "links:\n"
                      "  wheel: {mass: 1, inertia: 0.5, com: [0, 0], pin: [1, 0], joint: {late: 200}, "
                      "initial: {velocity: 3}}\n"
                      "integrator: {method: " +
                      method + ", tolerance: 1e-7, step: 0.0005}\n"));
    ASSERT_TRUE(simulation.advanceTo(1)) << simulation.fault();
    const double w = 20, turned = w * (1 - LateSpring::start);  // w² = 200/0.5
    EXPECT_NEAR(simulation.q()[0], 1.5 * std::cos(turned) + 3 / w * std::sin(turned), 1e-5);
    steps[method] = simulation.statistics().steps;
    EXPECT_EQ(simulation.statistics().rescues, 0) << "the energy does not fit the motion";
  }
  EXPECT_LT(steps["rodas5p"], steps["dopri5"]);
}

}  // namespace
}  // namespace planar_chain
