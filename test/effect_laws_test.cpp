/// The laws of effect_laws.h for each kind of effect that ships, alone and all together.

#include "effect_laws.h"

#include <gtest/gtest.h>

#include <string>

#include "planar_chain/scene_reader.h"

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

}  // namespace
}  // namespace planar_chain
