#pragma once

/// A range of finite numbers, in words and as bounds.

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "planar_chain/fault.h"

namespace planar_chain {

/// Products of larger numbers may overflow.
constexpr double largestFactor = 1e100;
inline bool isFactor(double x) {
  return std::abs(x) <= largestFactor;
}
/// The words of a fault for an x that is not allowed: what is expected.
inline const char* factorInWords(double x) {
  return std::isfinite(x) ? "a number from -1e100 to 1e100" : "a finite number";
}

struct NumberRule {
  std::string which;  ///< such as " > 0 s"; follows "a number"
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool isLowIn = false;
  std::string most = {};  ///< follows `which` for numbers above `high`

  static NumberRule any(const std::string& unit) { return {" in " + unit}; }
  static NumberRule above(double low, const std::string& unit) {
    return {" > " + toText(low) + " " + unit, low};
  }
  static NumberRule from(double low, const std::string& unit) {
    NumberRule rule{" >= " + toText(low) + " " + unit, low};
    rule.isLowIn = true;
    return rule;
  }
  /// From 0 to largestFactor.
  static NumberRule coefficient(const std::string& unit) {
    NumberRule rule = from(0, unit);
    rule.high = largestFactor;
    rule.most = ", at most 1e100";
    return rule;
  }

  bool holds(double x) const { return std::isfinite(x) && (x > low || (isLowIn && x == low)) && x <= high; }
  /// "a number > 0 s"; for an infinite x "a finite number > 0 s"
  std::string inWords(double x) const {
    return (std::isinf(x) ? "a finite number" : "a number") + which + (x > high ? most : "");
  }
  /// Adds a fault unless x holds.
  void check(std::vector<Fault>& faults, const std::string& path, double x) const {
    if (!holds(x)) faults.push_back({path, inWords(x), toText(x)});
  }
};

}  // namespace planar_chain
