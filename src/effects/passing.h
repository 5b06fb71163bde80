#pragma once

/// Where a switch may hide in a stretch of a step (ode/switches.h): what is due, as a polynomial g(s) for the
/// stretch 0 < s < 1, is not above 0 at both ends, but its top between them may be.
///
/// The curve that the polynomial stands for may rise above the ends by more than it, but not by twice as
/// much.

#include <algorithm>
#include <array>
#include <cmath>

namespace planar_chain {

/// True if a curve may be above 0 by more than `noise`, which is rounding. end: the higher end of the
/// polynomial, top: its top.
inline bool mayPass(double end, double top, double noise) {
  constexpr double most = 2;
  return end <= 0 && end + most * (top - end) > noise;
}

/// The g_0 … g_3 of the cubic through g and g' at 0 and 1.
inline std::array<double, 4> cubic(double g0, double slope0, double g1, double slope1) {
  return {g0, slope0, 3 * (g1 - g0) - 2 * slope0 - slope1, slope0 + slope1 - 2 * (g1 - g0)};
}

/// The s of the top at which g_0 + g_1 s + g_2 s² + g_3 s³ may pass; 1: nowhere.
inline double passing(const std::array<double, 4>& g, double noise) {
  // the root of the derivative where the second one is −2 root
  const double square = g[2] * g[2] - 3 * g[1] * g[3];
  const double s = g[1] / (std::sqrt(std::max(0.0, square)) - g[2]);
  if (!(square >= 0 && s > 0 && s < 1)) return 1;
  const double end = std::max(g[0], g[0] + g[1] + g[2] + g[3]);
  const double top = g[0] + s * (g[1] + s * (g[2] + s * g[3]));
  return mayPass(end, top, noise) ? s : 1;
}

/// The same of the parabola through g0, gm, g1 at 0, ½, 1, without noise.
inline double passing(double g0, double gm, double g1) {
  const bool risesAndFalls = 4 * gm > 3 * g0 + g1 && 4 * gm > g0 + 3 * g1;
  if (!risesAndFalls) return 1;
  const double bend = 2 * (g0 - 2 * gm + g1), slope = 4 * gm - 3 * g0 - g1;
  const double s = -slope / (2 * bend);
  return mayPass(std::max(g0, g1), g0 + s * (slope + s * bend), 0) ? s : 1;
}

}  // namespace planar_chain
