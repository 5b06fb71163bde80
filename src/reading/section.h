#pragma once

/// Section: one map of a scene. It returns the values of its keys and records every fault with its full path.

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "model/number_rule.h"
#include "planar_chain/fault.h"
#include "planar_chain/planar.h"
#include "planar_chain/value.h"

namespace planar_chain {

/// A letter of ASCII, a digit or _.
bool isWordCharacter(char c);

/// True if ROS, TF and URDF accept the text as a name: a letter, then letters, digits, underscores; at
/// most 64.
bool isName(const std::string& text);
extern const char* const nameInWords;

/// "a, b, c"
template <class Names>
std::string inCommas(const Names& names) {
  std::string line;
  for (const auto& name : names) line += (line.empty() ? "" : ", ") + std::string(name);
  return line;
}

/// The expected part of a fault for a key that belongs elsewhere, by key.
using Hints = std::map<std::string, std::string>;
/// Makes them when a key is not known.
using MakeHints = std::function<Hints()>;

/// The hint at a key that belongs to this path.
inline std::string belongsTo(const std::string& path) {
  return "a known key (did you mean " + path + "?)";
}

/// " (…)": what to do if a text that should be a number is one with a unit, such as "1.0 kg", or with a
/// decimal comma; otherwise empty.
std::string numberNote(const std::string& text);

class Section {
 public:
  /// Reads `value` as a map. A null pointer (an absent key) counts as an empty map. Any other value is a
  /// fault. Keys other than `known` are faults. An empty `known` accepts every key. `numbers`, if given,
  /// collects the full path of each number that is looked for.
  Section(const Value* value, std::string path, const std::vector<const char*>& known,
          std::vector<Fault>& faults, std::set<std::string>* numbers = nullptr, const MakeHints& hints = {});

  /// The map below a key, with faults to the same list.
  Section section(const std::string& key, const std::vector<const char*>& known = {},
                  const MakeHints& hints = {}) const {
    return {find(key), pathOf(key), known, *faults_, numbers_, hints};
  }

  const Value::Map& entries() const { return *map_; }
  /// The value of a key. "motor/time_constant" is a key of the map `motor`.
  const Value* find(const std::string& key) const;
  bool has(const std::string& key) const { return find(key) != nullptr; }
  /// Full path of a key. "joint/name" is a key of a map of this one.
  std::string pathOf(const std::string& key) const;
  /// Records a fault: the key holds something other than `expected`, by default its value.
  void fault(const std::string& key, const std::string& expected) const;
  void fault(const std::string& key, const std::string& expected, const std::string& found) const {
    faults_->push_back({pathOf(key), expected, found});
  }

  // Numbers that the caller checks. A value that is not a number, or absent, gives NaN, one that is not
  // finite gives ∞.
  double uncheckedNumber(const std::string& key) const;
  Vec2d uncheckedPair(const std::string& key) const;

  // Values that are checked here. A faulty or absent value leaves `target` as it is.
  /// @returns true if the target was set
  bool take(const std::string& key, const NumberRule& rule, double& target) const;
  bool take(const std::string& key, const char* unit, Vec2d& target) const;
  bool take(const std::string& key, bool& target) const;
  bool takeText(const std::string& key, const std::function<bool(const std::string&)>& isAllowed,
                const std::string& expected, std::string& target) const;
  bool takeNumbers(const std::string& key, const char* unit, std::vector<double>& target) const;

 private:
  template <class T>
  bool accept(const std::string& key, const T* found, const std::string& expected, T& target) const;
  void lookFor(const std::string& path) const {
    if (numbers_) numbers_->insert(path);
  }
  /// Their numbers are looked for too.
  std::vector<double> uncheckedList(const std::string& key) const;

  const Value::Map* map_;
  std::string path_;
  std::vector<Fault>* faults_;
  std::set<std::string>* numbers_;
};

/// Takes `times` (s, strictly increasing, at least two) and as many `values`. Returns true if there is no
/// fault.
bool takeCurve(const Section& in, const char* unit, std::vector<double>& times, std::vector<double>& values);

}  // namespace planar_chain
