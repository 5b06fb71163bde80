#include "planar_chain/urdf_reader.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "planar_chain/value.h"
#include "reading/section.h"
#include "scene/joint_types.h"
#include "scene/urdf_document.h"

namespace planar_chain {

namespace {

using Eigen::Vector3d;

constexpr double standardGravity = 9.81;
constexpr double parallel = 1e-5;  // rad: accepts 1.5708 as a right angle, and not 1.57

// ---- The tree --------------------------------------------------------------------------------

/// The links whose parent is known, from the root outwards.
std::size_t countReached(const UrdfDocument& document, std::size_t root) {
  std::vector<std::size_t> reached{root};
  for (std::size_t i = 0; i < reached.size(); ++i) {
    for (const std::size_t joint : document.links[reached[i]].joints) {
      reached.push_back(document.joints[joint].child);
    }
  }
  return reached.size();
}

/// Lists the joints of each link. Returns the link that is the ground, or nothing if this is not a tree.
std::optional<std::size_t> findRoot(UrdfDocument& document, std::vector<Fault>& faults) {
  const std::size_t before = faults.size();
  std::vector<const UrdfJoint*> above(document.links.size());
  for (std::size_t i = 0; i < document.joints.size(); ++i) {
    const UrdfJoint& joint = document.joints[i];
    document.links[joint.parent].joints.push_back(i);
    const UrdfJoint*& first = above[joint.child];
    if (first) {
      faults.push_back({urdfPath("joint", joint.name) + "/child",
                        "a link that is the child of no other joint",
                        quoted(document.links[joint.child].name) + ", the child of " + quoted(first->name)});
    } else {
      first = &joint;
    }
  }

  std::vector<std::size_t> roots;
  for (std::size_t i = 0; i < above.size(); ++i) {
    if (!above[i]) roots.push_back(i);
  }
  if (roots.size() != 1) {
    constexpr std::size_t most = 3;
    std::string names = roots.empty() ? "none" : "";
    for (std::size_t i = 0; i < std::min(most, roots.size()); ++i) {
      names += (i > 0 ? ", " : "") + quoted(document.links[roots[i]].name);
    }
    if (roots.size() > most) names += " and " + std::to_string(roots.size() - most) + " more";
    faults.push_back({"robot_description", "one link that is the child of no joint, the ground", names});
  } else if (faults.size() == before && countReached(document, roots[0]) < above.size()) {
    faults.push_back({"robot_description", "a tree", "links in a closed loop"});
  }
  return faults.size() == before ? std::optional(roots[0]) : std::nullopt;
}

// ---- Bodies ----------------------------------------------------------------------------------

/// A link of a body, and its pose. The shift is measured from the body's joint, in the root's axes.
struct Part {
  const UrdfLink* link;
  Pose pose;
};

/// A moving joint and its pose, as that of a Part.
struct Placed {
  const UrdfJoint* joint;
  Pose pose;
};

/// Links that fixed joints make one body.
struct Body {
  std::vector<Part> parts;
  std::vector<Placed> branches;     ///< moving joints beside `next`
  const UrdfJoint* next = nullptr;  ///< the next moving joint; null at the end of the chain
  Pose nextPose;
};

/// The body that begins with link `first`, whose axes are turned by `turn`.
Body bodyFrom(const UrdfDocument& document, std::size_t first, const Eigen::Matrix3d& turn,
              std::vector<Fault>& faults) {
  Body body;
  body.parts.push_back({&document.links[first], Pose(turn)});
  for (std::size_t i = 0; i < body.parts.size(); ++i) {
    const Part part = body.parts[i];
    for (const std::size_t at : part.link->joints) {
      const UrdfJoint& joint = document.joints[at];
      const Pose below = part.pose * joint.origin;
      if (!joint.moves) {
        body.parts.push_back({&document.links[joint.child], below});
      } else if (!body.next) {
        body.next = &joint;
        body.nextPose = below;
      } else {
        body.branches.push_back({&joint, below});
        faults.push_back(
            {urdfPath("joint", joint.name),
             "a chain, with one moving joint on a body (make other joints fixed, such as those of "
             "a gripper's fingers)",
             "a branch beside " + quoted(body.next->name)});
      }
    }
  }
  return body;
}

/// The bodies of a chain from the root outwards: the ground first.
std::vector<Body> bodiesFrom(const UrdfDocument& document, std::size_t root, std::vector<Fault>& faults) {
  std::vector<Body> bodies{bodyFrom(document, root, Eigen::Matrix3d::Identity(), faults)};
  while (bodies.back().next) {
    const std::size_t child = bodies.back().next->child;
    const Eigen::Matrix3d turn = bodies.back().nextPose.linear();
    bodies.push_back(bodyFrom(document, child, turn, faults));
  }
  return bodies;
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

/// The visual elements of a body, in the axes of the plane. from: the origin of our frame, measured as the
/// parts are, in the root's axes. depth: of the body's joint above the plane.
std::string visualsOf(const Body& body, const Plane& plane, const Vector3d& from, double depth) {
  Pose toPlane = Pose::Identity();
  toPlane.linear() << plane.i.transpose(), plane.j.transpose(), plane.k.transpose();
  std::string text;
  for (const Part& part : body.parts) {
    for (const UrdfVisual& visual : part.link->visuals) {
      const Pose pose = toPlane * Eigen::Translation3d(-from) * part.pose * visual.origin;
      const auto R = pose.linear();
      const double level = std::hypot(R(0, 0), R(1, 0));  // 0: pitch is ±π/2, and roll is counted in yaw
      constexpr double rounding = 1e-9;                   // of products of rotations with ten digits
      const bool isUpright = level < rounding;
      const double rpy[] = {isUpright ? 0 : std::atan2(R(2, 1), R(2, 2)), std::atan2(-R(2, 0), level),
                            isUpright ? std::atan2(-R(0, 1), R(1, 1)) : std::atan2(R(1, 0), R(0, 0))};
      const Vector3d xyz = pose.translation() + depth * Vector3d::UnitZ();
      const auto three = [](const auto& a) { return toText(a[0]) + " " + toText(a[1]) + " " + toText(a[2]); };
      text += "<visual><origin xyz=\"" + three(xyz) + "\" rpy=\"" + three(rpy) + "\"/>" + visual.text +
              "</visual>";
    }
  }
  return text;
}

void requireName(const char* kind, const std::string& name, std::vector<Fault>& faults) {
  if (!isName(name)) faults.push_back({urdfPath(kind, name) + "/name", nameInWords, quoted(name)});
}

/// The body in the plane, about its own joint. A plain disc if there is a fault.
Link linkOf(const Body& body, bool isPrismatic, const Plane& plane, bool hasPoses,
            std::vector<Fault>& faults) {
  // Name and mass.
  Link link;
  link.name = body.parts[0].link->name;
  const Link disc{link.name, 1, 1, {0, 0}, {1, 0}};
  const std::string path = urdfPath("link", link.name);
  requireName("link", link.name, faults);
  for (const Part& part : body.parts) {
    if (!hasPoses || !part.link->isSound) return disc;
    link.mass += part.link->mass;
  }
  if (link.mass == 0 && !isPrismatic) {
    faults.push_back({path + "/inertial",
                      "a mass > 0 kg of this link or of one fixed to it (or else make its joint fixed)",
                      "none"});
    return disc;
  }

  // The centre of mass, then the moment of inertia about it.
  const auto comOf = [&](const Part& part) {
    return plane(part.pose.translation() + part.pose.linear() * part.link->com);
  };
  for (const Part& part : body.parts) {
    if (part.link->mass > 0) link.com += part.link->mass / link.mass * comOf(part);
  }
  for (const Part& part : body.parts) {
    const Vec2d off = comOf(part) - link.com;
    const Vector3d axis = part.pose.linear().transpose() * plane.k;
    link.inertia += axis.dot(part.link->inertia * axis) + part.link->mass * dot(off, off);
  }

  // The outer pin. That of the last body is its farthest frame.
  for (const Part& part : body.parts) {
    const Vec2d frame = plane(part.pose.translation());
    if (length(frame) > length(link.pin)) link.pin = frame;
  }
  if (body.next) link.pin = plane(body.nextPose.translation());
  const std::vector<Fault> own = faultsOf(link, isPrismatic);
  for (const Fault& fault : own) {
    faults.push_back({path + "/" + fault.path, fault.expected, fault.found});
  }
  return own.empty() ? link : disc;
}

/// Records a fault if a joint moves out of the plane, or turns in the opposite sense. axis: in the root's
/// axes.
void requireInPlane(const UrdfJoint& joint, const Vector3d& axis, const Plane& plane,
                    std::vector<Fault>& faults) {
  const std::string path = urdfPath("joint", joint.name) + "/axis";
  const auto angle = [&] { return "an angle of " + toText(std::acos(plane.k.dot(axis))) + " rad"; };
  if (joint.isPrismatic) {
    if (std::abs(plane.k.dot(axis)) > parallel) {
      faults.push_back({path,
                        "an axis at right angles to those of the joints that turn, as the chain moves in a "
                        "plane (or make the joint fixed)",
                        angle()});
    }
  } else if (joint.hasNormal && plane.k.cross(axis).norm() > parallel) {
    faults.push_back({path,
                      "an axis parallel to the first joint's, as the chain moves in a plane (make a joint "
                      "that turns out of it fixed)",
                      angle()});
  } else if (joint.hasNormal && plane.k.dot(axis) < 0) {
    faults.push_back({path,
                      "the direction of the first joint's axis, so that all angles have one sense (reverse "
                      "the axis, and swap and negate its limits)",
                      "the opposite direction"});
  }
}

/// Records the faults of all bodies on branches, and of their joints.
void checkBranches(const UrdfDocument& document, const Plane& plane, std::vector<Placed> open,
                   std::vector<Fault>& faults, std::vector<Fault>& branches) {
  for (std::size_t i = 0; i < open.size(); ++i) {
    const auto [joint, pose] = open[i];
    if (document.hasPoses) requireInPlane(*joint, pose.linear() * joint->along, plane, faults);
    requireName("joint", joint->name, faults);
    const Body body = bodyFrom(document, joint->child, pose.linear(), branches);
    linkOf(body, joint->isPrismatic, plane, document.hasPoses, faults);
    if (body.next) open.push_back({body.next, body.nextPose});
    open.insert(open.end(), body.branches.begin(), body.branches.end());
  }
}

// ---- The chain -------------------------------------------------------------------------------

/// Adds a body and the joint that carries it. A free one has two prismatic joints without mass below it.
void append(const UrdfJoint& joint, const Vector3d& axis, const Plane& plane, Link link,
            std::vector<Fault>& faults, PlanarRobot& robot) {
  Joint own = joint;
  const Vec2d along = plane(axis);
  if (own.isPrismatic && length(along) > parallel) own.axis = along;
  if (joint.isFree && !robot.joints.empty()) {
    faults.push_back({urdfPath("joint", joint.name) + "/type",
                      "planar and floating of the first joint only (make it fixed)", "another one"});
  }
  if (joint.isFree && robot.joints.empty()) {
    robot.floats = true;
    for (const int each : {0, 1}) {
      FreeAxis free = freeAxis(link.name, joint.name, each);
      robot.links.push_back(std::move(free.link));
      robot.joints.push_back(std::move(free.joint));
      robot.appearance.visuals.emplace_back();
    }
  }
  robot.links.push_back(std::move(link));
  robot.joints.push_back(std::move(own));
}

/// The normal of the plane of motion, in the root's axes: the first axis of a joint that turns. Prismatic
/// joints alone move in the plane of the first axis and of the next one that is not parallel to it, or of
/// gravity. Of its two normals the one is taken that points to the front (−y), or upwards.
std::optional<Vector3d> normalOf(const std::vector<Body>& bodies) {
  std::vector<Vector3d> axes;
  bool arePrismatic = true;
  for (const Body& body : bodies) {
    if (!body.next) continue;
    axes.emplace_back(body.nextPose.linear() * body.next->along);
    if (body.next->hasNormal) return axes.back();
    arePrismatic = arePrismatic && body.next->isPrismatic;
  }
  if (axes.empty() || !arePrismatic) return std::nullopt;
  axes.insert(axes.end(), {Vector3d::UnitZ(), Vector3d::UnitX()});
  for (const Vector3d& axis : axes) {
    const Vector3d k = axes[0].cross(axis);
    if (k.norm() <= parallel) continue;
    return Vector3d(Vector3d(0.01, -1, 0.1).dot(k) < 0 ? -k.normalized() : k.normalized());
  }
  return std::nullopt;
}

}  // namespace

std::optional<PlanarRobot> findRobot(const std::string& text, std::vector<Fault>& faults,
                                     const std::set<std::string>& limitedElsewhere) {
  Notes notes;
  UrdfDocument document = parseUrdf(text, limitedElsewhere, faults, notes);
  if (!document.hasStructure) return std::nullopt;
  const std::optional<std::size_t> root = findRoot(document, faults);
  if (!root) return std::nullopt;

  const std::string& ground = document.links[*root].name;
  if (ground != "world" && !document.isFixedInGazebo) {
    notes.add(urdfPath("link", ground), "held in place as the ground, as no joint fixes it to a link world");
  }

  std::vector<Fault> branches;
  const std::vector<Body> bodies = bodiesFrom(document, *root, branches);
  const std::optional<Vector3d> normal = normalOf(bodies);
  if (!normal) {
    faults.insert(faults.end(), branches.begin(), branches.end());
    faults.push_back({"robot_description",
                      "a joint that is revolute, continuous, prismatic or planar (a floating one alone does "
                      "not give the plane of motion)",
                      "none"});
    return std::nullopt;
  }

  // From the ground outwards, body by body.
  PlanarRobot robot;
  const Plane plane(*normal);
  std::vector<Placed> behind;
  std::vector<std::string>& visuals = robot.appearance.visuals;
  visuals.push_back(visualsOf(bodies[0], plane, bodies[0].nextPose.translation(), 0));
  double depth = 0;
  for (std::size_t i = 0; i + 1 < bodies.size(); ++i) {
    const UrdfJoint& joint = *bodies[i].next;
    const Vector3d axis = bodies[i].nextPose.linear() * joint.along;
    if (i > 0) depth += plane.k.dot(bodies[i].nextPose.translation());
    if (document.hasPoses) requireInPlane(joint, axis, plane, faults);
    requireName("joint", joint.name, faults);
    const Body& body = bodies[i + 1];
    append(joint, axis, plane, linkOf(body, joint.isPrismatic, plane, document.hasPoses, faults), faults,
           robot);
    visuals.push_back(visualsOf(body, plane, Vector3d::Zero(), depth));
  }
  for (const Body& body : bodies) behind.insert(behind.end(), body.branches.begin(), body.branches.end());
  checkBranches(document, plane, std::move(behind), faults, branches);
  faults.insert(faults.end(), branches.begin(), branches.end());
  if (!branches.empty()) return std::nullopt;
  robot.gravity = plane.gravity;
  robot.appearance.materials = document.materials;
  robot.notes = notes.all();
  const auto isEmpty = [](const std::string& each) { return each.empty(); };
  if (std::all_of(visuals.begin(), visuals.end(), isEmpty)) robot.appearance = {};
  return robot;
}

PlanarRobot readUrdf(const std::string& text) {
  std::vector<Fault> faults;
  std::optional<PlanarRobot> robot = findRobot(text, faults);
  if (!faults.empty()) throw Refused(std::move(faults));
  return std::move(*robot);
}

}  // namespace planar_chain
