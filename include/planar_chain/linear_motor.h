#pragma once

namespace planar_chain {

/// The commanded torque of a joint near its present value: u → lag → x → torque (src/effects/motors.h).
struct LinearMotor {
  int joint = 0;
  double lag = 0;         ///< T, s; 0: none
  bool isCutOff = false;  ///< u is beyond the effort limit, so δu changes nothing
  bool isFree = true;     ///< the torque is x; if not, the torque-speed line bounds it
  double damping = 0;     ///< of the line, N m s/rad
};

}  // namespace planar_chain
