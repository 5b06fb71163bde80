#include "planar_chain/value.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <locale>
#include <sstream>
#include <utility>

#include "planar_chain/fault.h"

namespace planar_chain {

namespace {

constexpr std::size_t mostValues = 1000000;

bool isDigit(char c) {
  return c >= '0' && c <= '9';
}

bool isOneOf(const std::string& text, std::initializer_list<const char*> words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

}  // namespace

// ---- Numbers in text -------------------------------------------------------------------------

std::optional<double> numberIn(const std::string& text) {
  const double sign = text[0] == '-' ? -1 : 1, infinity = std::numeric_limits<double>::infinity();
  const std::string bare = text.substr(text[0] == '-' || text[0] == '+' ? 1 : 0);
  if (isOneOf(bare, {".nan", ".NaN", ".NAN", "nan", "NaN", "NAN"})) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  if (isOneOf(bare, {".inf", ".Inf", ".INF", "inf", "Inf", "INF"})) return sign * infinity;

  // A stream reads the rest, except whole numbers with leading zeros. It fails where it finds no number,
  // which it then sets to 0, and where the number is too large.
  const bool isWhole = bare.find('.') == std::string::npos;
  if (bare.find_first_not_of("0123456789.eE+-") != std::string::npos) return std::nullopt;
  if (isWhole && bare[0] == '0' && isDigit(bare[1])) return std::nullopt;
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  double number = 0;
  in >> number;
  if (!in.eof() || (in.fail() && number == 0)) return std::nullopt;
  return in.fail() ? sign * infinity : number;
}

std::optional<double> numberIn(const Value& value) {
  if (value.number()) return *value.number();
  if (value.text()) return numberIn(*value.text());
  return std::nullopt;
}

// ---- YAML ------------------------------------------------------------------------------------

namespace {

[[noreturn]] void refuse(std::string path, std::string expected, std::string found, int line = 0) {
  throw Refused({{std::move(path), std::move(expected), std::move(found), line}});
}

std::string notTooLong() {
  return "at most " + std::to_string(longestYaml) + " bytes";
}

std::string notTooMany() {
  return "at most " + std::to_string(mostValues) + " values in all";
}

/// Refuses a text that is too large for any scene. The parser would take some 200 bytes for each of the
/// characters counted here.
void requireBounds(const std::string& text) {
  if (text.size() > longestYaml) refuse("scene", notTooLong(), std::to_string(text.size()));
  const auto marks = std::count_if(text.begin(), text.end(), [](char c) {
    return c == '[' || c == '{' || c == ',' || c == ':' || c == '?';
  });
  if (static_cast<std::size_t>(marks) > mostValues) {
    refuse("scene", notTooMany(), "a text with " + std::to_string(marks) + " of [ { , : ?");
  }
}

/// Between brackets, yaml-cpp 0.6 never ends at a colon before ] or the end (to it also '\4'), but at one
/// before a space.
std::string spaced(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    result += text[i];
    const char next = i + 1 < text.size() ? text[i + 1] : '\4';
    if (text[i] == ':' && (next == ']' || next == '\4')) result += ' ';
  }
  return result;
}

int lineOf(const YAML::Mark& mark) {
  return mark.line + 1;
}

std::string lineAndColumn(const YAML::Mark& mark) {
  return "line " + std::to_string(lineOf(mark)) + ", column " + std::to_string(mark.column + 1);
}

/// True if a line, from 1 on, or the one before, is indented with a tab.
bool hasTab(const std::string& text, int line) {
  std::istringstream in(text);
  std::string each;
  for (int i = 1; i <= line && std::getline(in, each); ++i) {
    const std::string indent = each.substr(0, each.find_first_not_of(" \t"));
    if (i + 1 >= line && indent.find('\t') != std::string::npos) return true;
  }
  return false;
}

/// True for a whole number in PyYAML's grammar but not in the decimal one: 010, 0x1F, 0b1, 1_000, 1:30.
bool isOddNumber(const std::string& text) {
  const std::string bare = text.substr(text[0] == '+' || text[0] == '-' ? 1 : 0);
  if (!isDigit(bare[0]) || numberIn(text)) return false;
  if (bare.compare(0, 2, "0x") == 0 || bare.compare(0, 2, "0b") == 0) {
    return bare.find_first_not_of("0123456789abcdefABCDEF_", 2) == std::string::npos;
  }
  if (bare.find_first_not_of("0123456789_:.") != std::string::npos) return false;
  return bare.find_first_of("_:") != std::string::npos || bare.find('.') == std::string::npos;
}

/// Resolves a plain scalar as PyYAML does. A PyYAML number that is not whole has a dot, and its exponent has
/// a sign. Other spellings stay text, which may count as a number later (numberIn).
Value resolve(const std::string& text) {
  if (isOneOf(text, {"", "~", "null", "Null", "NULL"})) return Value();
  if (isOneOf(text, {"true", "True", "TRUE", "yes", "Yes", "YES", "on", "On", "ON"})) return true;
  if (isOneOf(text, {"false", "False", "FALSE", "no", "No", "NO", "off", "Off", "OFF"})) return false;
  if (isOddNumber(text)) return Value::OddNumber{text};
  const std::optional<double> number = numberIn(text);
  if (!number) return text;
  const std::size_t exponent = text.find_first_of("eE");
  const bool isDouble = text.find('.') == std::string::npos
                            ? exponent == std::string::npos && std::isfinite(*number)
                            : exponent == std::string::npos || !std::isfinite(*number) ||
                                  text[exponent + 1] == '+' || text[exponent + 1] == '-';
  return isDouble ? Value(*number) : Value(text);
}

/// Builds the tree from the parser's events. Faults are recorded and parsing continues: if the text turns out
/// not to be YAML, that is the one fault to report. Only a text that is too large ends the parsing.
class Builder : public YAML::EventHandler {
 public:
  Value root;
  std::vector<Fault> faults;

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { OnScalar(mark, "?", anchor, ""); }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    const bool isPlain = tag == "?";
    if (!isPlain) requireNoTag(mark, tag);
    Counted scalar{isPlain ? resolve(text) : Value(text), text.size()};
    count(mark, scalar);
    insert(mark, anchor, std::move(scalar), isPlain);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto known = anchored_.find(anchor);
    if (known == anchored_.end()) {
      refuseHere("an alias of a complete value", "one", mark);
      return insert(mark, 0, {}, false);
    }
    count(mark, known->second);
    insert(mark, 0, known->second, false);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, Value(Value::List()));
  }
  void OnSequenceEnd() override { close(); }

  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, Value(Value::Map()));
  }
  void OnMapEnd() override { close(); }

 private:
  /// A value with the number of bytes, of values and of levels in it.
  struct Counted {
    Value value;
    std::size_t bytes = 0;
    std::size_t values = 1;
    std::size_t levels = 1;
  };

  /// A list or map whose end has not been parsed yet.
  struct Open {
    Counted tree;
    YAML::Mark mark;
    YAML::anchor_t anchor = 0;
    std::optional<std::string> key = {};
    int keyLine = 0;
    std::string digits = {};  ///< the key, if it is a number
    std::string before = {};  ///< the last key that has its value
    bool merges = false;      ///< the key is a plain <<
    bool hasMerged = false;   ///< there was one
    Value::Map merged = {};   ///< the keys from <<; the map's own keys take precedence
  };

  std::string path() const {
    std::string line;
    for (const Open& level : open_) {
      const std::string step =
          level.tree.value.list() ? std::to_string(level.tree.value.list()->size()) : level.key.value_or("");
      if (!step.empty()) line += (line.empty() ? "" : "/") + onOneLine(step);
    }
    return line.empty() ? "scene" : line;
  }

  void refuseHere(const std::string& expected, const std::string& found, const YAML::Mark& mark) {
    faults.push_back({path(), expected, found + " in " + lineAndColumn(mark), lineOf(mark)});
  }

  void requireNoTag(const YAML::Mark& mark, const std::string& tag) {
    if (tag.empty() || tag == "?" || tag == "!") return;
    refuseHere("a value without a tag", onOneLine(tag), mark);
  }

  void count(const YAML::Mark& mark, const Counted& tree) {
    const auto refuseMore = [&](const std::string& most) {
      refuse(path(), most, "more in " + lineAndColumn(mark), lineOf(mark));
    };
    bytes_ += tree.bytes;
    values_ += tree.values;
    if (open_.size() + tree.levels > mostLevels)
      refuseMore("at most " + std::to_string(mostLevels) + " levels");
    if (values_ > mostValues) refuseMore(notTooMany());
    if (bytes_ > longestYaml) refuseMore(notTooLong());
  }

  void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, Value empty) {
    requireNoTag(mark, tag);
    count(mark, {});
    open_.push_back({{std::move(empty)}, mark, anchor});
  }

  void close() {
    Open level = std::move(open_.back());
    open_.pop_back();
    if (level.tree.value.map()) level.tree.value.map()->merge(level.merged);
    insert(level.mark, level.anchor, std::move(level.tree), false);
  }

  /// Inserts a complete value: as the root, a list's next entry, a map's key or value.
  void insert(const YAML::Mark& mark, YAML::anchor_t anchor, Counted tree, bool isPlain) {
    if (anchor != 0) anchored_[anchor] = tree;
    tree.value.line = lineOf(mark);
    if (open_.empty()) {
      root = std::move(tree.value);
      return;
    }
    Open& level = open_.back();
    if (level.tree.value.map() && !level.key) return takeKey(mark, level, tree.value, isPlain);
    level.tree.bytes += tree.bytes;
    level.tree.values += tree.values;
    level.tree.levels = std::max(level.tree.levels, tree.levels + 1);
    if (level.tree.value.list()) {
      level.tree.value.list()->push_back(std::move(tree.value));
      return;
    }
    tree.value.line = level.keyLine;
    if (level.merges) {
      merge(mark, level, tree.value);
    } else if (!tree.value.isNull() || !joinDecimals(level)) {
      level.tree.value.map()->emplace(*level.key, std::move(tree.value));
      level.before = *level.key;
    }
    level.key.reset();
  }

  void takeKey(const YAML::Mark& mark, Open& level, const Value& key, bool isPlain) {
    if (!key.text()) refuseHere("text as a key", describe(key), mark);
    level.keyLine = lineOf(mark);
    level.digits = key.oddNumber() ? key.oddNumber()->text : key.number() ? toText(*key.number()) : "";
    level.key = key.text() ? *key.text() : describe(key);
    level.merges = isPlain && *level.key == "<<";
    const bool isRepeated = level.merges && std::exchange(level.hasMerged, true);
    if (isRepeated || level.tree.value.map()->count(*level.key) != 0)
      refuseHere("each key once", "it again", mark);
  }

  /// Between braces, YAML reads "mass: 0,3" as mass: 0 and a key 3 without a value. Makes that the text 0,3
  /// again, which is no number: the fault is that of the number, and not of the key.
  bool joinDecimals(Open& level) {
    const auto whole = level.tree.value.map()->find(level.before);
    if (level.digits.empty() || whole == level.tree.value.map()->end() || !whole->second.number())
      return false;
    Value text(describe(whole->second) + "," + level.digits);
    text.line = whole->second.line;
    whole->second = std::move(text);
    faults.pop_back();
    return true;
  }

  /// << takes a map or a list of maps. The first map with a key sets its value.
  void merge(const YAML::Mark& mark, Open& level, const Value& source) {
    const Value::List one{source};
    for (const Value& each : source.list() ? *source.list() : one) {
      if (each.map()) {
        level.merged.insert(each.map()->begin(), each.map()->end());
      } else {
        refuseHere("a map or a list of maps", describe(each), mark);
      }
    }
  }

  std::vector<Open> open_;
  std::map<YAML::anchor_t, Counted> anchored_;
  std::size_t bytes_ = 0;
  std::size_t values_ = 0;
};

}  // namespace

Value parseYaml(const std::string& text) {
  requireBounds(text);
  try {
    std::istringstream in(spaced(text));
    YAML::Parser parser(in);
    Builder first;
    parser.HandleNextDocument(first);
    Builder second;
    if (parser.HandleNextDocument(second)) refuse("scene", "one YAML document", "more");
    if (!first.faults.empty()) throw Refused(std::move(first.faults));
    return std::move(first.root);
  } catch (const YAML::Exception& error) {
    const int line = lineOf(error.mark);
    const std::string why =
        hasTab(text, line)                             ? "a tab, where YAML is indented with spaces"
        : error.msg == YAML::ErrorMsg::END_OF_MAP      ? "a line that does not begin below the keys before it"
        : error.msg == YAML::ErrorMsg::END_OF_MAP_FLOW ? "a { without its }"
        : error.msg == YAML::ErrorMsg::MAP_VALUE
            ? "a key within the value of another (a line too far in, or no space behind a colon?)"
            : onOneLine(error.msg);
    refuse("scene", "YAML", lineAndColumn(error.mark) + ": " + why, line);
  }
}

}  // namespace planar_chain
