#pragma once

/// Events of a motion that a caller wants to know: zeros of functions of time and state, with the conventions
/// of scipy.integrate.solve_ivp().

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace planar_chain {

/// An event happens where g passes 0, or reaches it. g is continuous along the motion.
struct MotionEvent {
  /// t: s; q: relative angles, rad, not wrapped; qd: their rates, rad/s.
  std::function<double(double t, const std::vector<double>& q, const std::vector<double>& qd)> g;
  long long terminal = 0;  ///< ends the way at the event of this number; 0: at none
  int direction = 0;       ///< > 0: only where g rises; < 0: only where it falls
};

struct FoundEvent {
  std::size_t which;  ///< of the events
  double t;           ///< s
  std::vector<double> q, qd;
};

/// What happened on a way.
struct FoundEvents {
  std::vector<FoundEvent> all{};          ///< in the order of time
  std::optional<std::size_t> terminal{};  ///< whose event ended the way
  /// For the next call, at this time: the signs of the functions where the way ended; 0: unknown.
  double t = 0;
  long long timesSet = 0;
  std::vector<int> signs{};
};

}  // namespace planar_chain
