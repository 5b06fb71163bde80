#include "scene/scene_numbers.h"

#include <algorithm>
#include <sstream>
#include <utility>
#include <vector>

#include "planar_chain/scene_reader.h"

namespace planar_chain {

namespace {

/// Calls change(value) for the value at path[from…]. Maps on the way are made.
template <class Change>
void changeAt(Value& at, const std::string& path, const Change& change, std::size_t from = 0) {
  if (from > path.size()) return change(at);
  const std::string key = path.substr(from, path.find('/', from) - from);
  const auto below = [&](Value& value) { changeAt(value, path, change, from + key.size() + 1); };
  if (at.isNull() && numberIn(key)) {
    const std::string list = path.substr(0, from - 1);
    throw Refused({{path, "a number of a list that the scene has", "nothing at " + quoted(list)}});
  }
  if (at.isNull()) at = Value::Map{};
  if (Value::Map* map = at.map()) return below((*map)[key]);
  Value::List* list = at.list();
  const double place = numberIn(key).value_or(-1);
  if (!list || !(place >= 0 && place < static_cast<double>(list->size()))) {
    throw Refused({{path, "a number of the scene", describe(at) + " above " + quoted(key)}});
  }
  below((*list)[static_cast<std::size_t>(place)]);
}

/// The path without the empty names between slashes.
std::string withoutEmptyNames(const std::string& path) {
  std::string names;
  std::istringstream in(path);
  for (std::string name; std::getline(in, name, '/');) {
    if (!name.empty()) names += (names.empty() ? "" : "/") + name;
  }
  return names;
}

/// True if `path` is `above` or lies below it.
bool isWithin(const std::string& path, const std::string& above) {
  return path.compare(0, above.size(), above) == 0 &&
         (path.size() == above.size() || path[above.size()] == '/');
}

/// What to do where the scene has no such number: a URDF has links of its own.
std::string remedyFor(const Value& scene, const std::string& path) {
  const bool isUrdf = scene.map() && scene.map()->count("robot_description") > 0;
  return isUrdf && isWithin(path, "links")
             ? " (the tools sweep and fit write a URDF out as links, whose numbers vary)"
             : "";
}

}  // namespace

void setNumber(Value& scene, const std::string& path, double number) {
  changeAt(scene, path, [number](Value& value) { value = number; });
}

void requireNumbers(const Value& scene, const std::vector<std::string>& paths) {
  if (paths.empty()) return;

  // The scene with all these numbers. Those that it does not have are 1.
  Value complete = scene;
  std::vector<Fault> refused;
  std::vector<std::string> places;
  for (const std::string& path : paths) {
    const std::string names = withoutEmptyNames(path);
    if (names != path) {
      const std::string meant = names.empty() ? "" : " (did you mean " + names + "?)";
      refused.push_back({path, "no empty name in the path" + meant, "one"});
      continue;
    }
    try {
      changeAt(complete, path, [&path](Value& value) {
        if (value.map() || value.list()) {
          throw Refused({{path, "the path of a number", value.map() ? "that of a map" : "that of a list"}});
        }
        if (!numberIn(value)) value = 1;
      });
      places.push_back(path);
    } catch (const Refused& fault) {
      refused.insert(refused.end(), fault.faults().begin(), fault.faults().end());
    }
  }
  std::set<std::string> numbers;
  std::vector<Fault> faults;
  try {
    readSceneAndNote(complete, &numbers);
  } catch (const Refused& fault) {
    faults = fault.faults();
  }

  // A number has no fault above it, and is looked for. Other faults of its value may pass.
  for (const std::string& path : places) {
    const bool isNumber = numbers.count(path) > 0;
    const auto why = std::find_if(faults.begin(), faults.end(), [&](const Fault& fault) {
      return isWithin(path, fault.path) && !(isNumber && fault.path == path);
    });
    if (why != faults.end() && why->path == path && why->found == describe(Value(1))) {
      refused.push_back({path, "the path of a number", "that of " + why->expected});
    } else if (why != faults.end()) {
      refused.push_back({path, why->expected + remedyFor(scene, path), why->found});
    } else if (!isNumber) {
      refused.push_back({path, "a number of the scene", quoted(path)});
    }
  }
  // What is missing beside it, and what it excludes or is excluded by, is a fault as well.
  for (const Fault& fault : faults) {
    const auto isKnown = [&](const Fault& known) {
      return isWithin(known.path, fault.path.substr(0, fault.path.rfind('/')));
    };
    const bool isMissing = fault.found == describe(nullptr);
    const bool isExcluded = fault.expected.compare(0, 3, "no ") == 0;  // "no friction in a driven joint"
    if ((isMissing || isExcluded) && std::none_of(refused.begin(), refused.end(), isKnown))
      refused.push_back(fault);
  }
  if (!refused.empty()) throw Refused(std::move(refused));
}

}  // namespace planar_chain
