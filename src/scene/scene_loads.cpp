#include "scene/scene_loads.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "reading/section.h"

namespace planar_chain {

namespace {

using Indices = std::map<std::string, int>;

/// "a link of the chain (upper, lower)"
std::string oneOf(const char* what, const Indices& names) {
  constexpr std::size_t longest = 80;
  std::string line;
  for (const auto& entry : names) {
    if (line.size() > longest) {
      line += ", …";
      break;
    }
    line += (line.empty() ? "" : ", ") + entry.first;
  }
  return std::string("a ") + what + " of the chain (" + line + ")";
}

/// The index of what `key` names, or Load::none.
int takeReference(const Section& load, const std::string& key, const Indices* names) {
  const Value* value = load.find(key);
  if (!value || !names) return Load::none;
  const auto entry = value->text() ? names->find(*value->text()) : names->end();
  if (entry != names->end()) return entry->second;
  load.fault(key, oneOf(key.c_str(), *names));
  return Load::none;
}

/// What acts, and on what.
void takeAction(const Section& in, const ChainNames* names, Load& load) {
  load.link = takeReference(in, "link", names ? &names->links : nullptr);
  load.joint = takeReference(in, "joint", names ? &names->joints : nullptr);
  if (names && load.link != Load::none) {
    load.point = names->com[static_cast<std::size_t>(load.link)];
  }
  in.take("force", "N", load.force);
  in.take("point", "m", load.point);
  in.take("moment", NumberRule::any("N m"), load.moment);
  in.take("torque", NumberRule::any("N m"), load.torque);

  const bool actsOnLink = in.has("force") || in.has("moment");
  if (in.has("link") && !actsOnLink) in.fault("force", "force or moment, as there is a link");
  if (in.has("point") && !in.has("force") && (actsOnLink || !in.has("link"))) {
    in.fault("force", "a force, as there is a point");
  }
  if (actsOnLink && !in.has("link")) in.fault("link", "the link on which force or moment acts");
  if (in.has("joint") && !in.has("torque")) in.fault("torque", "a torque, as there is a joint");
  if (in.has("torque") && !in.has("joint")) in.fault("joint", "the joint in which the torque acts");
  if (!in.has("link") && !in.has("joint") && !actsOnLink && !in.has("point") && !in.has("torque")) {
    in.fault("link", "a link with force or moment, or a joint with torque");
  }
}

TimeLaw takeSine(const Section& in) {
  Sine sine;
  in.take("frequency", NumberRule::any("Hz"), sine.frequency);
  in.take("phase", NumberRule::any("rad"), sine.phase);
  return sine;
}

TimeLaw takeRamp(const Section& in) {
  Ramp ramp;
  if (!in.has("times")) in.fault("times", "a list of times, as there are values");
  if (!in.has("values")) in.fault("values", "a list of values, as there are times");
  const bool hasTimes = in.takeNumbers("times", "s", ramp.times);
  const bool hasValues = in.takeNumbers("values", "no unit: factors", ramp.values);
  const auto notLater = std::greater_equal<>();
  if (hasTimes && std::adjacent_find(ramp.times.begin(), ramp.times.end(), notLater) != ramp.times.end()) {
    in.fault("times", "times that increase strictly");
  }
  if (hasTimes && hasValues && ramp.times.size() != ramp.values.size()) {
    in.fault("values", std::to_string(ramp.times.size()) + " numbers, as many as times");
  }
  return ramp;
}

void takeTimeLaw(const Section& in, Load& load) {
  const bool isRamp = in.has("times") || in.has("values");
  const bool isSine = in.has("frequency");
  if (isRamp && isSine) in.fault("frequency", "no frequency beside times and values");
  if (in.has("phase") && !isSine) in.fault("frequency", "a frequency, as there is a phase");
  if (isSine || in.has("phase")) load.law = takeSine(in);
  if (isRamp) load.law = takeRamp(in);

  in.take("start", NumberRule::from(0, "s"), load.start);
  in.take("stop", NumberRule::above(load.start, "s, the start"), load.stop);
}

}  // namespace

std::vector<Load> readLoads(const Value* value, const ChainNames* names, std::vector<Fault>& faults) {
  const Section all(value, "loads", {}, faults);
  std::vector<Load> loads;
  for (const auto& [name, entry] : all.entries()) {
    if (!isName(name)) faults.push_back({all.pathOf(name), nameInWords, describe(Value(name))});
    const Section in(&entry, all.pathOf(name),
                     {"link", "force", "point", "moment", "joint", "torque", "frequency", "phase", "times",
                      "values", "start", "stop"},
                     faults);
    if (!entry.map()) continue;
    Load load;
    load.name = name;
    takeAction(in, names, load);
    takeTimeLaw(in, load);
    loads.push_back(std::move(load));
  }
  return loads;
}

}  // namespace planar_chain
