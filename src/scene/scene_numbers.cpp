#include "scene/scene_numbers.h"

#include <algorithm>
#include <sstream>
#include <utility>
#include <vector>

#include "planar_chain/scene_reader.h"

namespace planar_chain {

namespace {

/// The names in a path.
/// @throws Refused if one is empty, or if there are more than a scene has levels for: trees are recursive
std::vector<std::string> namesIn(const std::string& path) {
  std::vector<std::string> names;
  std::string meant;
  std::istringstream in(path + '/');
  for (std::string name; std::getline(in, name, '/');) {
    names.push_back(name);
    if (!name.empty()) meant += (meant.empty() ? "" : "/") + name;
  }
  if (names.size() >= mostLevels) {
    throw Refused({{onOneLine(path), "a path of at most " + std::to_string(mostLevels - 1) + " names",
                    std::to_string(names.size())}});
  }
  if (meant != path) {
    const std::string hint = meant.empty() ? "" : " (did you mean " + meant + "?)";
    throw Refused({{path, "no empty name in the path" + hint, "one"}});
  }
  return names;
}

/// The value at a path. Maps on the way are made.
Value& valueAt(Value& root, const std::string& path) {
  Value* at = &root;
  std::string above;
  for (const std::string& key : namesIn(path)) {
    if (at->isNull() && numberIn(key)) {
      throw Refused({{path, "a number of a list that the scene has", "nothing at " + quoted(above)}});
    }
    if (at->isNull()) *at = Value::Map{};
    const double number = numberIn(key).value_or(-1);
    if (Value::Map* map = at->map()) {
      at = &(*map)[key];
    } else if (Value::List* list = at->list();
               list && number >= 0 && number < static_cast<double>(list->size())) {
      at = &(*list)[static_cast<std::size_t>(number)];
    } else {
      throw Refused({{path, "a number of the scene", describe(*at) + " above " + quoted(key)}});
    }
    above += (above.empty() ? "" : "/") + key;
  }
  return *at;
}

/// True if `path` is `above` or lies below it.
bool isWithin(const std::string& path, const std::string& above) {
  return path.compare(0, above.size(), above) == 0 &&
         (path.size() == above.size() || path[above.size()] == '/');
}

/// Returns advice for a scene without such a number: a URDF has links of its own.
std::string remedyFor(const Value& scene, const std::string& path) {
  const bool isUrdf = scene.map() && scene.map()->count("robot_description") > 0;
  return isUrdf && isWithin(path, "links")
             ? " (the tools sweep and fit write a URDF out as links, whose numbers vary)"
             : "";
}

}  // namespace

std::optional<double> numberAt(const Value& scene, const std::string& path) {
  Value copy = scene;  // in which maps on the way are made
  return numberIn(valueAt(copy, path));
}

void setNumber(Value& scene, const std::string& path, double number) {
  valueAt(scene, path) = number;
}

namespace {

/// True for "no friction in a driven joint" and its like.
bool isExcluded(const Fault& fault) {
  return fault.expected.compare(0, 3, "no ") == 0;
}

}  // namespace

void requireNumbers(const Value& scene, const std::vector<std::string>& paths) {
  if (paths.empty()) return;

  // The scene with all these numbers. Those that it does not have are 1.
  Value complete = scene;
  std::vector<Fault> refused;
  std::vector<std::string> found;
  for (const std::string& path : paths) {
    try {
      Value& value = valueAt(complete, path);
      if (value.map() || value.list()) {
        throw Refused({{path, "the path of a number", value.map() ? "that of a map" : "that of a list"}});
      }
      if (!numberIn(value)) value = 1;
      found.push_back(path);
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
  for (const std::string& path : found) {
    const bool isNumber = numbers.count(path) > 0;
    const auto why = std::find_if(faults.begin(), faults.end(), [&](const Fault& fault) {
      return isWithin(path, fault.path) && !(isNumber && fault.path == path);
    });
    if (why != faults.end() && why->path == path && why->found == describe(Value(1)) && !isExcluded(*why)) {
      refused.push_back({path, "the path of a number", "that of " + why->expected});
    } else if (why != faults.end()) {
      refused.push_back({path, why->expected + remedyFor(scene, path), why->found});
    } else if (!isNumber) {
      refused.push_back({path, "a number of the scene", quoted(path)});
    }
  }
  // A key that is missing beside it, that it excludes, or that excludes it, is a fault as well.
  for (const Fault& fault : faults) {
    const auto isKnown = [&](const Fault& known) {
      return isWithin(known.path, fault.path.substr(0, fault.path.rfind('/')));
    };
    const bool isMissing = fault.found == describe(nullptr);
    if ((isMissing || isExcluded(fault)) && std::none_of(refused.begin(), refused.end(), isKnown))
      refused.push_back(fault);
  }
  if (!refused.empty()) throw Refused(std::move(refused));
}

}  // namespace planar_chain
