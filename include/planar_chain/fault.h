#pragma once

/// The faults of refused input, all reported at once. Each fault has a path, an expected value and the value
/// found. Accepted input may have notes.

#include <stdexcept>
#include <string>
#include <vector>

namespace planar_chain {

struct Fault {
  std::string path;      ///< from the root of the scene, such as "links/lower/mass"
  std::string expected;  ///< such as "a number > 0 kg"
  std::string found;     ///< as the user wrote it, such as "\"heavy\"", or "nothing"
  int line = 0;          ///< in the text that it came from, from 1 on; 0: unknown
  std::string file{};    ///< of that text; empty: unknown
};

/// "scene.yaml:4: links/lower/mass: expected a number > 0 kg, got \"heavy\"", without a file from "links" on
std::string toString(const Fault& fault);
/// All faults, by default on one line.
std::string toString(const std::vector<Fault>& faults, const char* between = "; ");

/// Thrown for input that is refused. what() has one line per fault. It keeps the first
/// 1000 faults; if there are more, it adds one that gives their number.
class Refused : public std::invalid_argument {
 public:
  explicit Refused(std::vector<Fault> faults);
  const std::vector<Fault>& faults() const noexcept { return faults_; }

 private:
  std::vector<Fault> faults_;
};

/// A property of accepted input that its author may not expect: an ignored element, or a default.
struct Note {
  std::string path;    ///< as in a Fault
  std::string text;    ///< such as "turns freely, as it has neither lower nor upper"
  int line = 0;        ///< as in a Fault
  int more = 0;        ///< the number of further places with this text
  std::string file{};  ///< as in a Fault
};

/// "robot.urdf: robot_description/joint[a]: turns freely, as it has neither lower nor upper (and 2 more)"
std::string toString(const Note& note);

/// Returns the notes that are not in `known`.
std::vector<Note> newNotes(const std::vector<Note>& notes, const std::vector<Note>& known);

// ---- Numbers and text in faults --------------------------------------------------------------------

/// The shortest decimal number that reads back as the same double: 15 to 17 digits, in any locale.
std::string toText(double number);

/// Longest text in a fault, bytes.
constexpr std::size_t longestShown = 80;
/// Cuts a longer text between two characters of UTF-8 and appends "…".
std::string cutToShow(std::string text);
/// As cutToShow, with a space for each control character.
std::string onOneLine(const std::string& text);
/// As onOneLine, in double quotes.
std::string quoted(const std::string& text);

}  // namespace planar_chain
