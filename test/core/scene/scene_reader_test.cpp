/// What a scene means once it is accepted: defaults, repetitions, loads, the spellings of YAML. What is
/// refused is in bad_scenes; here are only the refusals that need more than a file.

#include "planar_chain/scene_reader.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "planar_chain/simulation.h"

namespace planar_chain {
namespace {

/// A chain of two rods, with `more` at the end.
std::string two(const std::string& more = "") {
  return "chain: [upper, lower]\n"
         "links:\n"
         "  upper: {mass: 1, inertia: 0.25, com: [0.5, 0.1], pin: [1, 0.2]}\n"
         "  lower: {mass: 2, inertia: 0.5, com: [0.4, 0], pin: [0.8, 0]}\n" +
         more;
}

std::string oneLink(const std::string& more) {
  return "chain: [l]\nlinks: {l: {mass: 1, inertia: 1, com: [0.5, 0], pin: [1, 0], " + more + "}}\n";
}

std::string faultsIn(const std::string& yaml) {
  try {
    readSceneText(yaml);
  } catch (const Refused& refused) {
    return refused.what();
  }
  return "";
}

std::vector<std::string> namesOf(const std::vector<Link>& links) {
  std::vector<std::string> names;
  for (const Link& link : links) names.push_back(link.name);
  return names;
}

using Names = std::vector<std::string>;

// ---- Links and the chain ---------------------------------------------------------------------

TEST(SceneReader, ReadsEveryKeyOfALink) {
  const Scene scene =
      readSceneText(oneLink("joint: {name: pivot, damping: 1, stiffness: 2, rest_angle: -3}, "
                            "initial: {angle: 0.25, velocity: -4}"));
  const Link& link = scene.chain.links().at(0);
  EXPECT_EQ(link.name, "l");
  EXPECT_EQ(link.mass, 1);
  EXPECT_EQ(link.com, (Vec2d{0.5, 0}));
  EXPECT_EQ(link.pin, (Vec2d{1, 0}));
  const Joint& joint = scene.chain.joints().at(0);
  EXPECT_EQ(joint.name, "pivot");
  EXPECT_EQ(joint.damping, 1);
  EXPECT_EQ(joint.stiffness, 2);
  EXPECT_EQ(joint.restAngle, -3);
  EXPECT_EQ(scene.q, std::vector<double>{0.25});
  EXPECT_EQ(scene.qd, std::vector<double>{-4});
}

TEST(SceneReader, DefaultsAreThoseOfTheManual) {
  const Scene scene = readSceneText(two());
  EXPECT_EQ(scene.chain.gravity(), (Vec2d{0, -9.81}));
  EXPECT_EQ(scene.chain.joints()[1].name, "lower_joint");
  EXPECT_EQ(scene.chain.joints()[1].damping, 0);
  EXPECT_EQ(scene.chain.joints()[1].stiffness, 0);
  EXPECT_EQ(scene.q, (std::vector<double>{0, 0}));
  EXPECT_TRUE(scene.loads.empty());
  EXPECT_EQ(scene.integrator.method, "auto");
  EXPECT_EQ(scene.integrator.tolerance, 1e-8);
  EXPECT_EQ(scene.integrator.step, 1e-3);
  EXPECT_EQ(scene.publish.rate, 200);
  EXPECT_EQ(scene.publish.tfRate, 50);
  EXPECT_EQ(scene.publish.statusRate, 10);
  EXPECT_TRUE(scene.publish.tf);
  EXPECT_TRUE(scene.publish.linkStates);
  EXPECT_FALSE(scene.publish.framePrefix);
  EXPECT_EQ(scene.publish.worldFrame, "world");
  EXPECT_EQ(scene.publish.baseFrame, "base_link");
  EXPECT_EQ(scene.commandTimeout, 0);
}

TEST(SceneReader, ChainGivesTheOrder) {
  const Scene scene = readSceneText(
      "chain: [z, a]\nlinks:\n  a: {mass: 1, inertia: 1, com: [0, 0], pin: [1, 0]}\n"
      "  z: {mass: 2, inertia: 1, com: [0, 0], pin: [1, 0]}\n");
  EXPECT_EQ(namesOf(scene.chain.links()), (Names{"z", "a"}));
  EXPECT_EQ(scene.chain.links()[0].mass, 2);
}

TEST(SceneReader, RepeatMakesLinksAlike) {
  const Scene scene = readSceneText(oneLink("repeat: 3, initial: {angle: 0.5}"));
  EXPECT_EQ(namesOf(scene.chain.links()), (Names{"l_1", "l_2", "l_3"}));
  EXPECT_EQ(scene.chain.joints()[2].name, "l_3_joint");
  EXPECT_EQ(scene.q, (std::vector<double>{0.5, 0.5, 0.5}));
}

TEST(SceneReader, RepeatCountsTheJointsOwnName) {
  const Scene scene = readSceneText(oneLink("repeat: 2, joint: {name: pivot}"));
  EXPECT_EQ(scene.chain.joints()[0].name, "pivot_1");
  EXPECT_EQ(scene.chain.joints()[1].name, "pivot_2");
}

TEST(SceneReader, RepeatOfOneKeepsTheName) {
  EXPECT_EQ(readSceneText(oneLink("repeat: 1")).chain.links()[0].name, "l");
}

TEST(SceneReader, TheLargestChainIsRead) {
  EXPECT_EQ(readSceneText(oneLink("repeat: 100000")).chain.size(), 100000);
}

/// Were the links of a faulty entry written out before it is judged, this would take minutes and
/// gigabytes.
TEST(SceneReader, RefusesHugeRepetitionsAtOnce) {
  std::string yaml = "links:\n";
  std::string chain = "chain: [";
  for (int i = 0; i < 900; ++i) {
    const std::string name = "l" + std::to_string(i);
    chain += name + ", ";
    yaml += "  " + name + ": {mass: -1, inertia: 1, com: [0, 0], pin: [1, 0], repeat: 100000}\n";
  }
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_NE(faultsIn(chain + "]\n" + yaml).find("chain: expected at most 100000 links"), std::string::npos);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

TEST(SceneReader, AStopWithoutAStiffnessIsAsStiffAsTheChainIsHeavy) {
  // J of both rods about the inner pin, stretched: the outer centre of mass is |p| + 0.4 m away.
  const std::string limited = "joint: {upper: 1}, ";
  std::string yaml = two();
  for (const char* link : {"upper: {", "lower: {"}) yaml.insert(yaml.find(link) + 8, limited);
  const std::vector<Joint> joints = readSceneText(yaml).chain.joints();
  const double outer = 0.5 + 2 * 0.4 * 0.4;
  const double both = 0.25 + 0.26 + 0.5 + 2 * std::pow(std::sqrt(1.04) + 0.4, 2);
  EXPECT_NEAR(joints[1].stopStiffness, outer / 25e-6, 1e-9);
  EXPECT_NEAR(joints[0].stopStiffness, both / 25e-6, 1e-8);
  yaml.replace(yaml.find("upper: 1}"), 9, "upper: 1, stop_stiffness: 7}");
  EXPECT_EQ(readSceneText(yaml).chain.joints()[0].stopStiffness, 7);
}

TEST(SceneReader, ADefaultStopIsDampedUnlessTheSceneGivesItsDampingOrStiffness) {
  const auto dampingOf = [](const std::string& keys) {
    return readSceneText("gravity: [0, 0]\n" + oneLink("joint: {upper: 0.1" + keys + "}"))
        .chain.joints()[0]
        .stopDamping;
  };
  EXPECT_EQ(dampingOf(", stop_damping: 0"), 0);
  EXPECT_EQ(dampingOf(", stop_damping: 3"), 3);
  EXPECT_EQ(dampingOf(", stop_stiffness: 7"), 0);
  EXPECT_GT(dampingOf(""), 0);
  // ẍ = −2 ζ ω ẋ − ω² x until it is 0, ω = 200/s, ζ = 0.4: depth and rate by its closed form.
  const Scene scene = readSceneText("gravity: [0, 0]\nintegrator: {tolerance: 1e-12}\n" +
                                    oneLink("joint: {upper: 0.1}, initial: {angle: 0.1, velocity: 2}"));
  const double zeta = 0.4, root = std::sqrt(1 - zeta * zeta), phase = std::acos(zeta);
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(0.005 * phase / root));
  EXPECT_NEAR(simulation.q()[0], 0.1 + 0.01 * std::exp(-zeta * phase / root), 1e-11);
  EXPECT_NEAR(simulation.qd()[0], 0, 1e-8);
  ASSERT_TRUE(simulation.advanceTo(0.02));
  EXPECT_NEAR(simulation.qd()[0], -2 * std::exp(-2 * zeta * phase / root), 1e-8);
}

TEST(SceneReader, AJointGoesFiveMillisecondsOfItsRateIntoADefaultStopWithoutDamping) {
  const Scene scene =
      readSceneText("gravity: [0, 0]\n" +
                    oneLink("joint: {upper: 0.1, stop_damping: 0}, initial: {angle: 0.1, velocity: 2}"));
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(pi / 2 * 0.005));
  EXPECT_NEAR(simulation.q()[0], 0.1 + 2 * 0.005, 1e-9);
  ASSERT_TRUE(simulation.advanceTo(0.02));
  EXPECT_NEAR(simulation.qd()[0], -2, 1e-7);
}

TEST(SceneReader, EmptyMapsAreAsGoodAsAbsentOnes) {
  EXPECT_EQ(faultsIn(two("loads: {}\nintegrator: {}\npublish: {}\n")), "");
}

// ---- Loads -----------------------------------------------------------------------------------

TEST(SceneReader, ReadsEveryKeyOfALoad) {
  const Scene scene =
      readSceneText(two("loads:\n  push: {link: lower, force: [1, -2], point: [3, 4], moment: 5, joint: "
                        "upper_joint, torque: 6, start: 7, stop: 8, frequency: 9, phase: 10}\n"));
  const Load& load = scene.loads.at(0);
  EXPECT_EQ(load.name, "push");
  EXPECT_EQ(load.link, 1);
  EXPECT_EQ(load.force, (Vec2d{1, -2}));
  EXPECT_EQ(load.point, (Vec2d{3, 4}));
  EXPECT_EQ(load.moment, 5);
  EXPECT_EQ(load.joint, 0);
  EXPECT_EQ(load.torque, 6);
  EXPECT_EQ(load.start, 7);
  EXPECT_EQ(load.stop, 8);
  EXPECT_EQ(std::get<Sine>(load.law).frequency, 9);
  EXPECT_EQ(std::get<Sine>(load.law).phase, 10);
}

TEST(SceneReader, AForceActsAtTheCentreOfMassWhereNothingElseIsSaid) {
  const Scene scene = readSceneText(two("loads: {push: {link: upper, force: [1, 0]}}\n"));
  EXPECT_EQ(scene.loads.at(0).point, (Vec2d{0.5, 0.1}));
  EXPECT_EQ(scene.loads[0].joint, Load::none);
  EXPECT_TRUE(std::holds_alternative<Constant>(scene.loads[0].law));
  EXPECT_EQ(scene.loads[0].start, 0);
  EXPECT_EQ(scene.loads[0].stop, std::numeric_limits<double>::infinity());
}

TEST(SceneReader, LoadsComeByName) {
  const Scene scene = readSceneText(
      two("loads:\n  b: {joint: upper_joint, torque: 1}\n  a: {joint: lower_joint, torque: 2}\n"));
  ASSERT_EQ(scene.loads.size(), 2U);
  EXPECT_EQ(scene.loads[0].name, "a");
  EXPECT_EQ(scene.loads[0].joint, 1);
}

TEST(SceneReader, ReadsRamps) {
  const Scene scene = readSceneText(
      two("loads: {r: {joint: upper_joint, torque: 1, times: [-1, 0, 1e0], values: [0, 2, 0]}}\n"));
  const Ramp& ramp = std::get<Ramp>(scene.loads.at(0).law);
  EXPECT_EQ(ramp.times, (std::vector<double>{-1, 0, 1}));
  EXPECT_EQ(ramp.values, (std::vector<double>{0, 2, 0}));
}

/// A fault of a link's values leaves the names certain, so loads are still held against them; a fault
/// of the names does not accuse the loads.
TEST(SceneReader, JudgesLoadsByNamesOnlyWhereNamesAreCertain) {
  const std::string load = "loads: {p: {link: rope_7, force: [1, 0]}}\n";
  const auto rope = [&](const std::string& mass, const std::string& repeat) {
    return "chain: [rope]\nlinks: {rope: {mass: " + mass + ", repeat: " + repeat +
           ", inertia: 1, com: [0, 0], pin: [1, 0]}}\n" + load;
  };
  EXPECT_EQ(faultsIn(rope("1", "7")), "");
  EXPECT_NE(faultsIn(rope("-1", "3")).find("loads/p/link"), std::string::npos);
  EXPECT_NE(faultsIn(rope("1", "many")).find("links/rope/repeat"), std::string::npos);
  EXPECT_EQ(faultsIn(rope("1", "many")).find("loads/p/link"), std::string::npos);
}

// ---- publish ---------------------------------------------------------------------------------

TEST(SceneReader, NotesAnglesThatMayBeDegrees) {
  const auto notesOf = [](const std::string& angle, const std::string& limits) {
    std::string notes;
    const Scene scene = readSceneText(
        "chain: [a]\nlinks: {a: {mass: 1, inertia: 1, com: [1, 0], pin: [1, 0], initial: {angle: " + angle +
        "}, joint: " + limits + "}}");
    for (const Note& note : scene.notes) notes += toString(note) + "\n";
    return notes;
  };
  EXPECT_EQ(notesOf("12.5", "{lower: -12.5, stiffness: 1, rest_angle: 12.5}"), "");
  EXPECT_EQ(notesOf("90", "{upper: 1e3}"),
            "links/a/initial/angle: 90 rad are 14.3 turns (angles are in rad, not in degrees)\n"
            "links/a/joint/upper: 1000 rad are 159 turns (angles are in rad, not in degrees)\n");
}

/// The energy is k x²/2 by hand.
TEST(SceneReader, NotesAStartBeyondALimit) {
  const auto notesOf = [](const std::string& joint, const std::string& more = "") {
    std::string notes;
    const Scene scene = readSceneText(
        "chain: [a, b]\nlinks: {a: {mass: 1, inertia: 1, com: [1, 0], pin: [1, 0], joint: " + joint +
        "}, b: {mass: 1, inertia: 1, com: [1, 0], pin: [1, 0], initial: {angle: 1.5}, joint: {upper: "
        "1.5}}}\n" +
        more);
    for (const Note& note : scene.notes) notes += toString(note) + "\n";
    return notes;
  };
  const std::string excluded = "{lower: -2.6, upper: -0.2, stop_stiffness: 4200}";
  EXPECT_EQ(
      notesOf(excluded),
      "links/a/initial: a_joint begins at 0 rad, above upper (-0.2 rad): its stop releases 84 J at once "
      "(another initial/angle, or start: rest, avoids this)\n");
  EXPECT_EQ(
      notesOf("{lower: 0.1, stop_stiffness: 100}"),
      "links/a/initial: a_joint begins at 0 rad, below lower (0.1 rad): its stop releases 0.5 J at once "
      "(another initial/angle, or start: rest, avoids this)\n");
  EXPECT_EQ(notesOf("{type: prismatic, lower: 0.1, stop_stiffness: 100}"),
            "links/a/initial: a_joint begins at 0 m, below lower (0.1 m): its stop releases 0.5 J at once "
            "(another initial/position, or start: rest, avoids this)\n");
  EXPECT_EQ(notesOf("{lower: 0, upper: 1}"), "");
  EXPECT_EQ(notesOf(excluded, "start: rest\n"), "");  // it leans on its stop
}

TEST(SceneReader, DefaultRatesKeepBelowTheRate) {
  const Scene scene = readSceneText(two("publish: {rate: 5}\n"));
  EXPECT_EQ(scene.publish.tfRate, 5);
  EXPECT_EQ(scene.publish.statusRate, 5);
}

TEST(SceneReader, ReadsEveryKeyOfPublish) {
  const Scene scene =
      readSceneText(two("publish: {rate: 100, tf_rate: 20, status_rate: 2, tf: off, link_states: no, "
                        "frame_prefix: left/, world_frame: map, base_frame: wall}\ncommand_timeout: 0.5\n"));
  EXPECT_EQ(scene.publish.rate, 100);
  EXPECT_EQ(scene.publish.tfRate, 20);
  EXPECT_EQ(scene.publish.statusRate, 2);
  EXPECT_FALSE(scene.publish.tf);
  EXPECT_FALSE(scene.publish.linkStates);
  EXPECT_EQ(scene.publish.framePrefix, "left/");
  EXPECT_EQ(scene.publish.worldFrame, "map");
  EXPECT_EQ(scene.publish.baseFrame, "wall");
  EXPECT_EQ(scene.commandTimeout, 0.5);
}

TEST(SceneReader, AnEmptyPrefixIsNoDefault) {
  EXPECT_EQ(readSceneText(two("publish: {frame_prefix: ''}\n")).publish.framePrefix, "");
}

TEST(SceneReader, TakesTheTextOfAUrdf) {
  const std::string robot =
      "<robot name='r'><link name='ground'/><link name='rod'><inertial><mass value='2'/><inertia ixx='1' "
      "iyy='1' izz='1'/></inertial></link><joint name='pin' type='continuous'><parent link='ground'/>"
      "<child link='rod'/></joint></robot>";
  for (const char* before : {"", "\n  ", "\xEF\xBB\xBF<?xml version='1.0'?>\n"}) {
    EXPECT_EQ(readSceneText(before + robot).chain.joints().at(0).name, "pin");
  }
  EXPECT_EQ(readSceneText("<<: {gravity: [0, 0]}\n" + two()).chain.gravity(), Vec2d());
}

// ---- Scenes that ship ------------------------------------------------------------------------

TEST(SceneReader, ReadsEverySceneThatShips) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(SCENES_DIR)) {
    std::ifstream file(entry.path());
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(faultsIn(text), "") << entry.path();
    ++count;
  }
  EXPECT_GE(count, 6);
}

/// The force of the BEAM problem, 1.5 sin² t, is written there as two loads.
TEST(SceneReader, TheBeamsLoadsAreTheProblems) {
  std::ifstream file(SCENES_DIR "/beam.yaml");
  const Scene scene = readSceneText({std::istreambuf_iterator<char>(file), {}});
  ASSERT_EQ(scene.chain.size(), 40);
  ASSERT_EQ(scene.loads.size(), 2U);
  for (const double t : {0.0, 0.5, 1.0, 2.0, 3.0}) {
    double phi = 0;
    for (const Load& load : scene.loads) {
      EXPECT_EQ(load.link, 39);
      EXPECT_EQ(load.point, (Vec2d{1.0 / 40, 0}));
      EXPECT_EQ(load.stop, std::acos(-1.0));
      EXPECT_EQ(load.force.x, -load.force.y);
      const auto* sine = std::get_if<Sine>(&load.law);
      phi += load.force.y * (sine ? std::sin(2 * load.stop * sine->frequency * t + sine->phase) : 1);
    }
    EXPECT_NEAR(phi, 1.5 * std::sin(t) * std::sin(t), 1e-15);
  }
}

}  // namespace
}  // namespace planar_chain
