#pragma once

/// A tree of plain values: what a scene is before it is understood. One road leads here from YAML text
/// (parseYaml), another from ROS parameters; from here on there is one reader (scene_reader.h).
///
/// So that both roads give the same tree, plain scalars of a YAML text are resolved as ROS's own
/// reader, PyYAML (YAML 1.1), resolves them: yes, no, on, off are bools, and 1e-3, for want of a dot,
/// is text. In return, text that is wholly a decimal number counts as a number (numberIn).

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
  using Map = std::map<std::string, Value>;  ///< by key, so that the order is the same on every road

  /// A number as readers of YAML do not agree on it: 010 (octal 8), 0x10, 1_000, 1:30 (90). Only
  /// parseYaml makes it; nothing accepts it.
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

 private:
  std::variant<std::monostate, bool, double, std::string, OddNumber, List, Map> content_;
};

/// The number that a text spells, whatever the locale: an optional sign, decimal digits with at most one
/// dot, an optional exponent; or nan, inf, .nan, .inf. No leading zeros in a whole number. One too large
/// for a double is infinite.
std::optional<double> numberIn(const std::string& text);

/// The number that a value is or, as text, spells.
std::optional<double> numberIn(const Value& value);

/// How a value is shown to the one who wrote it: text in double quotes, [1, 2, 3], null as nothing; on
/// one line, and cut where it gets long.
std::string describe(const Value& value);

/// `value` may be null: absent.
std::string describe(const Value* value);

/// Bytes. A scene of every link that a chain may have is shorter.
constexpr std::size_t longestYaml = 1 << 24;

/// The tree of one YAML document.
/// @throws Refused what is not YAML (with line and column), more than one document, keys that are given
///   twice or are no text, explicit tags, more than 16 levels, more than a million values, more than
///   longestYaml bytes (aliases counted as often as they are used).
Value parseYaml(const std::string& text);

}  // namespace planar_chain
