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
#include "random_scene.h"
#include "ros/messages/frames.h"
#include "ros/view/drawing.h"

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
    const Vec2d last = i + 1 < again.links.size() ? link.pin : Vec2d{};  // of the tip URDF knows nothing
    expectNear(again.links[i].pin.x, last.x, pin, link.name);
    expectNear(again.links[i].pin.y, last.y, pin, link.name);

    const Joint& joint = scene.chain.joints()[i];
    EXPECT_EQ(again.joints[i].name, joint.name);
    EXPECT_EQ(again.joints[i].damping, joint.damping);
    EXPECT_EQ(again.joints[i].slides, joint.slides);
    if (joint.slides) expectNear(again.joints[i].axis.x, joint.axis.x, 1, joint.name);
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

}  // namespace
}  // namespace planar_chain
