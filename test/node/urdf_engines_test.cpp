/// The URDF that the node writes, and random ones, read by other engines: their accelerations are ours. Each
/// engine that was found when this was built gets the text as it is and gravity, and is asked for q̈ at random
/// states; springs and loads, for which URDF has no word, are left out.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#ifdef WITH_DART
#include <dart/dynamics/Joint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/utils/urdf/DartLoader.hpp>
#endif
#ifdef WITH_KDL
#include <kdl/chain.hpp>
#include <kdl/chaindynparam.hpp>
#include <kdl_parser/kdl_parser.hpp>
#endif
#ifdef WITH_MUJOCO
#include <mujoco/mujoco.h>
#endif

#include "planar_chain/kane.h"
#include "planar_chain/scene_reader.h"
#include "ros/messages/frames.h"
#include "ros/view/drawing.h"
#include "support/random_robot.h"

namespace planar_chain {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Accelerations = std::function<VectorXd(const VectorXd& q, const VectorXd& qd)>;

// ---- Engines ---------------------------------------------------------------------------------

struct Engine {
  const char* name;
  /// @param gravity m/s², in the root link's axes
  Accelerations (*load)(const std::string& urdf, const Vector3d& gravity, const Chain& chain);
  double tolerance = 1e-9;  ///< where inertia tensors are full
  bool takesPoints = true;  ///< masses without a moment of inertia
};

#ifdef WITH_DART
Accelerations dartLoads(const std::string& urdf, const Vector3d& gravity, const Chain&) {
  dart::utils::DartLoader::Options options;
  options.mDefaultRootJointType = dart::utils::DartLoader::RootJointType::FIXED;
  dart::utils::DartLoader loader(options);
  const dart::dynamics::SkeletonPtr skeleton = loader.parseSkeletonString(urdf, dart::common::Uri());
  if (!skeleton) throw std::runtime_error("DART refuses it");
  skeleton->setGravity(gravity);
  skeleton->setTimeStep(1e-300);  // its accelerations are means over a step where there is damping
  return [skeleton](const VectorXd& q, const VectorXd& qd) -> VectorXd {
    skeleton->setPositions(q);
    skeleton->setVelocities(qd);
    skeleton->computeForwardDynamics();
    return skeleton->getAccelerations();
  };
}
#endif

#ifdef WITH_KDL
/// It does not take damping from URDF: that comes as torques.
Accelerations kdlLoads(const std::string& urdf, const Vector3d& gravity, const Chain& chain) {
  KDL::Tree tree;
  const auto segments = std::make_shared<KDL::Chain>();
  if (!kdl_parser::treeFromString(urdf, tree)) throw std::runtime_error("KDL refuses it");
  // The tip: the one segment without children.
  for (const auto& [name, element] : tree.getSegments()) {
    if (element.children.empty()) tree.getChain(tree.getRootSegment()->first, name, *segments);
  }
  const auto terms =
      std::make_shared<KDL::ChainDynParam>(*segments, KDL::Vector(gravity[0], gravity[1], gravity[2]));
  VectorXd damping(chain.size());
  for (int i = 0; i < chain.size(); ++i) damping[i] = chain.joints()[static_cast<std::size_t>(i)].damping;
  return [=](const VectorXd& q, const VectorXd& qd) -> VectorXd {
    const unsigned n = segments->getNrOfJoints();
    KDL::JntArray position(n), rate(n), coriolis(n), weight(n);
    KDL::JntSpaceInertiaMatrix M(n);
    position.data = q;
    rate.data = qd;
    if (terms->JntToMass(position, M) < 0 || terms->JntToCoriolis(position, rate, coriolis) < 0 ||
        terms->JntToGravity(position, weight) < 0)
      throw std::runtime_error("KDL fails");
    return M.data.ldlt().solve(-damping.cwiseProduct(qd) - coriolis.data - weight.data);
  };
}
#endif

#ifdef WITH_MUJOCO
Accelerations mujocoLoads(const std::string& urdf, const Vector3d& gravity, const Chain&) {
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "robot.urdf", static_cast<int>(urdf.size()));
  std::copy(urdf.begin(), urdf.end(), static_cast<char*>(files->filedata[0]));
  char error[500] = "";
  const std::shared_ptr<mjModel> model(mj_loadXML("robot.urdf", files.get(), error, sizeof error),
                                       mj_deleteModel);
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(error);
  std::copy_n(gravity.data(), 3, model->opt.gravity);
  const std::shared_ptr<mjData> data(mj_makeData(model.get()), mj_deleteData);
  return [=](const VectorXd& q, const VectorXd& qd) -> VectorXd {
    if (model->nv != q.size()) throw std::runtime_error("MuJoCo has other joints");
    std::copy_n(q.data(), q.size(), data->qpos);
    std::copy_n(qd.data(), q.size(), data->qvel);
    mj_forward(model.get(), data.get());
    return VectorXd::Map(data->qacc, q.size());
  };
}
#endif

