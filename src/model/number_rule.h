#pragma once

/// A range of finite numbers, in words and as bounds.

#include <string>
#include <vector>

#include "planar_chain/fault.h"

namespace planar_chain {

struct NumberRule {
  std::string which;  ///< such as " > 0 s"; follows "a number"
  double low;
  double high;
  bool isLowIn;

  static NumberRule any(const std::string& unit);
  static NumberRule above(double low, const std::string& unit);
  static NumberRule from(double low, const std::string& unit);

  bool holds(double x) const;
  /// "a number > 0 s"; for an infinite x "a finite number > 0 s"
  std::string inWords(double x) const;
  /// Adds a fault unless x holds.
  void check(std::vector<Fault>& faults, const std::string& path, double x) const;
};

}  // namespace planar_chain
