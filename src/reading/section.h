#pragma once

/// A map of the scene that is being read: hands out its keys as what they should be, and notes every
/// fault with its full path. Internal to the reader.

#include <string>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/planar.h"
#include "planar_chain/value.h"

namespace planar_chain {

/// A range of finite numbers in words and in figures.
struct NumberRule {
  std::string which;  ///< such as "> 0 s"; reads on from "a number "
  double low;
  double high;
  bool isLowIn;

  bool holds(double x) const { return (x > low || (isLowIn && x == low)) && x <= high; }

  static NumberRule any(const std::string& unit);
  static NumberRule above(double low, const std::string& unit);
  static NumberRule from(double low, const std::string& unit);
};

/// What becomes a name in ROS, TF and URDF: a letter, then letters, digits, underscores; at most 64.
bool isName(const std::string& text);
extern const char* const nameInWords;

/// A key or name as part of a path, which is one line of decent length.
std::string stepOf(const std::string& key);

class Section {
 public:
  /// The map at `value`; absent (null pointer) is an empty one, anything else is a fault. Keys other than
  /// `known` are faults; an empty `known` admits every key.
  Section(const Value* value, std::string path, const std::vector<const char*>& known,
          std::vector<Fault>& faults);

  const Value::Map& entries() const { return *map_; }
  const Value* find(const std::string& key) const;
  bool has(const std::string& key) const { return find(key) != nullptr; }
  /// Full path of a key, or, as "joint/name", of a key of a map of this one.
  std::string pathOf(const std::string& key) const;
  /// Notes that the key is not what was expected. Found is what stands there.
  void fault(const std::string& key, const std::string& expected) const;

  // Numbers whose range somebody else judges (faultsOf): what is no number comes as NaN, and a number
  // that is not finite as ∞. The absent ones come as given.
  double unjudged(const std::string& key, double absent) const;
  Vec2d unjudged(const std::string& key, Vec2d absent) const;

  // Judged here. A faulty or absent value leaves `target` alone.
  /// @returns whether the target was set
  bool take(const std::string& key, const NumberRule& rule, double& target) const;
  bool take(const std::string& key, const char* unit, Vec2d& target) const;
  bool take(const std::string& key, bool& target) const;
  bool takeName(const std::string& key, std::string& target) const;
  bool takeNumbers(const std::string& key, const char* unit, std::vector<double>& target) const;

 private:
  const Value::Map* map_;
  std::string path_;
  std::vector<Fault>* faults_;
};

}  // namespace planar_chain
