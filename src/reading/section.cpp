#include "reading/section.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "reading/names.h"

namespace planar_chain {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double noNumber = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t longestName = 64;

double unchecked(const Value& value) {
  const std::optional<double> number = numberIn(value);
  if (!number) return noNumber;
  return std::isfinite(*number) ? *number : infinity;
}

/// The value as the fault shows it: a number spelt as text is shown without quotes.
std::string found(const Value* value) {
  const std::string shown = describe(value);
  const bool isNumber = value && value->text() && numberIn(*value);
  return isNumber && shown == '"' + *value->text() + '"' ? *value->text() : shown;
}

const char* const pointNote = " (a decimal point, not a comma?)";

/// True for [0,5, 1,5], which YAML reads as four numbers. [0,5, 1] may be a vector of space.
bool isPairWithCommas(const Value::List& list) {
  const auto isWhole = [](const Value& entry) { return std::floor(unchecked(entry)) == unchecked(entry); };
  return list.size() == 4 && std::all_of(list.begin(), list.end(), isWhole);
}

std::string noteOn(const Value* value) {
  if (value && value->text()) return numberNote(*value->text());
  if (!value || !value->list()) return "";
  std::string note = isPairWithCommas(*value->list()) ? pointNote : "";
  for (const Value& entry : *value->list()) {
    if (note.empty()) note = noteOn(&entry);
  }
  return note;
}

bool isLetter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

}  // namespace

const char* const nameInWords = "a name (a letter, then letters, digits and underscores, at most 64)";

bool isWordCharacter(char c) {
  return isLetter(c) || (c >= '0' && c <= '9') || c == '_';
}

bool isName(const std::string& text) {
  return !text.empty() && text.size() <= longestName && isLetter(text[0]) &&
         std::all_of(text.begin(), text.end(), isWordCharacter);
}

std::string numberNote(const std::string& text) {
  const std::size_t comma = text.find(',');
  if (comma != std::string::npos && numberIn(std::string(text).replace(comma, 1, "."))) return pointNote;
  if (numberIn(text.substr(0, text.find(';'))) && !numberIn(text)) {
    return " (points within numbers, commas between them?)";
  }
  const std::size_t end = std::min(text.find_first_not_of("+-.0123456789"), text.size());
  const std::string unit = text.substr(std::min(text.find_first_not_of(' ', end), text.size()));
  const bool isLetters = !unit.empty() && (isLetter(unit[0]) || static_cast<unsigned char>(unit[0]) >= 0x80);
  const bool isUnit = isLetters && unit[0] != 'x' && numberIn(text.substr(0, end)) && !numberIn(text);
  return isUnit ? " (write the number alone: units are not written)" : "";
}

Section::Section(const Value* value, std::string path, const std::vector<const char*>& known,
                 std::vector<Fault>& faults, std::set<std::string>* numbers, const MakeHints& makeHints)
    : path_(std::move(path)), faults_(&faults), numbers_(numbers) {
  static const Value::Map empty;
  map_ = value && value->map() ? value->map() : &empty;

  if (value && !value->map()) {
    const std::string keys = known.empty() ? "" : " with keys of: " + inCommas(known);
    faults.push_back({path_.empty() ? "scene" : path_, "a map" + keys, describe(*value)});
  }
  for (const auto& [key, entry] : *map_) {
    const bool isKnown = known.empty() || std::find(known.begin(), known.end(), key) != known.end();
    if (isKnown) continue;
    const Hints hints = makeHints ? makeHints() : Hints();
    const auto hint = hints.find(key);
    const std::string meant = closest(key, {known.begin(), known.end()});
    fault(key,
          hint != hints.end() ? hint->second
          : meant.empty()     ? "one of the keys " + inCommas(known)
                              : belongsTo(pathOf(meant)),
          quoted(key));
  }
}

