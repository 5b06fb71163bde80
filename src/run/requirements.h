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
      law.isModerate() && std::abs(begin.value - value) <= givenTo && std::abs(begin.rate - rate) <= givenTo,
      "a law must begin at the present value and rate, and must not jump: accelerations up to 1e15 per s²");
}

}  // namespace planar_chain
