#pragma once

/// Loosens the tolerance while ticks are late (integrator/loosest_tolerance). If they stay late, recommends
/// changes.
///
/// The load of a tick is the wall time that it takes over the time that it has. A tolerance ten times looser
/// lowers it to between 0.56 (rodas5p) and 0.9 of its value.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "ode/methods.h"
#include "planar_chain/scene.h"

namespace planar_chain {

/// Multiplies the tolerance by ten when ticks are late, and divides it by ten after enough time without late
/// ticks. This time doubles when the division was too early.
class ToleranceControl {
 public:
  ToleranceControl(double wanted, double loosest) : wanted_(wanted), loosest_(loosest), tolerance_(wanted) {}

  /// Call after each tick. delay: s of wall time since the next one was due, negative if it is not yet;
  /// period: s of wall time of a tick. Returns the tolerance for the next.
  double after(double load, double delay, double period) {
    calm_ = delay > 0 ? 0 : calm_ + period;
    busy_ = delay > 0 ? 0 : busy_ + load * period;
    sinceTaken_ += period;
    if (delay > late && load > full && tolerance_ < loosest_) {
      if (sinceTaken_ < patience_) patience_ = std::min(2 * patience_, longest);
      return change(std::min(10 * tolerance_, loosest_));
    }
    if (calm_ > patience_ && busy_ < light * calm_ && tolerance_ > wanted_) {
      sinceTaken_ = 0;
      return change(std::max(tolerance_ / 10, wanted_));
    }
    return tolerance_;
  }

 private:
  static constexpr double late = 0.01;  // s: less is the operating system's
  static constexpr double full = 0.8, light = 0.4;
  static constexpr double shortest = 1, longest = 60;  // s

  double change(double tolerance) {
    calm_ = busy_ = 0;
    return tolerance_ = tolerance;
  }

  double wanted_, loosest_, tolerance_;
  double calm_ = 0, busy_ = 0;   ///< s since the last late tick or change, and of these at work
  double patience_ = shortest;   ///< s
  double sinceTaken_ = longest;  ///< s since the tolerance was last taken back
};

/// Returns advice that keeps ticks of `period` s of wall time in time, if their load is above 1. steps: of a
/// tick; tolerance: the one in force.
inline std::string adviceFor(const IntegratorSettings& settings, double tolerance, double load, double steps,
                             double period, double rate) {
  constexpr double single = 1.5, order = 5;
  char took[100], help[200];
  std::snprintf(took, sizeof took, "a tick of %.3g ms takes %.3g ms, with %.3g step%s: ", 1e3 * period,
                1e3 * period * load, steps, steps == 1 ? "" : "s");
  const double needed = tolerance * std::pow(load, order);
  if (load < 1) {
    std::snprintf(help, sizeof help, "it catches up");
  } else if (steps < single) {
    std::snprintf(help, sizeof help, "publish/rate of at most %.3g Hz would help", rate / load);
  } else if (ode::hasFixedStep(settings.method)) {
    std::snprintf(help, sizeof help, "integrator/step of at least %.2g s would help", settings.step * load);
  } else if (needed > 1) {
    std::snprintf(help, sizeof help,
                  "no tolerance is loose enough; real_time_factor of at most %.2g would help", 1 / load);
  } else if (settings.loosestTolerance) {
    std::snprintf(help, sizeof help, "integrator/loosest_tolerance of about %.0e would help", needed);
  } else {
    std::snprintf(
        help, sizeof help,
        "a tolerance of about %.0e would help%s; with integrator/loosest_tolerance it yields to that "
        "only while it must",
        needed, settings.rateTolerance ? ", or a larger rate_tolerance" : "");
  }
  return std::string(took) + help;
}

}  // namespace planar_chain
