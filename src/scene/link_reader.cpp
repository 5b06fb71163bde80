#include "scene/link_reader.h"

#include <cmath>

#include "scene/joint_types.h"
#include "scene/settings_reader.h"

namespace planar_chain {

namespace {

/// A name with a fault is kept: loads may give it.
void takeName(const Section& joint, Entry& entry) {
  if (!joint.has("name")) return;
  entry.isSound &= joint.takeText("name", isName, nameInWords, entry.joint.name);
  if (const std::string* text = joint.find("name")->text()) entry.joint.name = *text;
}

/// Reads `joint` and `initial` of a floating link.
void takeFreeMotion(const Section& in, bool isInUrdf, Entry& entry) {
  const Section joint =
      in.section("joint", isInUrdf ? std::vector<const char*>{} : std::vector<const char*>{"name", "type"});
  if (!isInUrdf) entry.joint.name = entry.link.name;
  takeName(joint, entry);
  const Section initial = in.section("initial", {"position", "linear_velocity", "angle", "velocity"});
  initial.take("position", "m", entry.position);
  initial.take("linear_velocity", "m/s", entry.linearVelocity);
  if (initial.take("angle", NumberRule::any("rad"), entry.q) &&
      std::abs(entry.q) > largestAngle(entry.joint)) {
    initial.fault("angle", anglesInWords(entry.joint));
  }
  initial.take("velocity", NumberRule::any("rad/s"), entry.qd);
  if (entry.repeat > 1) {
    in.fault("repeat", "no repeat of a floating link");
    entry.repeat = 1;
  }
}

Hints hintsInJoint(const Section& in, bool isInUrdf) {
  Hints hints = hintsAtMaps(in.pathOf("joint"));
  for (const char* key : {"angle", "velocity"}) hints[key] = belongsTo(in.pathOf("initial/") + key);
  for (const char* key : {"limit", "limits"}) hints[key] = "no such key: lower and upper are the limits";
  if (isInUrdf) return hints;
  for (const char* key : {"mass", "inertia", "com", "pin", "repeat"}) hints[key] = belongsTo(in.pathOf(key));
  return hints;
}

/// Reads `joint` and `initial`.
void takeMotion(const Section& in, bool isInUrdf, Entry& entry) {
  if (entry.floats) return takeFreeMotion(in, isInUrdf, entry);
  const bool isPrismatic = entry.joint.isPrismatic;
  std::vector<const char*> keys{"drive"};
  if (!isInUrdf) keys.insert(keys.end(), {"name", "type"});
  if (!isInUrdf && isPrismatic) keys.push_back("axis");
  for (const char* key : effectKeys(isInUrdf)) keys.push_back(key);
  if (isInUrdf) keys.push_back("limits");
  const Section joint = in.section("joint", keys, [&] { return hintsInJoint(in, isInUrdf); });
  if (isInUrdf && joint.has("limits")) takeNoLimits(joint, entry.joint);
  if (!isInUrdf) takeName(joint, entry);
  if (isPrismatic) joint.take("axis", "no unit: a direction", entry.joint.axis);
  takeEffects(joint, entry.joint);
  entry.hasStopDamping = joint.has("stop_damping");

  const char* coordinate = isPrismatic ? "position" : "angle";
  const Section initial = in.section("initial", {coordinate, "velocity"});
  const Joint complete = withStop(entry.joint);
  if (initial.take(coordinate, NumberRule::any(isPrismatic ? "m" : "rad"), entry.q) &&
      std::abs(entry.q) > largestAngle(complete)) {
    initial.fault(coordinate, anglesInWords(complete));
  }
  initial.take("velocity", NumberRule::any(isPrismatic ? "m/s" : "rad/s"), entry.qd);
  if (!joint.has("drive")) return;
  if (isInUrdf && hasMoreThanDrive(entry.joint)) {
    joint.fault("drive", "no drive in a joint to which the URDF gives damping, friction or limits", "drive");
  }
  entry.drive = readDrive(in, joint, isPrismatic ? "m" : "rad", entry.q, entry.qd);
}

}  // namespace

void takeBeside(const Section& links, Entry& entry) {
  std::vector<const char*> keys{"joint", "initial"};
  for (const char* key : linkKeys()) keys.push_back(key);
  const Section in = links.section(entry.link.name, keys);
  takeEffects(in, entry.link);
  takeMotion(in, true, entry);
}

Entry readEntry(const Section& links, const std::string& name) {
  // The name. A disc replaces a body with faults, so that the names and the other links can be checked.
  Entry entry{{name, 1, 1, {0, 0}, {1, 0}}, {}};
  std::vector<const char*> keys{"mass", "inertia", "com", "pin", "repeat", "joint", "initial"};
  for (const char* key : linkKeys()) keys.push_back(key);
  const Section in = links.section(name, keys, [&] { return hintsIn(links.pathOf(name)); });
  entry.isSound = isName(name);
  if (!entry.isSound) links.fault(name, nameInWords, quoted(name));
  if (!links.find(name)->map()) return entry;

  // The number of links. Which other values they need depends on the joint's type.
  entry.isCounted = takeCount(in, "repeat", entry.repeat);
  const JointType type = takeType(in, entry.isSound);

  // The body. A prismatic link needs only its mass.
  const bool isPrismatic = entry.joint.isPrismatic = type == JointType::prismatic;
  entry.floats = type == JointType::floating;
  const auto pairOf = [&](const char* key) {
    return isPrismatic && !in.has(key) ? Vec2d{} : in.uncheckedPair(key);
  };
  const Link link{name, in.uncheckedNumber("mass"),
                  isPrismatic && !in.has("inertia") ? 0 : in.uncheckedNumber("inertia"), pairOf("com"),
                  pairOf("pin")};
  const std::vector<Fault> ofLink = faultsOf(link, isPrismatic);
  for (const Fault& fault : ofLink) in.fault(fault.path, fault.expected);
  if (ofLink.empty()) entry.link = link;
  takeEffects(in, entry.link);

  // How they move.
  if (isPrismatic && entry.repeat > 1) {
    in.fault("repeat", "no repeat of a prismatic link");
    entry.repeat = 1;
  }
  takeMotion(in, false, entry);
  return entry;
}

}  // namespace planar_chain
