#include "scene/urdf_document.h"

#include <tinyxml2.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <map>
#include <sstream>
#include <utility>

#include "reading/section.h"

namespace planar_chain {

namespace {

// Beyond these a text is refused unread. A chain of ten thousand links, as the node writes it, has half of
// them.
constexpr std::size_t mostMarks = 1000000;   ///< < and =
constexpr std::size_t mostElements = 50000;  ///< links, joints
constexpr double missing = std::numeric_limits<double>::quiet_NaN();
const char* const top = "robot_description";

[[noreturn]] void refuse(std::string expected, std::string found) {
  throw Refused({{top, std::move(expected), std::move(found)}});
}

/// Words between white space.
std::vector<std::string> wordsOf(const char* text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(std::move(word));
  return words;
}

// ---- Elements --------------------------------------------------------------------------------

using Names = std::initializer_list<const char*>;

/// An element, or one that is absent: then all of its attributes are.
class Element {
 public:
  Element(const tinyxml2::XMLElement* at, std::string path, std::vector<Fault>& faults)
      : at_(at), path_(std::move(path)), faults_(&faults) {}

  bool isThere() const { return at_ != nullptr; }
  void fault(const std::string& key, const std::string& expected, const std::string& found) const {
    faults_->push_back({path_ + (key.empty() ? "" : "/" + key), expected, found});
  }
  bool is(const char* attribute, const char* text) const { return at_ && at_->Attribute(attribute, text); }
  /// What an attribute says, as it is told to the user.
  std::string found(const char* attribute) const {
    const char* text = at_ ? at_->Attribute(attribute) : nullptr;
    return text ? describe(Value(text)) : "nothing";
  }

  /// Notes children or attributes that are none of these.
  const Element& of(Names children, Names attributes) const {
    if (!at_) return *this;
    for (auto child = at_->FirstChildElement(); child; child = child->NextSiblingElement()) {
      require(child->Name(), "elements", children);
    }
    for (auto attribute = at_->FirstAttribute(); attribute; attribute = attribute->Next()) {
      require(attribute->Name(), "attributes", attributes);
    }
    return *this;
  }

  /// The child of that name, absent or not; notes a second one.
  Element only(const char* name) const {
    const tinyxml2::XMLElement* child = at_ ? at_->FirstChildElement(name) : nullptr;
    if (child && child->NextSiblingElement(name)) {
      fault(name, "it once",
            "it again in line " + std::to_string(child->NextSiblingElement(name)->GetLineNum()));
    }
    return {child, path_ + "/" + name, *faults_};
  }

  std::string text(const char* attribute) const {
    const char* given = at_ ? at_->Attribute(attribute) : nullptr;
    if (!given || !*given) fault(attribute, "a name", found(attribute));
    return given ? given : "";
  }

  double number(const char* attribute, const NumberRule& rule, double absent = missing) const {
    const char* given = at_ ? at_->Attribute(attribute) : nullptr;
    if (!given && rule.holds(absent)) return absent;
    const std::vector<std::string> words = wordsOf(given ? given : "");
    const auto number = words.size() == 1 ? numberIn(words[0]) : std::nullopt;
    if (number && std::isfinite(*number) && rule.holds(*number)) return *number;
    fault(attribute, "a finite number " + rule.which, found(attribute));
    return missing;
  }

  Eigen::Vector3d three(const char* attribute, const char* unit, const Eigen::Vector3d& absent) const {
    const char* given = at_ ? at_->Attribute(attribute) : nullptr;
    if (!given) return absent;
    const std::vector<std::string> words = wordsOf(given);
    Eigen::Vector3d numbers;
    bool areSound = words.size() == 3;
    for (std::size_t i = 0; areSound && i < 3; ++i) {
      const auto number = numberIn(words[i]);
      areSound = number && std::isfinite(*number);
      numbers[static_cast<Eigen::Index>(i)] = number.value_or(0);
    }
    if (areSound) return numbers;
    fault(attribute, std::string("three finite numbers") + unit, found(attribute));
    return absent;
  }

 private:
  void require(const char* name, const char* kind, Names known) const {
    const auto is = [name](const char* other) { return std::strcmp(name, other) == 0; };
    if (std::any_of(known.begin(), known.end(), is)) return;
    std::string names;
    for (const char* each : known) names += (names.empty() ? "" : ", ") + std::string(each);
    fault(stepOf(name), std::string("one of the ") + kind + " " + names, describe(Value(name)));
  }

