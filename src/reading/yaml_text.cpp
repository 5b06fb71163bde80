/// A tree of plain values as YAML, in the form of JSON.

#include <cstdio>

#include "planar_chain/value.h"

namespace planar_chain {

namespace {

void addQuoted(const std::string& text, std::string& to) {
  to += '"';
  for (const char each : text) {
    const auto code = static_cast<unsigned char>(each);
    if (each == '"' || each == '\\') {
      to += '\\';
      to += each;
    } else if (code < 0x20 || code == 0x7f) {
      char escape[8];
      std::snprintf(escape, sizeof escape, "\\u%04x", static_cast<unsigned>(code));
      to += escape;
    } else {
      to += each;
    }
  }
  to += '"';
}

void add(const Value& value, std::string& to) {
  if (const bool* flag = value.flag()) {
    to += *flag ? "true" : "false";
  } else if (const double* number = value.number()) {
    to += toText(*number);
  } else if (const std::string* text = value.text()) {
    addQuoted(*text, to);
  } else if (const Value::OddNumber* odd = value.oddNumber()) {
    to += odd->text;
  } else if (const Value::List* list = value.list()) {
    const char* before = "[";
    for (const Value& item : *list) {
      to += std::exchange(before, ", ");
      add(item, to);
    }
    to += list->empty() ? "[]" : "]";
  } else if (const Value::Map* map = value.map()) {
    const char* before = "{";
    for (const auto& [key, item] : *map) {
      to += std::exchange(before, ", ");
      addQuoted(key, to);
      to += ": ";
      add(item, to);
    }
    to += map->empty() ? "{}" : "}";
  } else {
    to += "null";
  }
}

}  // namespace

std::string toYaml(const Value& value) {
  std::string text;
  add(value, text);
  return text;
}

}  // namespace planar_chain
