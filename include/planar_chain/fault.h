#pragma once

/// How input is refused: every fault at once, each with its path, what was expected, what was
/// found.

#include <stdexcept>
#include <string>
#include <vector>

namespace planar_chain {

struct Fault {
  std::string path;      ///< from the scene's root, such as "links/lower/mass"
  std::string expected;  ///< such as "a number > 0 kg"
  std::string found;     ///< as the user wrote it, such as "\"heavy\"" or "nothing"
};

/// "links/lower/mass: expected a number > 0 kg, got \"heavy\""
std::string toString(const Fault& fault);
/// All of them, in one line if nothing else is said.
std::string toString(const std::vector<Fault>& faults, const char* between = "; ");

/// Thrown by whatever takes input from outside. what() has one line a fault. Of more than 1000 it keeps the
/// first 1000, and one more that says how many there were.
class Refused : public std::invalid_argument {
 public:
  explicit Refused(std::vector<Fault> faults);
  const std::vector<Fault>& faults() const noexcept { return faults_; }

 private:
  std::vector<Fault> faults_;
};

// ---- How a fault shows what was found --------------------------------------------------------------

/// The shortest decimal number that reads back as the same double: 15 to 17 digits, in any locale.
std::string toText(double number);

/// A longer text is cut behind so many bytes, between two characters of UTF-8, and ends with "…".
constexpr std::size_t longestShown = 80;
std::string cutToShow(std::string text);
/// The same with a space in place of each control character.
std::string onOneLine(const std::string& text);
/// The same in double quotes.
std::string quoted(const std::string& text);

}  // namespace planar_chain
