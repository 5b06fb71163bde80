/// The URDF of a scene, read again, is the same chain: for every scene that ships, but for what URDF has no
/// word for.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "planar_chain/scene_reader.h"
#include "planar_chain/urdf_reader.h"
#include "ros/messages/frames.h"
#include "ros/view/drawing.h"
#include "ros/view/extent.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

void expectNear(double a, double b, double size, const std::string& what) {
  EXPECT_NEAR(a, b, 1e-15 * size) << what;
}

void expectTheSameAgain(const Scene& scene) {
  const PlanarRobot again = readUrdf(urdfOf(scene, framesOf(scene, "/")));
  ASSERT_EQ(again.links.size(), scene.chain.links().size());
  EXPECT_EQ(again.gravity, (Vec2d{0, -9.81}));
  for (std::size_t i = 0; i < again.links.size(); ++i) {
    const Link& link = scene.chain.links()[i];
    EXPECT_EQ(again.links[i].name, link.name);
    EXPECT_EQ(again.links[i].mass, link.mass);
    const double com = length(link.com), pin = length(link.pin);
    expectNear(again.links[i].inertia, link.inertia, link.inertia, link.name);
    expectNear(again.links[i].com.x, link.com.x, com, link.name);
    expectNear(again.links[i].com.y, link.com.y, com, link.name);
    expectNear(again.links[i].pin.x, link.pin.x, pin, link.name);
    expectNear(again.links[i].pin.y, link.pin.y, pin, link.name);

    const Joint& joint = scene.chain.joints()[i];
    EXPECT_EQ(again.joints[i].name, joint.name);
    EXPECT_EQ(again.joints[i].damping, joint.damping);
    EXPECT_EQ(again.joints[i].isPrismatic, joint.isPrismatic);
    if (joint.isPrismatic) {
      expectNear(again.joints[i].axis.x, joint.axis.x, 1, joint.name);
      expectNear(again.joints[i].axis.y, joint.axis.y, 1, joint.name);
    }
    EXPECT_EQ(again.joints[i].lower, joint.lower);
    EXPECT_EQ(again.joints[i].upper, joint.upper);
  }
}

TEST(Urdf, OfEverySceneThatShipsIsTheSameChainAgain) {
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(SCENES_DIR)) {
    SCOPED_TRACE(file.path().filename());
    std::ifstream in(file.path());
    const Scene scene = readSceneText({std::istreambuf_iterator<char>(in), {}});
    expectTheSameAgain(scene);
    ++count;
  }
  EXPECT_GE(count, 10);
}

TEST(Urdf, OfRandomScenesIsTheSameChainAgain) {
  for (unsigned seed = 1; seed <= 20; ++seed) expectTheSameAgain(test::randomScene(5, seed));
}

TEST(Urdf, HasTheFramesOfTheScene) {
  const auto urdf = [](const std::string& last, const std::string& frames) {
    const std::string rod = ": {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]}";
    const Scene scene =
        readSceneText("chain: [a, " + last + "]\nlinks: {a" + rod + ", " + last + rod + "}\n" + frames);
    return urdfOf(scene, framesOf(scene, "/"));
  };
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  const std::string framed = urdf("b", "frames: {gripper: {link: a, point: [0.25, 0.5], angle: 0.5}}");
  const std::string gripper =
      "<parent link=\"a\"/><child link=\"gripper\"/><origin xyz=\"0.25 0.5 0\" rpy=\"0 0 0.5\"/>";
  const std::string tip = "<parent link=\"b\"/><child link=\"tip\"/><origin xyz=\"1 0 0\"";
  EXPECT_TRUE(has(framed, "<link name=\"gripper\"/>"));
  EXPECT_TRUE(has(framed, gripper));
  EXPECT_TRUE(has(framed, tip));
  const std::string named = urdf("tip", ""), own = "<link name=\"tip\"";
  EXPECT_EQ(named.find(own), named.rfind(own)) << "a link has that name";
}

/// With limits, and with a boom that is bent.
constexpr const char* telescope =
    "chain: [boom, tube, tool]\nlinks:\n"
    "  boom: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [0.6, 0.2]}\n"
    "  tube: {mass: 1, inertia: 0.1, com: [0.2, 0], pin: [0.4, 0], joint: {type: prismatic, axis: [3, -4],"
    " lower: -0.1, upper: 1, damping: 2, effort_limit: 3}}\n"
    "  tool: {mass: 1, inertia: 0.1, com: [0.2, 0], pin: [0.5, 0]}\n";

