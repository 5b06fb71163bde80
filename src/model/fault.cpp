#include "planar_chain/fault.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <locale>
#include <sstream>
#include <utility>

namespace planar_chain {

namespace {

constexpr std::size_t mostFaults = 1000;

std::vector<Fault>& shorten(std::vector<Fault>& faults) {
  if (faults.size() <= mostFaults) return faults;
  const std::string all = std::to_string(faults.size());
  faults.resize(mostFaults);
  faults.push_back({"input", "at most " + std::to_string(mostFaults) + " faults", all});
  return faults;
}

template <class Finding>
std::string locationOf(const Finding& finding) {
  if (finding.file.empty()) return finding.path;
  return finding.file + (finding.line > 0 ? ":" + std::to_string(finding.line) : "") + ": " + finding.path;
}

}  // namespace

std::string toString(const Note& note) {
  const std::string more = note.more > 0 ? " (and " + std::to_string(note.more) + " more)" : "";
  return locationOf(note) + ": " + note.text + more;
}

std::vector<Note> newNotes(const std::vector<Note>& notes, const std::vector<Note>& known) {
  std::vector<Note> others;
  std::copy_if(notes.begin(), notes.end(), std::back_inserter(others), [&](const Note& note) {
    return std::none_of(known.begin(), known.end(), [&](const Note& one) {
      return one.path == note.path && one.text == note.text && one.more == note.more;
    });
  });
  return others;
}

// ---- Numbers and text in faults -------------------------------------------------------------------

std::string toText(double number) {
  if (std::isnan(number)) return "nan";
  if (std::isinf(number)) return number > 0 ? "inf" : "-inf";
  constexpr double whole = 1e15;  // below it, 15 digits show every whole number
  if (std::abs(number) < whole && number == std::trunc(number) && std::signbit(number) == (number < 0))
    return std::to_string(static_cast<long long>(number));
  std::string text;
  for (int digits = 15; digits <= 17; ++digits) {
    std::stringstream stream;
    stream.imbue(std::locale::classic());
    stream.precision(digits);
    stream << number;
    text = stream.str();
    double back = 0;
    if (stream >> back && back == number) break;
  }
  return text;
}

std::string cutToShow(std::string text) {
  if (text.size() <= longestShown) return text;
  std::size_t end = longestShown;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end) + "…";
}

std::string onOneLine(const std::string& text) {
  std::string line = cutToShow(text);
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, ' ');
  return line;
}

std::string quoted(const std::string& text) {
  return '"' + onOneLine(text) + '"';
}

// ---- Faults ----------------------------------------------------------------------------------------

std::string toString(const Fault& fault) {
  return locationOf(fault) + ": expected " + fault.expected + ", got " + fault.found;
}

std::string toString(const std::vector<Fault>& faults, const char* between) {
  std::string text;
  for (const Fault& fault : faults) {
    if (!text.empty()) text += between;
    text += toString(fault);
  }
  return text;
}

Refused::Refused(std::vector<Fault> faults)
    : std::invalid_argument(toString(shorten(faults), "\n")), faults_(std::move(faults)) {}

}  // namespace planar_chain
