#include "reading/section.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace planar_chain {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double noNumber = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t longestName = 64;

double unjudgedNumber(const Value& value) {
  const std::optional<double> number = numberIn(value);
  if (!number) return noNumber;
  return std::isfinite(*number) ? *number : infinity;
}

/// A number that came as text is shown as a number.
std::string found(const Value* value) {
  const std::string shown = describe(value);
  const bool isNumber = value && value->text() && numberIn(*value);
  return isNumber && shown == '"' + *value->text() + '"' ? *value->text() : shown;
}

bool isLetter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

}  // namespace

NumberRule NumberRule::any(const std::string& unit) {
  return {"in " + unit, -infinity, infinity, false};
}
NumberRule NumberRule::above(double low, const std::string& unit) {
  return {"> " + toText(low) + " " + unit, low, infinity, false};
}
NumberRule NumberRule::from(double low, const std::string& unit) {
  return {">= " + toText(low) + " " + unit, low, infinity, true};
}

const char* const nameInWords = "a name (a letter, then letters, digits and underscores, at most 64)";

bool isName(const std::string& text) {
  return !text.empty() && text.size() <= longestName && isLetter(text[0]) &&
         std::all_of(text.begin(), text.end(),
                     [](char c) { return isLetter(c) || (c >= '0' && c <= '9') || c == '_'; });
}

std::string stepOf(const std::string& key) {
  const std::string quoted = describe(Value(key));
  return quoted.substr(1, quoted.size() - 2);
}

Section::Section(const Value* value, std::string path, const std::vector<const char*>& known,
                 std::vector<Fault>& faults)
    : path_(std::move(path)), faults_(&faults) {
  static const Value::Map empty;
  map_ = value && value->map() ? value->map() : &empty;

  std::string names;
  for (const char* key : known) names += (names.empty() ? "" : ", ") + std::string(key);
  if (value && !value->map()) {
    const std::string keys = names.empty() ? "" : " with keys of: " + names;
    faults.push_back({path_.empty() ? "scene" : path_, "a map" + keys, describe(*value)});
  }
  if (known.size() == 0) return;
  for (const auto& entry : *map_) {
    const std::string& key = entry.first;
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      faults.push_back({pathOf(key), "one of the keys " + names, describe(Value(key))});
    }
  }
}

const Value* Section::find(const std::string& key) const {
  const auto entry = map_->find(key);
  return entry == map_->end() ? nullptr : &entry->second;
}

std::string Section::pathOf(const std::string& key) const {
  return path_.empty() ? stepOf(key) : path_ + "/" + stepOf(key);
}

void Section::fault(const std::string& key, const std::string& expected) const {
  faults_->push_back({pathOf(key), expected, found(find(key))});
}

double Section::unjudged(const std::string& key, double absent) const {
  const Value* value = find(key);
  return value ? unjudgedNumber(*value) : absent;
}

Vec2d Section::unjudged(const std::string& key, Vec2d absent) const {
  const Value* value = find(key);
  if (!value) return absent;
  const Value::List* list = value->list();
  if (!list || list->size() != 2) return {noNumber, noNumber};
  return {unjudgedNumber((*list)[0]), unjudgedNumber((*list)[1])};
}

bool Section::take(const std::string& key, const NumberRule& rule, double& target) const {
  if (!has(key)) return false;
  const double number = unjudged(key, noNumber);
  if (std::isfinite(number) && rule.holds(number)) {
    target = number;
    return true;
  }
  fault(key, (std::isinf(number) ? "a finite number " : "a number ") + rule.which);
  return false;
}

bool Section::take(const std::string& key, const char* unit, Vec2d& target) const {
  if (!has(key)) return false;
  const Vec2d pair = unjudged(key, Vec2d{});
  if (isFinite(pair)) {
    target = pair;
    return true;
  }
  fault(key, std::string("two finite numbers [x, y], in ") + unit);
  return false;
}

bool Section::take(const std::string& key, bool& target) const {
  const Value* value = find(key);
  if (!value) return false;
  if (value->flag()) {
    target = *value->flag();
    return true;
  }
  fault(key, "true or false");
  return false;
}

bool Section::takeName(const std::string& key, std::string& target) const {
  const Value* value = find(key);
  if (!value) return false;
  if (value->text() && isName(*value->text())) {
    target = *value->text();
    return true;
  }
  fault(key, nameInWords);
  return false;
}

bool Section::takeNumbers(const std::string& key, const char* unit, std::vector<double>& target) const {
  const Value* value = find(key);
  if (!value) return false;
  std::vector<double> numbers;
  if (value->list()) {
    for (const Value& entry : *value->list()) numbers.push_back(unjudgedNumber(entry));
  }
  const bool areSound =
      std::all_of(numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
  if (numbers.size() >= 2 && areSound) {
    target = std::move(numbers);
    return true;
  }
  fault(key, std::string("a list of two or more finite numbers, in ") + unit);
  return false;
}

}  // namespace planar_chain
