#include "planar_chain/urdf_reader.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "planar_chain/value.h"
#include "reading/section.h"
#include "scene/urdf_document.h"

namespace planar_chain {

namespace {

using Eigen::Vector3d;

constexpr double standardGravity = 9.81;
constexpr double parallel = 1e-5;  // rad: accepts 1.5708 as a right angle, and not 1.57

// ---- The tree --------------------------------------------------------------------------------

/// The joints of each link, which lead outwards.
class Tree {
 public:
  /// @throws Refused if the document is not a tree
  explicit Tree(const UrdfDocument& document) : document_(document), joints_(document.links.size()) {
    std::vector<const UrdfJoint*> above(document.links.size());
    std::vector<Fault> faults;
    for (const UrdfJoint& joint : document.joints) {
      joints_[joint.parent].push_back(&joint);
      const UrdfJoint*& first = above[joint.child];
      if (first) {
        faults.push_back(
            {urdfPath("joint", joint.name) + "/child", "a link that is the child of no other joint",
             quoted(document.links[joint.child].name) + ", the child of " + quoted(first->name)});
      } else {
        first = &joint;
      }
    }
    requireOneRoot(above, faults);
    if (!faults.empty()) throw Refused(std::move(faults));
  }

  std::size_t root() const { return root_; }
  const UrdfLink& link(std::size_t i) const { return document_.links[i]; }
  const std::vector<const UrdfJoint*>& jointsOn(std::size_t link) const { return joints_[link]; }

 private:
  void requireOneRoot(const std::vector<const UrdfJoint*>& above, std::vector<Fault>& faults) {
    std::string roots;
    int count = 0;
    for (std::size_t i = 0; i < above.size(); ++i) {
      if (above[i]) continue;
      root_ = i;
      ++count;
      if (count <= 3) roots += (count > 1 ? ", " : "") + quoted(document_.links[i].name);
    }
    if (count > 3) roots += " and " + std::to_string(count - 3) + " more";
    if (count != 1) {
      faults.push_back({"robot_description", "one link that is the child of no joint, the ground",
                        count == 0 ? "none" : roots});
    } else if (faults.empty() && reached() < above.size()) {
      faults.push_back({"robot_description", "a tree", "links in a closed loop"});
    }
  }

  std::size_t reached() const {
    std::vector<std::size_t> reached{root_};
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (const UrdfJoint* joint : joints_[reached[i]]) reached.push_back(joint->child);
    }
    return reached.size();
  }

  const UrdfDocument& document_;
  std::vector<std::vector<const UrdfJoint*>> joints_;
  std::size_t root_ = 0;
};

// ---- Bodies ----------------------------------------------------------------------------------

Pose operator*(const Pose& a, const Pose& b) {
  return {a.turn * b.turn, a.shift + a.turn * b.shift};
}

/// A link of a body, and its pose. The shift is measured from the body's joint, in the root's axes.
struct Part {
  const UrdfLink* link;
  Pose pose;
};

/// Links that fixed joints make one body.
struct Body {
  std::vector<Part> parts;
  const UrdfJoint* next = nullptr;  ///< the next moving joint; null at the end of the chain
  Pose nextPose;
};

/// The body that begins with link `first`, whose axes are turned by `turn`.
Body bodyFrom(const Tree& tree, std::size_t first, const Eigen::Matrix3d& turn, std::vector<Fault>& faults) {
  Body body;
  std::vector<std::pair<std::size_t, Pose>> links{{first, {turn, Vector3d::Zero()}}};
  for (std::size_t i = 0; i < links.size(); ++i) {
    const auto [link, pose] = links[i];
    body.parts.push_back({&tree.link(link), pose});
    for (const UrdfJoint* joint : tree.jointsOn(link)) {
      const Pose below = pose * joint->origin;
      if (!joint->moves) {
        links.emplace_back(joint->child, below);
      } else if (!body.next) {
        body.next = joint;
        body.nextPose = below;
      } else {
        faults.push_back({urdfPath("joint", joint->name), "a chain, with one moving joint on a body",
                          "a branch beside " + quoted(body.next->name)});
      }
    }
  }
  return body;
}

// ---- The plane -------------------------------------------------------------------------------

/// The plane of motion: its axes in the root's, and the gravity in it. urdf_reader.h defines them.
struct Plane {
  Vector3d i, j, k;
  Vec2d gravity;

