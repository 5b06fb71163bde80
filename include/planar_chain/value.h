#pragma once

/// A tree of plain values: the input of the scene reader. It comes from a YAML text (parseYaml) or from ROS
/// parameters.
///
/// Both sources give the same tree, because plain scalars of a YAML text are resolved as by PyYAML
/// (YAML 1.1), which ROS uses: yes, no, on and off are bools, and 1e-3 is text because it has no dot. A text
/// that spells a decimal number counts as a number (numberIn).

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "planar_chain/fault.h"

namespace planar_chain {

class Value {
 public:
  using List = std::vector<Value>;
  /// Sorted by key, so that the order does not depend on the source.
  using Map = std::map<std::string, Value>;

  /// A number on which YAML readers disagree: 010 (octal 8), 0x10, 1_000, 1:30 (90). Only parseYaml makes it.
  /// It is always refused.
  struct OddNumber {
    std::string text;
  };

  Value() = default;  ///< null
  Value(bool flag) : content_(flag) {}
  Value(int number) : content_(static_cast<double>(number)) {}
  Value(double number) : content_(number) {}
  Value(const char* text) : content_(std::string(text)) {}
  Value(std::string text) : content_(std::move(text)) {}
  Value(OddNumber odd) : content_(std::move(odd)) {}
  Value(List list) : content_(std::move(list)) {}
  Value(Map map) : content_(std::move(map)) {}

  bool isNull() const { return std::holds_alternative<std::monostate>(content_); }
  const bool* flag() const { return std::get_if<bool>(&content_); }
  const double* number() const { return std::get_if<double>(&content_); }
  const std::string* text() const { return std::get_if<std::string>(&content_); }
  const OddNumber* oddNumber() const { return std::get_if<OddNumber>(&content_); }
  const List* list() const { return std::get_if<List>(&content_); }
  const Map* map() const { return std::get_if<Map>(&content_); }
  List* list() { return std::get_if<List>(&content_); }
  Map* map() { return std::get_if<Map>(&content_); }

  /// Line of the text that parseYaml() read, from 1 on; of an entry of a map that of its key. 0: from
  /// elsewhere.
  int line = 0;

 private:
  std::variant<std::monostate, bool, double, std::string, OddNumber, List, Map> content_;
};

/// The number that a text spells, in any locale: an optional sign, decimal digits with at most one dot, an
/// optional exponent; or nan, inf, .nan, .inf. A whole number has no leading zeros. A number too large for a
/// double is infinite.
std::optional<double> numberIn(const std::string& text);

/// The number that a value holds or, as text, spells.
std::optional<double> numberIn(const Value& value);

/// A value as faults show it: text in double quotes, a list as [1, 2, 3], null and an absent value (a null
/// pointer) as the word "nothing". It is on one line, and cut if it is long.
std::string describe(const Value& value);
std::string describe(const Value* value);

/// The line of the value at a path such as "links/lower/mass", or of the map or list where the path ends
/// before.
int lineAt(const Value& root, const std::string& path);

/// Longest YAML text, bytes. A scene that lists every link of the longest chain is shorter.
constexpr std::size_t longestYaml = 1 << 24;

/// The most levels of a tree: maps and lists within each other, and the value in the innermost.
constexpr std::size_t mostLevels = 16;

/// Parses one YAML document.
/// @throws Refused if the text is not YAML (with line and column) or has more than one document, keys that
/// are repeated or not text, explicit tags, more than mostLevels, more than a million values or more than
/// longestYaml bytes. Aliases count as often as they are used.
Value parseYaml(const std::string& text);

/// The YAML text of a tree, in the form of JSON. parseYaml() returns the same tree from it, but for the
/// lines.
std::string toYaml(const Value& value);

}  // namespace planar_chain
