#include "scene/effect_values.h"

#include <set>
#include <string>

namespace planar_chain {

Joint withStop(Joint joint) {
  if (joint.isLimited()) joint.stopStiffness = 1;
  return joint;
}

std::vector<NumberKey> numberKeys(std::vector<NumberKey> (EffectKind::*of)() const) {
  std::vector<NumberKey> all;
  for (const EffectKind* kind : effectKinds()) {
    for (const NumberKey& key : (kind->*of)()) all.push_back(key);
  }
  return all;
}

void takeNumbers(const Section& in, const std::vector<NumberKey>& keys, NamedNumbers& to) {
  for (const NumberKey& key : keys) {
    double value = 0;
    if (in.has(key.name) && in.take(key.name, key.range, value)) to.set(key.name, value);
  }
}

void takeEffects(const Section& in, Joint& joint) {
  std::set<std::string> refused;
  for (const EffectKind* kind : effectKinds()) {
    for (const JointKey& key : kind->jointKeys()) {
      double value = 0;
      if (!in.take(key.name, {key.range.which}, value)) {
        if (in.has(key.name)) refused.insert(key.name);
      } else if (key.member) {
        joint.*key.member = value;
      } else {
        joint.others.set(key.name, value);  // in place of the URDF's
      }
    }
  }
  for (const Fault& fault : faultsOf(in.has("stop_stiffness") ? joint : withStop(joint))) {
    const std::string key = fault.path.substr(fault.path.find('/') + 1);
    if (refused.insert(key).second) in.fault(key, fault.expected);
  }
  if (refused.empty()) return;
  Joint plain{joint.name};
  plain.slides = joint.slides;
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

}  // namespace planar_chain