const Engine engines[] = {
#ifdef WITH_DART
    {"DART", dartLoads},
#endif
#ifdef WITH_KDL
    {"KDL", kdlLoads},
#endif
#ifdef WITH_MUJOCO
    // It turns tensors to their principal axes by rotations, and leaves out those below 1e-6 rad.
    {"MuJoCo", mujocoLoads, 1e-4, false},
#endif
};

// ---- Equal accelerations ---------------------------------------------------------------------

void compare(const Accelerations& theirs, const Scene& scene, double tolerance, const std::string& what) {
  const int n = scene.chain.size();
  test::Random random(static_cast<unsigned>(n));
  for (int k = 0; k < 5; ++k) {
    VectorXd q(n), qd(n);
    for (int i = 0; i < n; ++i) {
      q[i] = random.between(-3, 3);
      qd[i] = random.between(-4, 4);
    }
    const Kane ours = kane(scene.chain, q, qd, activeForces(scene, 0, q, qd));
    // What the engine's q̈ leaves over of M q̈ = f: free of the condition of M.
    const VectorXd rest = ours.M_q * theirs(q, qd) - ours.f;
    const double size = ours.f.norm() + (ours.M_q * ours.qdd).norm();
    EXPECT_LT(rest.norm(), tolerance * size) << what;
    EXPECT_LT((theirs(q, qd) - ours.qdd).norm(), tolerance * ours.qdd.norm()) << what;
  }
}

class UrdfIn : public testing::TestWithParam<Engine> {};

TEST_P(UrdfIn, WrittenByTheNode) {
  for (const int n : {1, 2, 3, 6}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const Scene scene = test::randomScene(n, seed, {false, true, false});
      const std::string urdf = urdfOf(scene, framesOf(scene, "/"));
      const Vec2d g = scene.chain.gravity();
      compare(GetParam().load(urdf, {g.x, 0, g.y}, scene.chain), scene, 1e-9,
              std::to_string(n) + " links, seed " + std::to_string(seed));
    }
  }
}

TEST_P(UrdfIn, OfCarts) {
  for (const std::string rails : {"prismatic", "prismatic, prismatic"}) {
    const bool isPlane = rails.size() > 9;
    const Scene scene = readSceneText(
        std::string("chain: [x, ") + (isPlane ? "y, " : "") +
        "a, b]\nlinks:\n  x: {mass: 2, inertia: 0.5, com: [0.1, 0.2], pin: [0, 0.1], joint: {type: "
        "prismatic, "
        "axis: [1, 0.3], damping: 0.7}}\n" +
        (isPlane ? "  y: {mass: 0.6, inertia: 0.1, pin: [0.2, 0], joint: {type: prismatic, axis: [0, 1]}}\n"
                 : "") +
        "  a: {mass: 1, inertia: 0.2, com: [0.5, 0.1], pin: [1, 0], joint: {damping: 0.2}}\n"
        "  b: {mass: 0.5, inertia: 0.1, com: [0.3, 0], pin: [0.6, 0]}\n");
    compare(GetParam().load(urdfOf(scene, framesOf(scene, "/")), {0, 0, -9.81}, scene.chain), scene, 1e-9,
            rails);
    const std::string urdf =
        test::urdfOf(test::randomRobot(4, 7,
                                       isPlane ? std::vector<std::string>{"prismatic", "prismatic"}
                                               : std::vector<std::string>{"prismatic"}));
    const Scene read = readScene(Value(Value::Map{{"robot_description", Value(urdf)}}));
    compare(GetParam().load(urdf, {0, 0, -9.81}, read.chain), read, GetParam().tolerance, rails);
  }
}