TEST(Urdf, OfAPrismaticJointWithinTheChainIsTheSameChainAgain) {
  const Scene scene = readSceneText(telescope);
  expectTheSameAgain(scene);
  EXPECT_EQ(readUrdf(urdfOf(scene, framesOf(scene, "/"))).joints[1].other("effort_limit"), 3);
}

/// Two rails on the boom, from limit to limit, and a block of the tube between them.
TEST(Urdf, ShowsWhatSlidesOnWhat) {
  const Scene scene = readSceneText(telescope);
  const std::string urdf = urdfOf(scene, framesOf(scene, "/"));
  const Drawing drawing(scene);
  const auto link = [&](const std::string& name) {
    const std::size_t at = urdf.find("<link name=\"" + name + "\">");
    return urdf.substr(at, urdf.find("</link>", at) - at);
  };
  const std::string rail = "<box size=\"" + toText(1.1 + blockLength * drawing.bar);
  const std::string boom = link("boom"), block = "<box size=\"" + toText(blockLength * drawing.bar) + " ";
  const std::size_t first = boom.find(rail);
  EXPECT_NE(first, std::string::npos) << boom;
  EXPECT_NE(boom.find(rail, first + 1), std::string::npos);
  EXPECT_NE(link("tube").find(block), std::string::npos);
  EXPECT_EQ(link("tool").find(block), std::string::npos);
  EXPECT_EQ(halfBlock(scene.chain, 1), blockLength / 2);
}

/// A bearing has eight parts, as the one of the base; a line is a rail.
TEST(Urdf, ShowsWhatHoldsTheTip) {
  const std::string chain =
      "chain: [a, b]\nlinks: {a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]},"
      " b: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], initial: {angle: 1}}}\n";
  const auto parts = [&](const std::string& more, const std::string& part) {
    const Scene scene = readSceneText(chain + more);
    const std::string urdf = urdfOf(scene, framesOf(scene, "/"));
    int count = 0;
    for (std::size_t at = 0; (at = urdf.find(part, at)) != std::string::npos; ++at) ++count;
    return count;
  };
  const std::string ground = "<material name=\"ground\"/>", pin = "<material name=\"pin\"/>";
  const std::string bar = "<origin xyz=\"1.5 " + toText(1.7 * 0.09) + " 0\"";
  EXPECT_EQ(parts("", ground), 8);
  EXPECT_EQ(parts("", pin), 2);
  EXPECT_EQ(parts("tip: {pin: [1.5, 0]}", ground), 16);
  EXPECT_EQ(parts("tip: {pin: [1.5, 0]}", pin), 3);
  EXPECT_EQ(parts("tip: {pin: [1.5, 0]}", bar), 1);
  EXPECT_EQ(parts("tip: {pin: [1.5, 0]}\nbase: {x: {amplitude: 0.1, frequency: 1}}", ground), 16);
  EXPECT_EQ(parts("tip: {pin: {x: {offset: 1.5}, y: {amplitude: 0.1, frequency: 1}}}", ground), 8);
  EXPECT_EQ(parts("tip: {line: {point: [0, 0.5]}}", ground), 9);
  EXPECT_EQ(parts("tip: {line: {point: [0, 0.5]}}", "<origin xyz=\"0 0.5 0\" rpy=\"0 0 0\""), 1);
}

/// Symbols leave room for the shortest link; a pinned tip halves what is in view, and arrows end in it.
TEST(Urdf, IsDrawnToTheSizeOfShortLinksAndClosedChains) {
  const auto of = [](const std::string& more) {
    return readSceneText(
        "chain: [a, b]\nlinks: {a: {mass: 1, inertia: 0.1, com: [0.2, 0], pin: [0.4, 0]},"
        " b: {mass: 1, inertia: 0.1, com: [0.8, 0], pin: [1.6, 0], initial: {angle: 1}}}\n" +
        more);
  };
  const Drawing open(of("")), closed(of("tip: {pin: [1.5, 0]}"));
  EXPECT_DOUBLE_EQ(open.bar, 0.09 * 0.4);
  EXPECT_DOUBLE_EQ(open.span, 2);
  EXPECT_DOUBLE_EQ(closed.span, 1);
  EXPECT_DOUBLE_EQ(closed.middle.x, 0.75);
  EXPECT_DOUBLE_EQ(open.push(-open.force / 4), 2.5 / 4 / 2);
  EXPECT_DOUBLE_EQ(open.push(4 * open.force), 2.5 / 4);
  const Vec2d start{1.5, 0};
  EXPECT_DOUBLE_EQ((start + closed.arrow({1e6, 0}, start)).x, 0.75 + 1.2);
  EXPECT_DOUBLE_EQ(Extent(of("tip: {pin: [1.5, 0]}")).half, 1.25);
  EXPECT_DOUBLE_EQ(Extent(of("tip: {line: {point: [0, 0.5]}}")).half, 2.5);
}

