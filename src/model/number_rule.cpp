#include "model/number_rule.h"

#include <cmath>
#include <limits>

namespace planar_chain {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

NumberRule NumberRule::any(const std::string& unit) {
  return {" in " + unit, -infinity, infinity, false};
}
NumberRule NumberRule::above(double low, const std::string& unit) {
  return {" > " + toText(low) + " " + unit, low, infinity, false};
}
NumberRule NumberRule::from(double low, const std::string& unit) {
  return {" >= " + toText(low) + " " + unit, low, infinity, true};
}

bool NumberRule::holds(double x) const {
  return std::isfinite(x) && (x > low || (isLowIn && x == low)) && x <= high;
}

std::string NumberRule::inWords(double x) const {
  return (std::isinf(x) ? "a finite number" : "a number") + which;
}

void NumberRule::check(std::vector<Fault>& faults, const std::string& path, double x) const {
  if (!holds(x)) faults.push_back({path, inWords(x), toText(x)});
}

}  // namespace planar_chain