  const tinyxml2::XMLElement* at_;
  std::string path_;
  std::vector<Fault>* faults_;
};

Pose poseOf(const Element& origin) {
  origin.of({}, {"xyz", "rpy"});
  const Eigen::Vector3d rpy = origin.three("rpy", ", in rad", Eigen::Vector3d::Zero());
  const auto about = [&](int i) { return Eigen::AngleAxisd(rpy[i], Eigen::Vector3d::Unit(i)).matrix(); };
  return {about(2) * about(1) * about(0), origin.three("xyz", ", in m", Eigen::Vector3d::Zero())};
}

// ---- Links -----------------------------------------------------------------------------------

void readInertial(const Element& inertial, UrdfLink& link) {
  if (!inertial.of({"origin", "mass", "inertia"}, {}).isThere()) return;
  const Pose pose = poseOf(inertial.only("origin"));
  link.com = pose.shift;
  link.mass = inertial.only("mass").of({}, {"value"}).number("value", NumberRule::from(0, "kg"));
  const Element inertia = inertial.only("inertia").of({}, {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"});
  const NumberRule rule = NumberRule::any("kg m²");
  const double xx = inertia.number("ixx", rule), xy = inertia.number("ixy", rule);
  const double xz = inertia.number("ixz", rule), yy = inertia.number("iyy", rule);
  const double yz = inertia.number("iyz", rule), zz = inertia.number("izz", rule);
  Eigen::Matrix3d own;
  own << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  link.inertia = pose.turn * own * pose.turn.transpose();
}

// ---- Joints ----------------------------------------------------------------------------------

using Indices = std::map<std::string, std::size_t>;

std::size_t linkOf(const Element& end, const Indices& links) {
  const auto link = links.find(end.of({}, {"link"}).text("link"));
  if (link != links.end()) return link->second;
  end.fault("link", "the name of a link", end.found("link"));
  return 0;
}

void readMotion(const Element& element, bool isLimited, UrdfJoint& joint) {
  const Element axis = element.only("axis").of({}, {"xyz"});
  const Eigen::Vector3d given = axis.three("xyz", "", Eigen::Vector3d::UnitX());
  const double size = given.cwiseAbs().maxCoeff();
  if (size > 0) {
    joint.axis = (given / size).normalized();
  } else {
    axis.fault("xyz", "a direction", axis.found("xyz"));
  }

  const Element dynamics = element.only("dynamics").of({}, {"damping", "friction"});
  joint.damping = dynamics.number("damping", NumberRule::from(0, "N m s/rad"), 0);
  if (dynamics.number("friction", NumberRule::any("N m"), 0) != 0) {
    dynamics.fault("friction", "0 N m, for dry friction is not simulated", dynamics.found("friction"));
  }

  const Element limit = element.only("limit").of({}, {"lower", "upper", "effort", "velocity"});
  if (!isLimited) return;
  joint.lower = limit.number("lower", NumberRule::any("rad"), 0);
  joint.upper = limit.number("upper", NumberRule::above(joint.lower, "rad, the lower limit"), 0);
}

UrdfJoint readJoint(const Element& element, std::string name, const Indices& links) {
  UrdfJoint joint;
  joint.name = std::move(name);
  element.of(
      {"parent", "child", "origin", "axis", "dynamics", "limit", "mimic", "calibration", "safety_controller"},
      {"name", "type"});
  joint.parent = linkOf(element.only("parent"), links);
  joint.child = linkOf(element.only("child"), links);
  joint.origin = poseOf(element.only("origin"));

  const bool isLimited = element.is("type", "revolute");
  joint.moves = !element.is("type", "fixed");
  if (isLimited || element.is("type", "continuous")) {
    readMotion(element, isLimited, joint);
  } else if (joint.moves) {
    element.fault("type", "revolute, continuous or fixed", element.found("type"));
  }
  const Element mimic = element.only("mimic");
  if (mimic.isThere()) mimic.fault("joint", "a joint that mimics no other", mimic.found("joint"));
  return joint;
}

// ---- The whole -------------------------------------------------------------------------------

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

/// The elements of a kind.
/// @throws Refused too many
std::vector<const tinyxml2::XMLElement*> all(const char* kind, const tinyxml2::XMLElement& robot) {
  std::vector<const tinyxml2::XMLElement*> elements;
  for (auto at = robot.FirstChildElement(kind); at; at = at->NextSiblingElement(kind)) elements.push_back(at);
  if (elements.size() > mostElements) {
    refuse("at most " + std::to_string(mostElements) + " of " + kind, std::to_string(elements.size()));
  }
  return elements;
}

/// The name of an element, which no other of its kind has.
std::string nameOf(const tinyxml2::XMLElement* at, Indices& taken, std::vector<Fault>& faults) {
  const std::string line = "line " + std::to_string(at->GetLineNum());
  const Element element(at, std::string(top) + "/" + at->Name() + "[" + line + "]", faults);
  const std::string name = element.text("name");
  if (!name.empty() && !taken.emplace(name, taken.size()).second) {
    element.fault("name", "a name that no other has", element.found("name"));
  }
  return name;
}

}  // namespace

std::string urdfPath(const char* kind, const std::string& name) {
  return std::string(top) + "/" + kind + "[" + stepOf(name) + "]";
}

UrdfDocument parseUrdf(const std::string& text) {
  requireBounds(text);
  tinyxml2::XMLDocument xml;
  if (xml.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    refuse("XML", "line " + std::to_string(xml.ErrorLineNum()) + ": " + xml.ErrorName());
  }
  const tinyxml2::XMLElement* robot = xml.RootElement();
  if (!robot || std::strcmp(robot->Name(), "robot") != 0) {
    refuse("one element robot", robot ? describe(Value(robot->Name())) : "nothing");
  }
  if (robot->NextSiblingElement()) refuse("one element robot", "more after it");

  UrdfDocument document;
  std::vector<Fault> faults;
  Indices links, joints;
  for (const tinyxml2::XMLElement* at : all("link", *robot)) {
    UrdfLink link;
    link.name = nameOf(at, links, faults);
    const Element element(at, urdfPath("link", link.name), faults);
    element.of({"inertial", "visual", "collision", "contact"}, {"name"});
    readInertial(element.only("inertial"), link);
    document.links.push_back(std::move(link));
  }
  for (const tinyxml2::XMLElement* at : all("joint", *robot)) {
    std::string name = nameOf(at, joints, faults);
    const Element element(at, urdfPath("joint", name), faults);
    document.joints.push_back(readJoint(element, std::move(name), links));
  }
  for (auto at = robot->FirstChildElement(); at; at = at->NextSiblingElement()) {
    if (std::strncmp(at->Name(), "xacro:", 6) != 0) continue;
    faults.push_back(
        {std::string(top) + "/" + stepOf(at->Name()), "URDF as the program xacro writes it", "xacro"});
  }
  if (!faults.empty()) throw Refused(std::move(faults));
  return document;
}

}  // namespace planar_chain
