/// What a URDF means as a chain: against the same robot in space, every link on its own, and against scenes
/// said by hand.

#include "planar_chain/urdf_reader.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <sstream>

#include "planar_chain/kane.h"
#include "planar_chain/scene_reader.h"
#include "support/random_robot.h"

namespace planar_chain {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Scene sceneOf(const std::string& urdf, const std::string& yaml = "") {
  Value scene = yaml.empty() ? Value(Value::Map()) : parseYaml(yaml);
  scene.map()->emplace("robot_description", urdf);
  return readScene(scene);
}

// ---- In space --------------------------------------------------------------------------------

/// The robot at rest, by every link's own Jacobian: M(q), and the joint torques of gravity.
struct InSpace {
  MatrixXd M;
  VectorXd weight;
};

/// `plane`: the axes along which a planar or floating joint moves first.
InSpace inSpace(const std::vector<test::Part>& parts, const VectorXd& q, const Matrix3d& plane) {
  struct Axis {
    Vector3d at, along;
    bool isPrismatic = false;
  };
  struct Place {
    Vector3d at;
    Matrix3d turn;
    std::vector<Axis> axes;  // of the joints that move it
  };
  std::vector<Place> places;
  InSpace sum{MatrixXd::Zero(q.size(), q.size()), VectorXd::Zero(q.size())};
  Eigen::Index joints = 0;
  for (const test::Part& part : parts) {
    Place place = part.parent < 0 ? Place{Vector3d::Zero(), Matrix3d::Identity(), {}}
                                  : places[static_cast<std::size_t>(part.parent)];
    place.at += place.turn * part.xyz;
    place.turn *= test::turnOf(part.rpy);
    for (int i = 0; part.isFree() && i < 2; ++i) {
      place.axes.push_back({place.at, plane.col(i), true});
      place.at += q[joints++] * plane.col(i);
    }
    if (part.isPrismatic()) {
      place.axes.push_back({place.at, place.turn * part.axis, true});
      place.at += q[joints++] * place.turn * part.axis;
    } else if (part.moves()) {
      place.axes.push_back({place.at, place.turn * part.axis});
      place.turn *= Eigen::AngleAxisd(q[joints++], part.axis).toRotationMatrix();
    }
    const Vector3d com = place.at + place.turn * part.com;
    const Matrix3d axes = place.turn * test::turnOf(part.inertialRpy);
    const Matrix3d inertia = axes * part.inertia * axes.transpose();
    MatrixXd v = MatrixXd::Zero(3, q.size()), w = v;
    for (std::size_t i = 0; i < place.axes.size(); ++i) {
      const auto column = static_cast<Eigen::Index>(i);
      const auto& [at, along, isPrismatic] = place.axes[i];
      v.col(column) = isPrismatic ? along : along.cross(com - at);
      if (!isPrismatic) w.col(column) = along;
    }
    sum.M += part.mass * v.transpose() * v + w.transpose() * inertia * w;
    sum.weight += v.transpose() * Vector3d(0, 0, -9.81 * part.mass);
    places.push_back(place);
  }
  return sum;
}

/// The axes of the plane of motion, by urdf_reader.h.
Matrix3d planeOf(const std::vector<test::Part>& parts) {
  Matrix3d turn = Matrix3d::Identity(), plane = turn;
  for (const test::Part& part : parts) {  // each hangs on the one before
    turn *= test::turnOf(part.rpy);
    if (part.moves() && !part.isPrismatic()) plane.col(2) = turn * part.axis;
  }
  plane.col(1) = (Vector3d::UnitZ() - plane(2, 2) * plane.col(2)).normalized();
  plane.col(0) = plane.col(1).cross(plane.col(2));
  return plane;
}

struct Shape {
  int links;
  std::vector<std::string> front{};  ///< the types of the first joints
};

class Robots : public testing::TestWithParam<Shape> {};

TEST_P(Robots, InThePlaneAreWhatTheyAreInSpace) {
  const auto& [links, front] = GetParam();
  const bool isFree = !front.empty() && (front[0] == "planar" || front[0] == "floating");
  const int n = isFree ? links + 2 : links;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const std::vector<test::Part> parts = test::randomRobot(links, seed, front);
    const Scene scene = sceneOf(test::urdfOf(parts));
    ASSERT_EQ(scene.chain.size(), n);
    test::Random random(seed + 1000);
    VectorXd q(n), qd = VectorXd::Zero(n);
    for (int i = 0; i < n; ++i) q[i] = random.between(-3, 3);
    const ActiveForces active = activeForces(scene, 0, q, qd);
    const Kane kane = planar_chain::kane(scene.chain, q, qd, active);
    const InSpace space = inSpace(parts, q, planeOf(parts));
    EXPECT_LT((kane.M_q - space.M).norm(), 1e-13 * space.M.norm()) << "seed " << seed;
    EXPECT_LT((kane.f - space.weight).norm(), 1e-13 * (9.81 * n * space.M.norm())) << "seed " << seed;
    int joint = isFree ? 2 : 0;
    for (const test::Part& part : parts) {
      if (!part.moves()) continue;
      const auto at = static_cast<std::size_t>(joint++);
      EXPECT_EQ(scene.chain.links()[at].name, part.name);
      EXPECT_EQ(scene.chain.joints()[at].name, part.name + "_joint");
      EXPECT_EQ(scene.chain.joints()[at].damping, part.damping);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Links, Robots,
                         testing::Values(Shape{1}, Shape{2}, Shape{3}, Shape{7}, Shape{3, {"prismatic"}},
                                         Shape{4, {"prismatic", "prismatic"}}, Shape{1, {"planar"}},
                                         Shape{3, {"floating"}}, Shape{4, {"continuous", "prismatic"}},
                                         Shape{5, {"prismatic", "continuous", "prismatic", "prismatic"}},
                                         Shape{3, {"planar", "prismatic"}}));

// ---- By hand ---------------------------------------------------------------------------------

/// Two rods; `first` and `second` are what stands in their joints.
std::string twoRods(const std::string& first, const std::string& second,
                    const std::string& type = "continuous") {
  const std::string body =
      "<inertial><origin xyz='0 0 -0.5'/><mass value='2'/>"
      "<inertia ixx='0.3' ixy='0' ixz='0' iyy='0.25' iyz='0' izz='0.1'/></inertial></link>";
  return "<robot name='two'><link name='ground'/><link name='upper'>" + body + "<link name='lower'>" + body +
         "<joint name='shoulder' type='" + type + "'><parent link='ground'/><child link='upper'/>" + first +
         "</joint><joint name='elbow' type='" + type + "'><parent link='upper'/><child link='lower'/>" +
         "<origin xyz='0 0.2 -1'/>" + second + "</joint></robot>";
}

TEST(Plane, StandsUprightWhereTheAxisIsLevel) {
  const std::string y = "<axis xyz='0 1 0'/>";
  const Chain chain = sceneOf(twoRods(y, y)).chain;
  EXPECT_EQ(chain.gravity(), (Vec2d{0, -9.81}));
  EXPECT_EQ(chain.links()[0].com, (Vec2d{0, -0.5}));
  EXPECT_EQ(chain.links()[0].pin, (Vec2d{0, -1}));
  EXPECT_EQ(chain.links()[0].inertia, 0.25);
  EXPECT_EQ(chain.links()[1].pin, (Vec2d{0, 0}));
}

TEST(Plane, LiesWhereTheAxisIsUpright) {
  // Axes along root's z: the plane is level and has root's x. The rods are turned into it.
  const std::string z = "<axis xyz='1 0 0'/>";
  const Chain chain = sceneOf(twoRods("<origin rpy='0 -1.5707963267948966 0'/>" + z, z)).chain;
  EXPECT_EQ(chain.gravity(), (Vec2d{0, 0}));
  EXPECT_NEAR(chain.links()[0].pin.x, 1, 1e-15);
  EXPECT_NEAR(chain.links()[0].pin.y, 0.2, 1e-15);
  EXPECT_NEAR(chain.links()[0].inertia, 0.3, 1e-15);
}

TEST(Plane, InclinedFeelsThePartOfGravityInIt) {
  const std::string inclined = "<axis xyz='0 0.8 0.6'/>";
  EXPECT_NEAR(sceneOf(twoRods(inclined, inclined)).chain.gravity().y, -9.81 * 0.8, 1e-14);
}

TEST(Plane, TakesRightAnglesOfFiveDigits) {
  // The second axis is 4e-6 rad off the first: turned by 1.5708, and back.
  const auto robot = [](const std::string& roll) {
    std::string text = twoRods("<origin rpy='" + roll + " 0 0'/><axis xyz='0 0 1'/>", "<axis xyz='0 -1 0'/>");
    const std::string place = "xyz='0 0.2 -1'";
    return text.insert(text.find(place), "rpy='-" + roll + " 0 0' ");
  };
  EXPECT_NEAR(sceneOf(robot("1.5708")).chain.gravity().y, -9.81, 1e-9);
  EXPECT_THROW(sceneOf(robot("1.57")), Refused);
}

TEST(Scene, SaysWhatUrdfHasNoWordFor) {
  const std::string y = "<axis xyz='0 1 0'/><limit lower='-1' upper='2' effort='0' velocity='0'/>";
  const Scene scene = sceneOf(twoRods(y, y, "revolute"),
                              "gravity: [1, -2]\n"
                              "links:\n"
                              "  upper: {joint: {stop_stiffness: 100.0}}\n"
                              "  lower: {joint: {stop_stiffness: 50.0, stop_damping: 2.0, stiffness: 3.0,"
                              " rest_angle: 0.1}, initial: {angle: 0.5, velocity: 4.0}}\n"
                              "loads: {push: {joint: elbow, torque: 1.0}}\n"
                              "integrator: {method: rk4}\n");
  EXPECT_EQ(scene.chain.gravity(), (Vec2d{1, -2}));
  const Joint& elbow = scene.chain.joints()[1];
  EXPECT_EQ(elbow.lower, -1);
  EXPECT_EQ(elbow.upper, 2);
  EXPECT_EQ(elbow.stopStiffness, 50);
  EXPECT_EQ(elbow.stopDamping, 2);
  EXPECT_EQ(elbow.stiffness, 3);
  EXPECT_EQ(elbow.restAngle, 0.1);
  EXPECT_EQ(scene.q, (std::vector<double>{0, 0.5}));
  EXPECT_EQ(scene.qd, (std::vector<double>{0, 4}));
  ASSERT_EQ(scene.loads.size(), 1U);
  EXPECT_EQ(scene.loads[0].joint, 1);
  EXPECT_EQ(scene.integrator.method, "rk4");
}

TEST(Joints, HaveTheFrictionAndTheLimitsOfTheUrdf) {
  const std::string y = "<axis xyz='0 1 0'/><dynamics friction='0.3'/>";
  const Scene scene =
      sceneOf(twoRods(y + "<limit effort='5' velocity='2'/>", y + "<limit effort='0' velocity='-1'/>"),
              "links: {lower: {joint: {friction: 0.4, breakaway: 0.5, effort_limit: 7.0}}}");
  const Joint &shoulder = scene.chain.joints()[0], &elbow = scene.chain.joints()[1];
  EXPECT_EQ(shoulder.other("friction"), 0.3);
  EXPECT_EQ(shoulder.other("effort_limit"), 5);
  EXPECT_EQ(shoulder.other("velocity_limit"), 2);
  EXPECT_EQ(elbow.other("friction"), 0.4);  // the scene's, in place of the URDF's
  EXPECT_EQ(elbow.other("breakaway"), 0.5);
  EXPECT_EQ(elbow.other("effort_limit"), 7);
  EXPECT_FALSE(elbow.has("velocity_limit"));
}

TEST(Links, MayBeFixedToAWorldThatIsNotListed) {
  std::string robot = twoRods("<axis xyz='0 1 0'/>", "<axis xyz='0 1 0'/>");
  const Chain without = sceneOf(robot).chain;
  robot.insert(robot.find("</robot>"),
               "<joint name='weld' type='fixed'><parent link='world'/><child link='ground'/></joint>");
  EXPECT_EQ(sceneOf(robot).chain.links()[1].com, without.links()[1].com);
  EXPECT_THROW(sceneOf(robot.replace(robot.find("'fixed'"), 7, "'continuous'")), Refused);
}

TEST(Links, OnTheGroundAndWithoutMassDoNotCount) {
  std::string robot = twoRods("<axis xyz='0 1 0'/>", "<axis xyz='0 1 0'/>");
  const Chain without = sceneOf(robot).chain;
  robot.insert(
      robot.find("</robot>"),
      "<link name='tool'/><joint name='t' type='fixed'><parent link='lower'/><child link='tool'/>"
      "<origin xyz='0.3 2 -0.9'/></joint>"
      "<link name='table'><inertial><mass value='9'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' "
      "izz='1'/></inertial></link><joint name='u' type='fixed'><parent link='ground'/>"
      "<child link='table'/></joint><gazebo/><transmission name='any'/>");
  const Chain with = sceneOf(robot).chain;
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(with.links()[i].mass, without.links()[i].mass);
    EXPECT_EQ(with.links()[i].inertia, without.links()[i].inertia);
    EXPECT_EQ(with.links()[i].com, without.links()[i].com);
  }
  EXPECT_EQ(with.links()[0].pin, without.links()[0].pin);
  EXPECT_EQ(with.links()[1].pin, (Vec2d{-0.3, -0.9}));  // the tool's
}

// ---- Carts -----------------------------------------------------------------------------------

const std::string cartPole =
    "<robot name='cart_pole'><link name='cart'/><link name='pole'><inertial><origin xyz='0 0 0.5'/>"
    "<mass value='0.1'/><inertia ixx='0.01' ixy='0' ixz='0' iyy='0.01' iyz='0' "
    "izz='0.001'/></inertial></link>"
    "<joint name='slider' type='prismatic'><parent link='world'/><child link='cart'/><origin xyz='0 0 2'/>"
    "<axis xyz='1 0 0'/><limit lower='-3' upper='4' effort='20' velocity='5'/>"
    "<dynamics damping='0.1' friction='0.2'/></joint><joint name='hinge' type='continuous'>"
    "<parent link='cart'/><child link='pole'/><origin xyz='0 0.1 0.25'/><axis xyz='0 -1 0'/></joint></robot>";

TEST(Carts, HaveTheAxisOfAPrismaticJoint) {
  const Scene scene =
      sceneOf(cartPole, "links: {cart: {joint: {stiffness: 3}, initial: {position: 0.3, velocity: 1}}}");
  EXPECT_EQ(scene.chain.coordinates().leading(), 1);
  const Joint& slider = scene.chain.joints()[0];
  EXPECT_EQ(slider.axis, (Vec2d{1, 0}));  // the hinge turns about −y: x to the right, y upwards
  EXPECT_EQ(slider.lower, -3);
  EXPECT_EQ(slider.upper, 4);
  EXPECT_EQ(slider.damping, 0.1);
  EXPECT_EQ(slider.stiffness, 3);
  EXPECT_EQ(slider.other("friction"), 0.2);
  EXPECT_EQ(slider.other("effort_limit"), 20);
  EXPECT_EQ(scene.chain.links()[0].mass, 0);
  EXPECT_EQ(scene.chain.links()[0].pin, (Vec2d{0, 0.25}));
  EXPECT_EQ(scene.chain.links()[1].com, (Vec2d{0, 0.5}));
  EXPECT_EQ(scene.q[0], 0.3);
  EXPECT_EQ(scene.qd[0], 1);
}

TEST(Carts, MayBeFree) {
  std::string robot = cartPole;
  const std::string joint = robot.substr(robot.find("<joint name='slider'"));
  robot.replace(robot.find(joint), joint.find("</joint>"),
                "<joint name='slider' type='floating'><parent link='world'/><child link='cart'/>");
  EXPECT_THROW(sceneOf(robot), Refused) << "the cart has no mass of its own, and turns";
  const std::string body =
      "<link name='cart'><inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' "
      "iyz='0' izz='1'/></inertial></link>";
  robot.replace(robot.find("<link name='cart'/>"), 19, body);
  const Scene scene = sceneOf(robot, "links: {cart: {initial: {position: [1, 2], angle: 0.5}}}");
  ASSERT_EQ(scene.chain.size(), 4);
  EXPECT_EQ(scene.chain.joints()[0].name, "slider_x");
  EXPECT_EQ(scene.chain.joints()[2].name, "slider");
  EXPECT_EQ(scene.q, (std::vector<double>{1, 2, 0.5, 0}));
}

// ---- Notes -----------------------------------------------------------------------------------

std::string notesOf(const Scene& scene) {
  std::string lines;
  for (const Note& note : scene.notes) lines += toString(note) + "\n";
  return lines;
}

TEST(Notes, NameWhatIsIgnoredOnceForAllJoints) {
  // As files for Drake and for gazebo have them.
  const std::string y = "<axis xyz='0 1 0'/><joint_properties/><limit effort='0'/>";
  EXPECT_EQ(notesOf(sceneOf(twoRods(y, y, "revolute"))),
            "robot_description/joint[shoulder]/joint_properties: ignored, as <joint> of URDF has no element "
            "joint_properties (and 1 more)\n"
            "robot_description/joint[shoulder]/limit/effort: effort 0 is read as no limit (and 1 more)\n"
            "robot_description/joint[shoulder]: a revolute joint without lower and upper: turns freely, as a "
            "continuous one (and 1 more)\n"
            "robot_description/link[ground]: held in place as the ground, as no joint fixes it to a link "
            "world\n");
}

TEST(Limits, OfTheSceneReplaceThoseThatExportersWriteByDefault) {
  const std::string y = "<axis xyz='0 1 0'/><limit lower='0' upper='0'/>";
  const std::string robot = twoRods(y, y, "revolute");
  EXPECT_THROW(sceneOf(robot), Refused);
  EXPECT_THROW(sceneOf(robot, "links: {upper: {joint: {limits: none}}}"), Refused);
  const Scene scene =
      sceneOf(robot, "links: {upper: {joint: {limits: none}}, lower: {joint: {lower: -1.0, upper: 2.0}}}");
  EXPECT_FALSE(scene.chain.joints()[0].isLimited());
  EXPECT_EQ(scene.chain.joints()[1].lower, -1);
  EXPECT_EQ(scene.chain.joints()[1].upper, 2);
}

TEST(Links, MayTurnOnAWorldThatIsNotListed) {
  std::string robot = twoRods("<axis xyz='0 1 0'/>", "<axis xyz='0 1 0'/>");
  robot.replace(robot.find("<link name='ground'/>"), 21, "");
  robot.replace(robot.find("parent link='ground'"), 20, "parent link='world'");
  const Scene scene = sceneOf(robot);
  EXPECT_EQ(scene.chain.size(), 2);
  EXPECT_EQ(notesOf(scene), "");
}

}  // namespace
}  // namespace planar_chain