const Value* Section::find(const std::string& key) const {
  const auto entry = map_->find(key);
  if (entry != map_->end()) return &entry->second;
  const std::size_t slash = key.find('/');
  const auto outer = slash == std::string::npos ? map_->end() : map_->find(key.substr(0, slash));
  if (outer == map_->end() || !outer->second.map()) return nullptr;
  const auto inner = outer->second.map()->find(key.substr(slash + 1));
  return inner == outer->second.map()->end() ? nullptr : &inner->second;
}

std::string Section::pathOf(const std::string& key) const {
  return (path_.empty() ? "" : path_ + "/") + onOneLine(key);
}

void Section::fault(const std::string& key, const std::string& expected) const {
  const bool isNumeric = expected.find("number") != std::string::npos;
  fault(key, expected, found(find(key)) + (isNumeric ? noteOn(find(key)) : ""));
}

double Section::uncheckedNumber(const std::string& key) const {
  lookFor(pathOf(key));
  return has(key) ? unchecked(*find(key)) : noNumber;
}

std::vector<double> Section::uncheckedList(const std::string& key) const {
  std::vector<double> numbers;
  const Value* value = find(key);
  if (!value || !value->list()) return numbers;
  for (const Value& entry : *value->list()) {
    lookFor(pathOf(key) + "/" + std::to_string(numbers.size()));
    numbers.push_back(unchecked(entry));
  }
  return numbers;
}

Vec2d Section::uncheckedPair(const std::string& key) const {
  const std::vector<double> numbers = uncheckedList(key);
  return numbers.size() == 2 ? Vec2d{numbers[0], numbers[1]} : Vec2d{noNumber, noNumber};
}

/// Sets the target to the value found. Without one, records a fault if the key is there.
template <class T>
bool Section::accept(const std::string& key, const T* found, const std::string& expected, T& target) const {
  if (found) {
    target = *found;
  } else if (has(key)) {
    fault(key, expected);
  }
  return found;
}

bool Section::take(const std::string& key, const NumberRule& rule, double& target) const {
  const double number = uncheckedNumber(key);
  return accept(key, rule.holds(number) ? &number : nullptr, rule.inWords(number), target);
}

bool Section::take(const std::string& key, const char* unit, Vec2d& target) const {
  const Vec2d pair = uncheckedPair(key);
  return accept(key, isFinite(pair) ? &pair : nullptr, std::string("two finite numbers [x, y], in ") + unit,
                target);
}

bool Section::take(const std::string& key, bool& target) const {
  const Value* value = find(key);
  return accept(key, value ? value->flag() : nullptr, "true or false", target);
}

bool Section::takeText(const std::string& key, const std::function<bool(const std::string&)>& isAllowed,
                       const std::string& expected, std::string& target) const {
  const Value* value = find(key);
  const std::string* text = value ? value->text() : nullptr;
  return accept(key, text && isAllowed(*text) ? text : nullptr, expected, target);
}

bool Section::takeNumbers(const std::string& key, const char* unit, std::vector<double>& target) const {
  const std::vector<double> numbers = uncheckedList(key);
  const bool areSound = numbers.size() >= 2 && std::all_of(numbers.begin(), numbers.end(), [](double number) {
                          return std::isfinite(number);
                        });
  return accept(key, areSound ? &numbers : nullptr,
                std::string("a list of two or more finite numbers, in ") + unit, target);
}

bool takeCurve(const Section& in, const char* unit, std::vector<double>& times, std::vector<double>& values) {
  if (!in.has("times")) in.fault("times", "a list of times, as there are values");
  if (!in.has("values")) in.fault("values", "a list of values, as there are times");
  const bool hasTimes = in.takeNumbers("times", "s", times);
  const bool hasValues = in.takeNumbers("values", unit, values);
  const bool increase = std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) == times.end();
  const bool match = times.size() == values.size();
  if (hasTimes && !increase) in.fault("times", "times that increase strictly");
  if (hasTimes && hasValues && !match) {
    in.fault("values", std::to_string(times.size()) + " numbers, as many as times");
  }
  return hasTimes && hasValues && increase && match;
}

}  // namespace planar_chain
