#include "scene/urdf_document.h"

#include <tinyxml2.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>

#include "model/prismatic.h"
#include "reading/section.h"
#include "scene/urdf_element.h"
#include "scene/urdf_foreign.h"

namespace planar_chain {

namespace {

// A text with more is refused unread. The URDF that the node writes for ten thousand links has half of these.
constexpr std::size_t mostMarks = 1000000;   ///< < and =
constexpr std::size_t mostElements = 50000;  ///< links, joints
const char* const top = "robot_description";

[[noreturn]] void refuse(std::string expected, std::string found) {
  throw Refused({{top, std::move(expected), std::move(found)}});
}

/// An element as it is written.
std::string textOf(const tinyxml2::XMLElement& element) {
  tinyxml2::XMLPrinter printer(nullptr, true);
  element.Accept(&printer);
  return printer.CStr();
}

Pose poseOf(const Element& origin) {
  origin.of({}, {"xyz", "rpy"});
  const Eigen::Vector3d rpy = origin.three("rpy", ", in rad", Eigen::Vector3d::Zero());
  const auto about = [&](int i) { return Eigen::AngleAxisd(rpy[i], Eigen::Vector3d::Unit(i)).matrix(); };
  Pose pose;
  pose.linear() = about(2) * about(1) * about(0);
  pose.translation() = origin.three("xyz", ", in m", Eigen::Vector3d::Zero());
  return pose;
}

// ---- Links -----------------------------------------------------------------------------------

void readInertial(const Element& inertial, UrdfLink& link) {
  if (!inertial.of({"origin", "mass", "inertia"}, {}).isThere()) return;
  const std::size_t before = inertial.faults();
  // The frame of the tensor, and the mass.
  const Pose pose = poseOf(inertial.only("origin"));
  link.com = pose.translation();
  link.mass = inertial.only("mass").of({}, {"value"}).number("value", NumberRule::from(0, "kg"));
  // The tensor, turned into the axes of the link.
  const Element inertia = inertial.only("inertia").of({}, {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"});
  if (!inertia.isThere()) {
    inertial.note("has a mass without <inertia>: read as a point mass");
    link.isSound = inertial.faults() == before;
    return;
  }
  const NumberRule rule = NumberRule::any("kg m²");
  const double xx = inertia.number("ixx", rule), xy = inertia.number("ixy", rule, 0);
  const double xz = inertia.number("ixz", rule, 0), yy = inertia.number("iyy", rule);
  const double yz = inertia.number("iyz", rule, 0), zz = inertia.number("izz", rule);
  Eigen::Matrix3d own;
  own << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  link.inertia = pose.linear() * own * pose.linear().transpose();
  link.isSound = inertial.faults() == before;
}

/// Shapes are only drawn, so one with a fault is left out.
void readVisuals(const tinyxml2::XMLElement& element, UrdfLink& link) {
  for (auto at = element.FirstChildElement("visual"); at; at = at->NextSiblingElement("visual")) {
    std::vector<Fault> faults;
    Notes unused;
    Findings own{faults, unused};
    UrdfVisual visual{poseOf(Element(at, "", own).only("origin")), ""};
    for (const char* part : {"geometry", "material"}) {
      if (const tinyxml2::XMLElement* child = at->FirstChildElement(part)) visual.text += textOf(*child);
    }
    if (faults.empty()) link.visuals.push_back(std::move(visual));
  }
}

// ---- Joints ----------------------------------------------------------------------------------

using Indices = std::map<std::string, std::size_t>;

/// Reads the link at one end of a joint. Returns false if there is none of that name.
bool takeEnd(const Element& end, const Indices& links, std::size_t& index) {
  const auto link = links.find(end.of({}, {"link"}).name("link"));
  if (link == links.end()) end.fault("link", "the name of a link");
  if (link != links.end()) index = link->second;
  return link != links.end();
}

Eigen::Vector3d axisOf(const Element& axis) {
  axis.of({}, {"xyz"});
  const Eigen::Vector3d given = axis.three("xyz", "", Eigen::Vector3d::UnitX());
  const double size = given.cwiseAbs().maxCoeff();
  if (size > 0) return (given / size).normalized();
  axis.fault("xyz", "a direction");
  return Eigen::Vector3d::UnitX();
}

/// Reads lower and upper. Without both, the joint moves freely.
void readRange(const Element& element, const Element& limit, const std::string& child, UrdfJoint& joint) {
  if (!limit.attribute("lower") && !limit.attribute("upper")) {
    element.note(joint.isPrismatic
                     ? "a prismatic joint without lower and upper: slides freely"
                     : "a revolute joint without lower and upper: turns freely, as a continuous one");
    return;
  }
  // Some exporters write [0, 0] for unknown limits.
  const std::string unit = joint.isPrismatic ? "m" : "rad", entry = "links/" + onOneLine(child) + "/joint";
  const std::string wayOut = unit + ", the lower limit (or else a scene beside the URDF, with " + entry +
                             ": {limits: none}, or {lower: …, upper: …})";
  const NumberRule any = NumberRule::any(unit);
  joint.lower = limit.number("lower", any, 0);
  const bool hasLower = std::isfinite(joint.lower);
  joint.upper = limit.number("upper", hasLower ? NumberRule::above(joint.lower, wayOut) : any, 0);
  if (joint.lower <= -noLimit) joint.lower = Joint().lower;
  if (joint.upper >= noLimit) joint.upper = Joint().upper;
}

/// Reads damping and limits of a revolute or prismatic joint, its range only if it isLimited. After a fault
/// they are 0, and [0, 1] rad or m.
void readMotion(const Element& element, bool isLimited, const std::string& child, UrdfJoint& joint) {
  const std::size_t before = element.faults();
  const auto unit = [&](const char* ofAngle) {
    return joint.isPrismatic ? inUnitsOfPrismatic(ofAngle) : ofAngle;
  };
  const Element dynamics = element.only("dynamics").of({}, {"damping", "friction"});
  joint.damping = dynamics.number("damping", NumberRule::coefficient(unit("N m s/rad")), 0);
  const Element limit = element.only("limit").of({}, {"lower", "upper", "effort", "velocity"});
  // Many a file has 0 or -1 where there is no limit.
  const auto keep = [&](const char* key, double value) {
    if (value > 0) joint.others.emplace_back(key, value);
  };
  for (const char* key : {"effort", "velocity"}) {
    const std::string given = limit.attribute(key) ? limit.attribute(key) : "";
    if (numberIn(given) == 0) limit.note(std::string(key) + " 0 is read as no limit", key);
  }
  keep("friction", dynamics.number("friction", NumberRule::from(0, unit("N m")), 0));
  keep("effort_limit", limit.number("effort", NumberRule::any(unit("N m")), 0));
  keep("velocity_limit", limit.number("velocity", NumberRule::any(unit("rad/s")), 0));
  if (isLimited) readRange(element, limit, child, joint);
  if (element.faults() == before) return;
  joint.others.clear();
  joint.damping = joint.lower = 0;
  joint.upper = 1;
}

/// A planar or floating joint has neither damping nor limits: its three motions would share them.
void readFreeMotion(const Element& element) {
  const Element dynamics = element.only("dynamics").of({}, {"damping", "friction"});
  for (const char* key : {"damping", "friction"}) {
    const double value = dynamics.number(key, NumberRule::any("any unit"), 0);
    if (value != 0 && std::isfinite(value)) {
      dynamics.fault(key, "0 in a planar or floating joint (or two prismatic joints and a revolute one)");
    }
  }
  if (element.only("limit").isThere())
    element.note("limit of a planar or floating joint is not read", "limit");
}

/// Reads the type of the joint.
void readType(const Element& element, UrdfJoint& joint) {
  const std::string type = element.attribute("type") ? element.attribute("type") : "";
  joint.isPrismatic = type == "prismatic";
  joint.isFree = type == "planar" || type == "floating";
  joint.moves = type != "fixed";
  joint.hasNormal = joint.moves && !joint.isPrismatic && type != "floating";
  if (joint.hasNormal && !joint.isFree && type != "revolute" && type != "continuous") {
    element.fault("type", "revolute, continuous, prismatic, planar, floating or fixed");
  }
}

void readJoint(const Element& element, const Indices& links, const std::set<std::string>& limitedElsewhere,
               UrdfJoint& joint, UrdfDocument& document) {
  element.of(
      {"parent", "child", "origin", "axis", "dynamics", "limit", "mimic", "calibration", "safety_controller"},
      {"name", "type"});
  document.hasStructure &= takeEnd(element.only("parent"), links, joint.parent);
  const Element end = element.only("child");
  document.hasStructure &= takeEnd(end, links, joint.child);

  const std::size_t before = element.faults();
  readType(element, joint);
  joint.origin = poseOf(element.only("origin"));
  if (joint.hasNormal || joint.isPrismatic) joint.along = axisOf(element.only("axis"));
  document.hasPoses &= element.faults() == before;

  const std::string child = end.attribute("link") ? end.attribute("link") : "";
  const bool isContinuous =
      element.attribute("type") && std::strcmp(element.attribute("type"), "continuous") == 0;
  if (joint.isFree) {
    readFreeMotion(element);
  } else if (joint.hasNormal || joint.isPrismatic) {
    readMotion(element, !isContinuous && limitedElsewhere.count(child) == 0, child, joint);
  }
  const Element mimic = element.only("mimic");
  if (mimic.isThere())
    mimic.fault("joint", "a joint that mimics no other (make the fingers of a gripper fixed)");
}

// ---- The document ----------------------------------------------------------------------------

void requireBounds(const std::string& text) {
  if (text.size() > longestYaml) {
    refuse("at most " + std::to_string(longestYaml) + " bytes", std::to_string(text.size()));
  }
  const auto marks = std::count_if(text.begin(), text.end(), [](char c) { return c == '<' || c == '='; });
  if (static_cast<std::size_t>(marks) > mostMarks) {
    refuse("at most " + std::to_string(mostMarks) + " of < and =", std::to_string(marks));
  }
  if (text.find('\0') != std::string::npos) refuse("XML", "a text with a byte 0");
}

/// True if a joint has the parent `world`.
bool hasParentWorld(const tinyxml2::XMLElement& robot) {
  for (auto at = robot.FirstChildElement("joint"); at; at = at->NextSiblingElement("joint")) {
    const tinyxml2::XMLElement* parent = at->FirstChildElement("parent");
    if (parent && parent->Attribute("link", "world")) return true;
  }
  return false;
}

/// Calls read(element, name) for each element of one kind.
/// @returns false if a name is missing, or not unique
/// @throws Refused if there are too many
template <class Read>
bool forAll(const char* kind, const tinyxml2::XMLElement& robot, Indices& taken, Findings& to,
            const Read& read) {
  std::size_t count = 0;
  for (auto at = robot.FirstChildElement(kind); at; at = at->NextSiblingElement(kind)) ++count;
  if (count > mostElements) {
    refuse("at most " + std::to_string(mostElements) + " of " + kind, std::to_string(count));
  }
  for (auto at = robot.FirstChildElement(kind); at; at = at->NextSiblingElement(kind)) {
    const Element unnamed(at, urdfPath(kind, "line " + std::to_string(at->GetLineNum())), to);
    const std::string name = unnamed.name("name");
    if (!name.empty() && !taken.emplace(name, taken.size()).second) unnamed.fault("name", "a unique name");
    read(Element(at, urdfPath(kind, name), to), name);
  }
  return taken.size() == count;
}

}  // namespace

std::string urdfPath(const char* kind, const std::string& name) {
  return std::string(top) + "/" + kind + "[" + onOneLine(name) + "]";
}

UrdfDocument parseUrdf(const std::string& text, const std::set<std::string>& limitedElsewhere,
                       std::vector<Fault>& faults, Notes& notes) {
  // XML with one element, robot.
  requireBounds(text);
  tinyxml2::XMLDocument xml;
  if (xml.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    refuse("XML", !text.empty() && text.find('<') == std::string::npos
                      ? "a text without < (is it a scene, or a path?)"
                      : "line " + std::to_string(xml.ErrorLineNum()) + ": " + xml.ErrorName());
  }
  const tinyxml2::XMLElement* robot = xml.RootElement();
  if (!robot || std::strcmp(robot->Name(), "robot") != 0) {
    refuse("one element robot", robot ? quoted(robot->Name()) : "nothing");
  }
  if (robot->NextSiblingElement()) refuse("one element robot", "more after it");

  // Its links, then its joints, which refer to them.
  UrdfDocument document;
  Findings to{faults, notes};
  Indices links, joints;
  document.hasStructure &= forAll("link", *robot, links, to, [&](const Element& element, auto& name) {
    UrdfLink& link = document.links.emplace_back();
    link.name = name;
    element.of({"inertial", "visual", "collision", "contact"}, {"name"});
    readInertial(element.only("inertial"), link);
    readVisuals(element.element(), link);
  });
  for (auto at = robot->FirstChildElement("material"); at; at = at->NextSiblingElement("material")) {
    document.materials += textOf(*at);
  }
  // Many files connect the robot to a link `world` that they do not list.
  if (links.count("world") == 0 && hasParentWorld(*robot)) {
    links.emplace("world", document.links.size());
    document.links.emplace_back().name = "world";
  }
  document.hasStructure &= forAll("joint", *robot, joints, to, [&](const Element& element, auto& name) {
    UrdfJoint& joint = document.joints.emplace_back();
    joint.name = name;
    readJoint(element, links, limitedElsewhere, joint, document);
  });
  document.isFixedInGazebo = readBesideLinks(*robot, faults, notes);

  // A file that xacro has not expanded.
  for (auto at = robot->FirstChildElement(); at; at = at->NextSiblingElement()) {
    if (std::strncmp(at->Name(), "xacro:", 6) != 0) continue;
    faults.push_back(
        {std::string(top) + "/" + onOneLine(at->Name()), "URDF, the output of the program xacro", "xacro"});
    document.hasStructure = false;
  }
  return document;
}

}  // namespace planar_chain