  explicit Plane(const Vector3d& normal) : k(normal) {
    const Vector3d up = Vector3d::UnitZ() - k.z() * k;
    if (up.norm() < parallel) {
      i = (Vector3d::UnitX() - k.x() * k).normalized();
      j = k.cross(i);
    } else {
      j = up.normalized();
      i = j.cross(k);
      gravity = {0, -standardGravity * up.norm()};
    }
  }

  Vec2d operator()(const Vector3d& a) const { return {i.dot(a), j.dot(a)}; }
};

/// The body in the plane, about its own joint.
Link linkOf(const Body& body, const Plane& plane, std::vector<Fault>& faults) {
  // Name and mass.
  Link link;
  link.name = body.parts[0].link->name;
  const std::string path = urdfPath("link", link.name);
  if (!isName(link.name)) faults.push_back({path + "/name", nameInWords, quoted(link.name)});
  for (const Part& part : body.parts) link.mass += part.link->mass;
  if (link.mass == 0) {
    faults.push_back({path + "/inertial", "a mass > 0 kg of this link or of one fixed to it", "none"});
    return link;
  }

  // The centre of mass, then the moment of inertia about it.
  for (const Part& part : body.parts) {
    const Vec2d com = plane(part.pose.shift + part.pose.turn * part.link->com);
    link.com += part.link->mass / link.mass * com;
  }
  for (const Part& part : body.parts) {
    const Vec2d off = plane(part.pose.shift + part.pose.turn * part.link->com) - link.com;
    const Vector3d axis = part.pose.turn.transpose() * plane.k;
    link.inertia += axis.dot(part.link->inertia * axis) + part.link->mass * dot(off, off);
  }

  // The outer pin.
  if (body.next) link.pin = plane(body.nextPose.shift);
  for (const Fault& fault : faultsOf(link)) {
    faults.push_back({path + "/" + fault.path, fault.expected, fault.found});
  }
  return link;
}

Joint jointOf(const UrdfJoint& from, std::vector<Fault>& faults) {
  if (!isName(from.name)) {
    faults.push_back({urdfPath("joint", from.name) + "/name", nameInWords, quoted(from.name)});
  }
  Joint joint;
  joint.name = from.name;
  joint.damping = from.damping;
  joint.lower = from.lower;
  joint.upper = from.upper;
  return joint;
}

void requireParallel(const UrdfJoint& joint, const Vector3d& axis, const Plane& plane,
                     std::vector<Fault>& faults) {
  const std::string path = urdfPath("joint", joint.name) + "/axis";
  if (plane.k.cross(axis).norm() > parallel) {
    faults.push_back({path, "an axis parallel to the first joint's, as the chain moves in a plane",
                      "an angle of " + toText(std::acos(plane.k.dot(axis))) + " rad"});
  } else if (plane.k.dot(axis) < 0) {
    faults.push_back({path, "the direction of the first joint's axis, so that all angles have one sense",
                      "the opposite direction"});
  }
}

}  // namespace

PlanarRobot readUrdf(const std::string& text) {
  const UrdfDocument document = parseUrdf(text);
  const Tree tree(document);
  std::vector<Fault> faults;
  PlanarRobot robot;

  // From the ground outwards, body by body. The first axis defines the plane.
  Body body = bodyFrom(tree, tree.root(), Eigen::Matrix3d::Identity(), faults);
  std::optional<Plane> plane;
  while (body.next) {
    const UrdfJoint& joint = *body.next;
    const Vector3d axis = body.nextPose.turn * joint.axis;
    if (!plane) plane.emplace(axis);
    requireParallel(joint, axis, *plane, faults);
    robot.joints.push_back(jointOf(joint, faults));
    body = bodyFrom(tree, joint.child, body.nextPose.turn, faults);
    robot.links.push_back(linkOf(body, *plane, faults));
  }
  if (!plane) faults.push_back({"robot_description", "a joint that is revolute or continuous", "none"});
  if (!faults.empty()) throw Refused(std::move(faults));
  robot.gravity = plane->gravity;
  return robot;
}

}  // namespace planar_chain