/// A crank with the inertia of a flywheel: a rod of this inertia would be up to 9 m long.
TEST(Urdf, DrawsNoLinkBeyondBothPins) {
  const Scene scene = readSceneText(
      "chain: [crank, rod]\nlinks: {crank: {mass: 1, inertia: 0.01, com: [0, 0], pin: [0.15, 0]},"
      " rod: {mass: 1, inertia: 0.01, com: [0.3, 0], pin: [0.6, 0]}}\n");
  const Drawing drawing(scene);
  Link crank = scene.chain.links()[0];
  for (const double inertia : {1e-4, 1e-3, 0.01, 0.1, 7.0}) {
    for (const double com : {-0.2, -0.05, 0.0, 0.03, 0.075, 0.1, 0.15, 0.3}) {
      crank.inertia = inertia;
      crank.com.x = com;
      double low = 0, high = 0;
      for (const Bar& bar : figureOf(crank, drawing).bars) {
        low = std::min({low, bar.from.x, bar.to.x});
        high = std::max({high, bar.from.x, bar.to.x});
      }
      EXPECT_TRUE(low > -1e-12 || high < crank.pin.x + 1e-12) << inertia << " " << com;
      EXPECT_TRUE(com != 0.075 || (low > -1e-12 && high < crank.pin.x + 1e-12)) << inertia;
    }
  }
}

/// All positions of a cart and of a base, and the reach around them.
TEST(Urdf, IsWholeInTheFirstView) {
  const auto viewOf = [](const std::string& joint, const std::string& more) {
    return Extent(readSceneText("chain: [cart, rod]\nlinks: {cart: {mass: 1, pin: [0, 0], joint: {" + joint +
                                "}}, rod: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]}}\n" + more));
  };
  const std::string slides = "type: prismatic, axis: [1, 0], ", along = "lower: -1, upper: 7";
  EXPECT_DOUBLE_EQ(viewOf(slides + along, "").centre.x, 3);
  EXPECT_DOUBLE_EQ(viewOf(slides + along, "").half, 5.25 / 1.27);
  EXPECT_DOUBLE_EQ(viewOf("type: prismatic, axis: [0, 1], " + along, "").half, 5.25);
  // Without a limit within ten times the reach, a rail is drawn along twice the reach.
  EXPECT_DOUBLE_EQ(viewOf(slides + "lower: -1, upper: 11", "").centre.x, 0.5);
  EXPECT_DOUBLE_EQ(viewOf(slides + "drive: {amplitude: 5, frequency: 1}", "").half, 8.25 / 1.27);
  const std::string base =
      "base: {x: {offset: 2, amplitude: 1, frequency: 1}, angle: {times: [0, 1], values: [0, 1]}}";
  EXPECT_DOUBLE_EQ(viewOf(slides + along, base).centre.x, 2);
  EXPECT_DOUBLE_EQ(viewOf(slides + along, base).half, 8.25);
  // A prismatic joint on a link counts up to its limits; without them, to a quarter of the chain's length.
  const Extent arm(readSceneText(telescope));
  EXPECT_DOUBLE_EQ(arm.links, std::hypot(0.6, 0.2) + 0.4 + 0.5);
  EXPECT_DOUBLE_EQ(arm.reach, arm.links + 1);
  EXPECT_DOUBLE_EQ(arm.half, 1.25 * arm.reach);
  std::string free = telescope;
  free.replace(free.find("lower: -0.1, upper: 1, "), 23, "");
  EXPECT_DOUBLE_EQ(Extent(readSceneText(free)).reach, 1.25 * arm.links);
  const Scene crane = readSceneText(
      "chain: [rod]\nlinks: {rod: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0]}}\n"
      "base: {x: {times: [0, 1], values: [0, 6]}}");
  EXPECT_DOUBLE_EQ(Extent(crane).centre.x, 3);
  EXPECT_DOUBLE_EQ(Extent(crane).half, 4.25 / 1.27);
}

}  // namespace
}  // namespace planar_chain
