#include "scene/effect_values.h"

#include <limits>
#include <set>
#include <string>

#include "model/prismatic.h"

namespace planar_chain {

Joint withStop(Joint joint) {
  if (joint.isLimited()) joint.stopStiffness = 1;
  return joint;
}

std::vector<const char*> linkKeys() {
  std::vector<const char*> keys;
  for (const EffectKind* kind : effectKinds()) {
    if (kind->linkKey()) keys.push_back(kind->linkKey());
  }
  return keys;
}

void takeEffects(const Section& in, Link& link) {
  for (const EffectKind* kind : effectKinds()) {
    if (kind->linkKey() && in.has(kind->linkKey())) kind->takeLink(in, link);
  }
}

namespace {

/// The key of a map without the map's name.
const char* lastPart(const JointKey& key) {
  return key.name + std::string(key.map).size() + 1;
}

/// Checks that the maps of effects are maps, have known keys, and have one.
void checkMaps(const Section& in) {
  std::map<std::string, std::vector<const char*>> maps;
  for (const EffectKind* kind : effectKinds()) {
    for (const JointKey& key : kind->jointKeys()) {
      if (key.map) maps[key.map].push_back(lastPart(key));
    }
  }
  for (const auto& [map, keys] : maps) {
    const Section section = in.section(map, keys);
    if (in.has(map) && in.find(map)->map() && section.entries().empty()) {
      in.fault(map, "a map with keys of: " + inCommas(keys));
    }
  }
}

}  // namespace

std::vector<const char*> effectKeys(bool isInUrdf) {
  std::vector<const char*> keys;
  std::set<std::string> maps;
  for (const EffectKind* kind : effectKinds()) {
    for (const JointKey& key : kind->jointKeys()) {
      if (isInUrdf && key.isInUrdf) continue;
      if (!key.map || maps.insert(key.map).second) keys.push_back(key.map ? key.map : key.name);
    }
  }
  return keys;
}

Hints hintsAtMaps(const std::string& joint) {
  Hints hints;
  for (const EffectKind* kind : effectKinds()) {
    for (const JointKey& key : kind->jointKeys()) {
      if (key.map) hints[lastPart(key)] = belongsTo(joint + "/" + key.name);
    }
  }
  return hints;
}

void takeEffects(const Section& in, Joint& joint) {
  checkMaps(in);
  std::set<std::string> refused;
  for (const EffectKind* kind : effectKinds()) {
    for (const JointKey& key : kind->jointKeys()) {
      if (!key.isAllowedBesideDrive && in.has("drive")) continue;  // a fault in any range
      double value = 0;
      if (!in.take(key.name, {joint.isPrismatic ? inUnitsOfPrismatic(key.range.which) : key.range.which},
                   value)) {
        if (in.has(key.name)) refused.insert(key.name);
      } else if (key.member) {
        joint.*key.member = value;
      } else {
        joint.others.set(key.name, value);  // in place of the URDF's
      }
    }
  }
  // A limit that is no number is a limit: a stop may be beside it.
  constexpr double far = std::numeric_limits<double>::max();
  if (refused.count("lower") > 0) joint.lower = -far;
  if (refused.count("upper") > 0) joint.upper = far;
  for (const Fault& fault : faultsOf(in.has("stop_stiffness") ? joint : withStop(joint))) {
    const std::string key = fault.path.substr(fault.path.find('/') + 1);
    if (refused.insert(key).second) in.fault(key, fault.expected);
  }
  if (refused.empty()) return;
  Joint plain{joint.name};
  plain.isPrismatic = joint.isPrismatic;
  plain.axis = joint.axis;
  joint = plain;
}

bool hasMoreThanDrive(const Joint& joint) {
  const Joint plain;
  for (const EffectKind* kind : effectKinds()) {
    for (const JointKey& key : kind->jointKeys()) {
      if (!key.isAllowedBesideDrive && key.of(joint) != key.of(plain)) return true;
    }
  }
  return false;
}

void takeNoLimits(const Section& in, Joint& joint) {
  const auto isNone = [](const std::string& text) { return text == "none"; };
  std::string none;
  const bool isTaken = in.takeText("limits", isNone, "none (or else lower and upper)", none);
  if (isTaken && (in.has("lower") || in.has("upper"))) {
    in.fault("limits", "no limits: none beside lower or upper");
  }
  joint.lower = Joint().lower;
  joint.upper = Joint().upper;
}

std::set<std::string> limitedIn(const Section& links) {
  std::set<std::string> names;
  for (const auto& [name, value] : links.entries()) {
    const Value::Map* link = value.map();
    const auto joint = link ? link->find("joint") : Value::Map::const_iterator();
    const Value::Map* keys = link && joint != link->end() ? joint->second.map() : nullptr;
    const auto has = [keys](const char* key) { return keys && keys->count(key) != 0; };
    if (has("limits") || (has("lower") && has("upper"))) names.insert(name);
  }
  return names;
}

Hints hintsIn(const std::string& link) {
  Hints hints{{"springs", "no such key: springs of the scene, by name, have the key link"}};
  for (const EffectKind* kind : effectKinds()) {
    for (const JointKey& key : kind->jointKeys()) {
      hints[key.map ? key.map : key.name] = belongsTo(link + "/joint/" + (key.map ? key.map : key.name));
    }
  }
  for (const auto& hint : hintsAtMaps(link + "/joint")) hints.insert(hint);
  hints["drive"] = belongsTo(link + "/joint/drive");
  for (const char* key : {"angle", "velocity"}) hints[key] = belongsTo(link + "/initial/" + key);
  hints["length"] = "no such key: pin, such as [1.0, 0.0] m, is where the next link is pinned";
  for (const char* key : {"parent", "children", "branch", "branches"}) {
    hints[key] = "no such key: branches are not supported (chain gives the order of the links)";
  }
  return hints;
}

Hints hintsAtTop() {
  Hints hints;
  for (const char* key : {"method", "tolerance", "step"})
    hints[key] = belongsTo("integrator/" + std::string(key));
  for (const char* key : {"rate", "tf_rate", "frame_prefix"})
    hints[key] = belongsTo("publish/" + std::string(key));
  for (const char* key : {"loop", "loops", "closure", "constraint", "constraints"}) {
    hints[key] = "no such key: a tip that is held closes a loop (see tip)";
  }
  for (const char* key : {"branch", "branches", "tree"})
    hints[key] = "no such key: branches are not supported";
  for (const char* key : {"contact", "contacts", "collision", "collisions"}) {
    hints[key] = "no such key: contacts are not supported";
  }
  return hints;
}

}  // namespace planar_chain
