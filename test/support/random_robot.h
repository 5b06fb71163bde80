#pragma once

/// Random URDF robots that are planar chains, with everything turned and shifted that may be: the plane lies
/// anywhere, frames have any orientation, joints are anywhere along their axes, links have links on fixed
/// joints, inertia tensors are full. The first joint may be planar or floating, any joint prismatic.

#include <Eigen/Geometry>
#include <sstream>
#include <string>
#include <vector>

#include "random_scene.h"

namespace planar_chain::test {

/// A link and the joint on which it hangs.
struct Part {
  std::string name;
  int parent;        ///< index; -1: the root link
  std::string type;  ///< of the joint
  Eigen::Vector3d xyz, rpy;
  Eigen::Vector3d axis;  ///< in the link's frame
  double mass;
  Eigen::Vector3d com, inertialRpy;
  Eigen::Matrix3d inertia;  ///< in the axes of the inertial frame
  double damping;

  bool moves() const { return type != "fixed"; }
  bool isFree() const { return type == "planar" || type == "floating"; }
  bool isPrismatic() const { return type == "prismatic"; }
};

inline Eigen::Matrix3d turnOf(const Eigen::Vector3d& rpy) {
  Eigen::Matrix3d x, y, z;
  x << 1, 0, 0, 0, cos(rpy[0]), -sin(rpy[0]), 0, sin(rpy[0]), cos(rpy[0]);
  y << cos(rpy[1]), 0, sin(rpy[1]), 0, 1, 0, -sin(rpy[1]), 0, cos(rpy[1]);
  z << cos(rpy[2]), -sin(rpy[2]), 0, sin(rpy[2]), cos(rpy[2]), 0, 0, 0, 1;
  return z * y * x;
}

inline Eigen::Vector3d vectorOf(Random& random, double size) {
  return {random.between(-size, size), random.between(-size, size), random.between(-size, size)};
}

/// Returns the inertia tensor of four masses at random points.
inline Eigen::Matrix3d inertiaOf(Random& random) {
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d r = vectorOf(random, 0.4);
    inertia += random.between(0.2, 1) * (r.dot(r) * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  return inertia;
}

/// n joints that move, each body of one to three links. in front: the types of the first joints.
inline std::vector<Part> randomRobot(int n, unsigned seed, const std::vector<std::string>& front = {}) {
  Random random(seed);
  const Eigen::Vector3d normal = vectorOf(random, 1).normalized();
  std::vector<Part> parts;
  std::vector<Eigen::Matrix3d> turns;  // in the root, all joints at 0
  const auto add = [&](int parent, const std::string& type) {
    Part part;
    part.parent = parent;
    part.type = type;
    part.name = (part.moves() ? "link_" : "part_") + std::to_string(parts.size());
    part.xyz = vectorOf(random, 0.8);
    part.rpy = vectorOf(random, 3);
    const Eigen::Matrix3d turn = turnOf(part.rpy);
    turns.push_back(parent < 0 ? turn : turns[static_cast<std::size_t>(parent)] * turn);
    part.axis = turns.back().transpose() * normal;
    if (part.isPrismatic()) {
      part.axis = turns.back().transpose() * normal.cross(vectorOf(random, 1)).normalized();
    }
    part.mass = random.between(0.2, 3);
    part.com = vectorOf(random, 0.5);
    part.inertialRpy = vectorOf(random, 3);
    part.inertia = inertiaOf(random);
    part.damping = part.moves() && !part.isFree() ? random.between(0, 2) : 0;
    parts.push_back(part);
    return static_cast<int>(parts.size()) - 1;
  };
  int end = add(-1, "fixed");
  for (int i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    end = add(end, at < front.size() ? front[at] : "continuous");
    for (int k = random.index(3); k > 0; --k) end = add(end, "fixed");
  }
  return parts;
}

inline std::string urdfOf(const std::vector<Part>& parts) {
  std::ostringstream out;
  out.precision(17);
  const auto three = [&](const char* name, const Eigen::Vector3d& a) -> std::ostringstream& {
    out << ' ' << name << "=\"" << a[0] << ' ' << a[1] << ' ' << a[2] << '"';
    return out;
  };
  out << "<?xml version=\"1.0\"?>\n<robot name=\"random\">\n<link name=\"ground\"/>\n";
  for (const Part& part : parts) {
    const Eigen::Matrix3d& I = part.inertia;
    out << "<link name=\"" << part.name << "\"><inertial><origin";
    three("xyz", part.com);
    three("rpy", part.inertialRpy);
    out << "/><mass value=\"" << part.mass << "\"/><inertia ixx=\"" << I(0, 0) << "\" ixy=\"" << I(0, 1)
        << "\" ixz=\"" << I(0, 2) << "\" iyy=\"" << I(1, 1) << "\" iyz=\"" << I(1, 2) << "\" izz=\""
        << I(2, 2) << "\"/></inertial></link>\n<joint name=\"" << part.name << "_joint\" type=\"" << part.type
        << "\"><parent link=\""
        << (part.parent < 0 ? "ground" : parts[static_cast<std::size_t>(part.parent)].name)
        << "\"/><child link=\"" << part.name << "\"/><origin";
    three("xyz", part.xyz);
    three("rpy", part.rpy);
    out << "/><axis";
    three("xyz", part.axis);
    if (part.isPrismatic()) out << "/><limit lower=\"-1e9\" upper=\"1e9\" effort=\"1e9\" velocity=\"1e9\"";
    out << "/><dynamics damping=\"" << part.damping << "\"/></joint>\n";
  }
  out << "</robot>\n";
  return out.str();
}

}  // namespace planar_chain::test
