#include "scene/urdf_foreign.h"

#include <tinyxml2.h>

#include <algorithm>
#include <cctype>
#include <cstring>

namespace planar_chain {

// ---- Names -------------------------------------------------------------------------------------

bool isSlipOf(const std::string& name, const std::string& known) {
  if (std::min(name.size(), known.size()) < 4) return false;
  // The rest between equal beginnings and equal ends.
  const auto [a, b] = std::mismatch(name.begin(), name.end(), known.begin(), known.end());
  std::string own(a, name.end()), other(b, known.end());
  while (!own.empty() && !other.empty() && own.back() == other.back()) {
    own.pop_back();
    other.pop_back();
  }
  const bool isSwap = own.size() == 2 && other.size() == 2 && own[0] == other[1] && own[1] == other[0];
  return isSwap || (own.size() <= 1 && other.size() <= 1);
}

const ForeignForce* foreignForce(const std::string& name) {
  constexpr const char* spring = "write stiffness and rest_angle under links/NAME/joint of a scene instead";
  constexpr const char* rotor = "write rotor_inertia under links/NAME/joint of a scene";
  static const ForeignForce all[] = {
      {"spring_stiffness", spring, true},
      {"spring_reference", spring, true},
      {"drake:rotor_inertia", rotor, false},
      {"drake:gear_ratio", rotor, false},
      {"drake:mimic", "make the joint fixed", true},
  };
  const auto found = std::find_if(std::begin(all), std::end(all),
                                  [&](const ForeignForce& force) { return name == force.name; });
  return found == std::end(all) ? nullptr : found;
}

// ---- Elements beside links -----------------------------------------------------------------------

namespace {

using tinyxml2::XMLElement;

template <class Visit>
void forAll(const XMLElement& in, const char* kind, const Visit& visit) {
  for (auto at = in.FirstChildElement(kind); at; at = at->NextSiblingElement(kind)) visit(*at);
}

/// "robot_description/gazebo/joint[name]"
std::string pathOf(const std::string& parent, const XMLElement& element) {
  const char* name = element.Attribute("name");
  return "robot_description/" + parent + onOneLine(element.Name()) +
         (name ? "[" + onOneLine(name) + "]" : "");
}

/// The text of a child, without white space around it.
std::string textOf(const XMLElement& element, const char* child) {
  const XMLElement* at = element.FirstChildElement(child);
  std::string text = at && at->GetText() ? at->GetText() : "";
  const auto isInk = [](unsigned char c) { return std::isspace(c) == 0; };
  text.erase(text.begin(), std::find_if(text.begin(), text.end(), isInk));
  text.erase(std::find_if(text.rbegin(), text.rend(), isInk).base(), text.end());
  return text;
}

bool isChildOfAJoint(const XMLElement& robot, const std::string& link) {
  bool isChild = false;
  forAll(robot, "joint", [&](const XMLElement& joint) {
    const XMLElement* child = joint.FirstChildElement("child");
    isChild |= child && child->Attribute("link", link.c_str());
  });
  return isChild;
}

constexpr const char* noLoop = "no joint that closes a loop (remove it to simulate the open chain)";

/// An SDF joint may fix the root to the world. Any other one closes a loop.
bool readGazebo(const XMLElement& robot, const XMLElement& gazebo, std::vector<Fault>& faults, Notes& notes) {
  bool isFixed = false;
  forAll(gazebo, "joint", [&](const XMLElement& joint) {
    const bool holdsRoot = joint.Attribute("type", "fixed") && textOf(joint, "parent") == "world" &&
                           !isChildOfAJoint(robot, textOf(joint, "child"));
    isFixed |= holdsRoot;
    if (holdsRoot) return;
    faults.push_back({pathOf("gazebo/", joint), noLoop,
                      quoted(textOf(joint, "parent")) + " to " + quoted(textOf(joint, "child")),
                      joint.GetLineNum()});
  });

  const char* const of = gazebo.Attribute("reference");
  const auto note = [&](const char* key, const char* instead) {
    notes.add("robot_description/gazebo[" + onOneLine(of) + "]/" + key,
              std::string("not read, though it changes the motion (") + instead + ")", gazebo.GetLineNum());
  };
  if (!of) return isFixed;
  const std::string stiffness = textOf(gazebo, "springStiffness");
  if (stiffness.find_first_of("123456789") != std::string::npos) {
    note("springStiffness", "write stiffness and rest_angle under links/NAME/joint of a scene");
  }
  const std::string gravity = textOf(gazebo, "gravity"), off = textOf(gazebo, "turnGravityOff");
  if (gravity == "0" || gravity == "false") note("gravity", "every link has weight");
  if (off == "1" || off == "true") note("turnGravityOff", "every link has weight");
  return isFixed;
}

}  // namespace

bool readBesideLinks(const XMLElement& robot, std::vector<Fault>& faults, Notes& notes) {
  bool isFixed = false;
  forAll(robot, "gazebo",
         [&](const XMLElement& gazebo) { isFixed = readGazebo(robot, gazebo, faults, notes) || isFixed; });
  const auto refuse = [&](const char* kind, const char* expected) {
    forAll(robot, kind, [&](const XMLElement& tie) {
      faults.push_back({pathOf("", tie), expected, quoted(kind), tie.GetLineNum()});
    });
  };
  for (const char* kind : {"loop_joint", "drake:linear_bushing_rpy", "drake:ball_constraint"}) {
    refuse(kind, noLoop);
  }
  refuse("drake:joint", "<joint> with a type of URDF (Drake alone has others, such as ball and screw)");
  for (const char* kind : {"force_element", "drake:linear_spring_damper"}) {
    forAll(robot, kind, [&](const XMLElement& force) {
      notes.add(pathOf("", force),
                "not read, though it changes the motion (a scene may have springs and loads)",
                force.GetLineNum());
    });
  }
  return isFixed;
}

}  // namespace planar_chain
