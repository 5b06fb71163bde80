#pragma once

/// Requirements of a simulation on its input.

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include "dynamics/given_state.h"
#include "effects/commands.h"
#include "model/number_rule.h"
#include "planar_chain/motion_law.h"
#include "planar_chain/scene.h"

namespace planar_chain {

inline void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

inline Eigen::VectorXd vectorOf(const std::vector<double>& numbers) {
  return Eigen::VectorXd::Map(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

inline void requireContinuation(const MotionLaw& law, double t, double value, double rate) {
  const GivenMotion begin = law.at(t);
  require(
      law.isModerate() && std::abs(begin.value - value) <= givenTo && std::abs(begin.rate - rate) <= givenTo,
      "a law must begin at the present value and rate, and must not jump: accelerations up to 1e15 per s²");
}

inline void requireOf(const Command& command, const Scene& scene, double present, bool isTimed) {
  const int body = std::max(command.joint, command.link);
  require(body >= 0 && body < scene.chain.size(), "a command must name a joint or link of the chain");
  for (const Drive& drive : scene.drives) {
    require(drive.joint != command.joint, "no torque can be commanded in a driven joint: its angle is given");
  }
  // So the moment of the force about a pin is finite at any angle.
  const double given[] = {command.torque,  command.moment,  command.point.x,
                          command.point.y, command.force.x, command.force.y};
  require(std::all_of(std::begin(given), std::end(given), isFactor),
          "the torque, force, point and moment of a command must be numbers from -1e100 to 1e100");
  require(std::isfinite(command.start), "the start of a command must be finite");
  require(isTimed ? std::isfinite(command.stop) : !std::isnan(command.stop),
          isTimed ? "the duration of a command must be finite" : "the end of a command must be a time");
  require(command.stop > command.start, "a command must end after it starts");
  require(command.stop > present, "a command must end after the present time");
}

}  // namespace planar_chain
