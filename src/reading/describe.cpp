/// A value as faults show it, and its line.

#include <sstream>

#include "planar_chain/fault.h"
#include "planar_chain/value.h"

namespace planar_chain {

namespace {

template <class Entries, class AppendOne>
void appendAll(std::string& line, const char* brackets, const Entries& entries, const AppendOne& appendOne) {
  line += brackets[0];
  for (const auto& entry : entries) {
    if (line.back() != brackets[0]) line += ", ";
    if (line.size() > longestShown) break;
    appendOne(entry);
  }
  line += brackets[1];
}

/// Appends a value. Stops soon after longestShown.
void append(std::string& line, const Value& value) {
  if (value.flag()) {
    line += *value.flag() ? "true" : "false";
  } else if (value.number()) {
    line += toText(*value.number());
  } else if (value.text()) {
    line += quoted(*value.text());
  } else if (value.oddNumber()) {
    line +=
        cutToShow(value.oddNumber()->text) + " (YAML readers disagree on this number: write it in decimal)";
  } else if (value.list()) {
    appendAll(line, "[]", *value.list(), [&line](const Value& entry) { append(line, entry); });
  } else if (value.map()) {
    appendAll(line, "{}", *value.map(), [&line](const Value::Map::value_type& entry) {
      line += onOneLine(entry.first) + ": ";
      append(line, entry.second);
    });
  } else {
    line += "nothing";
  }
}

}  // namespace

std::string describe(const Value& value) {
  std::string line;
  append(line, value);
  return value.list() || value.map() ? cutToShow(std::move(line)) : line;
}

std::string describe(const Value* value) {
  return value ? describe(*value) : "nothing";
}

int lineAt(const Value& root, const std::string& path) {
  const Value* at = &root;
  std::istringstream steps(path);
  for (std::string step; std::getline(steps, step, '/');) {
    const Value* next = nullptr;
    if (at->map() && at->map()->count(step) != 0) next = &at->map()->at(step);
    if (at->list() && !step.empty() && step.find_first_not_of("0123456789") == std::string::npos &&
        step.size() < 8) {
      const std::size_t i = std::stoul(step);
      if (i < at->list()->size()) next = &(*at->list())[i];
    }
    if (!next) break;
    at = next;
  }
  return at->line;
}

}  // namespace planar_chain