/// Written, and read: a telescope in the middle of a chain, and one at its end.
TEST_P(UrdfIn, OfPrismaticJointsWithinTheChain) {
  const Scene scene = readSceneText(
      "chain: [a, b, c, d, e]\nlinks:\n"
      "  a: {mass: 1, inertia: 0.2, com: [0.5, 0.1], pin: [1, 0.2], joint: {damping: 0.2}}\n"
      "  b: {mass: 2, inertia: 0.5, com: [0.1, 0.2], pin: [0.3, 0.1],"
      " joint: {type: prismatic, axis: [1, 0.3], damping: 0.7}}\n"
      "  c: {mass: 0.6, inertia: 0.1, pin: [0.2, 0], joint: {type: prismatic, axis: [0, -1]}}\n"
      "  d: {mass: 0.5, inertia: 0.1, com: [0.3, 0], pin: [0.6, 0]}\n"
      "  e: {mass: 0.4, inertia: 0.2, com: [0.3, 0.1], joint: {type: prismatic, axis: [2, 1], damping: "
      "0.3}}\n");
  compare(GetParam().load(urdfOf(scene, framesOf(scene, "/")), {0, 0, -9.81}, scene.chain), scene, 1e-9,
          "written");
  const std::string urdf = test::urdfOf(
      test::randomRobot(6, 7, {"continuous", "prismatic", "prismatic", "continuous", "prismatic"}));
  const Scene read = readScene(Value(Value::Map{{"robot_description", Value(urdf)}}));
  compare(GetParam().load(urdf, {0, 0, -9.81}, read.chain), read, GetParam().tolerance, "read");
}

TEST_P(UrdfIn, OfPointMasses) {
  const Scene scene = readSceneText(
      "chain: [a, b]\n"
      "links:\n"
      "  a: {mass: 1, inertia: 0, com: [1, 0], pin: [1, 0]}\n"
      "  b: {mass: 2, inertia: 0, com: [0.5, 0.5], pin: [1, 0]}\n");
  const std::string urdf = urdfOf(scene, framesOf(scene, "/"));
  if (GetParam().takesPoints) {
    compare(GetParam().load(urdf, {0, 0, -9.81}, scene.chain), scene, 1e-9, "points");
  } else {
    EXPECT_THROW(GetParam().load(urdf, {0, 0, -9.81}, scene.chain), std::runtime_error);
  }
}

TEST_P(UrdfIn, AsTheSceneThatIsReadOfIt) {
  for (const int n : {1, 2, 5}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const std::string urdf = test::urdfOf(test::randomRobot(n, seed));
      Value value{Value::Map{{"robot_description", Value(urdf)}}};
      const Scene scene = readScene(value);
      compare(GetParam().load(urdf, {0, 0, -9.81}, scene.chain), scene, GetParam().tolerance,
              std::to_string(n) + " links, seed " + std::to_string(seed));
    }
  }
}

std::string nameOf(const testing::TestParamInfo<Engine>& engine) {
  return engine.param.name;
}

INSTANTIATE_TEST_SUITE_P(Engines, UrdfIn, testing::ValuesIn(engines), nameOf);

}  // namespace
}  // namespace planar_chain
