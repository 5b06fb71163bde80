#pragma once

/// What a simulation requires of what it is given.

#include <cmath>
#include <stdexcept>

#include "dynamics/given_state.h"
#include "planar_chain/motion_law.h"

namespace planar_chain {

inline void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

inline void requireContinuation(const MotionLaw& law, double t, double value, double rate) {
  const GivenMotion begin = law.at(t);
  require(
      law.isFinite() && std::abs(begin.value - value) <= givenTo && std::abs(begin.rate - rate) <= givenTo,
      "a law must be finite, and begin at the present value and rate");
}

}  // namespace planar_chain
