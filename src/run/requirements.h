#pragma once

/// What a simulation requires of what it is given.

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "planar_chain/motion_law.h"

namespace planar_chain {

constexpr double givenTo = 1e-6;  // rad, rad/s: how closely a state must repeat what is given

inline void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

inline void requireContinuation(const MotionLaw& law, double t, double value, double rate) {
  const GivenMotion begin = law.at(t);
  require(
      law.isFinite() && std::abs(begin.value - value) <= givenTo && std::abs(begin.rate - rate) <= givenTo,
      "a law must be finite, and begin at the present value and rate");
}

inline bool allFinite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

}  // namespace planar_chain
