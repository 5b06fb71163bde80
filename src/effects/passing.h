#pragma once

/// Where a switch may hide in a stretch of a step (ode/switches.h): what is due, as a polynomial g(s) for the
/// stretch 0 < s < 1, is not above 0 at both ends, but its top between them may be.
///
/// The curve that the polynomial stands for may rise above the ends by more than it, but not by twice as
/// much.

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

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

/// What is due, and its derivative by s.
struct Due {
  double value, slope;
};

/// The same of the cubics through these at 0, ½ and 1, without noise.
inline double passing(const Due& begin, const Due& half, const Due& end) {
  if (half.value > 0 && end.value <= 0) return 0.5;
  const double early = passing(cubic(begin.value, begin.slope / 2, half.value, half.slope / 2), 0);
  const double late = passing(cubic(half.value, half.slope / 2, end.value, end.slope / 2), 0);
  return early < 1 ? early / 2 : (1 + late) / 2;
}

/// The same of the parabola through g0, gm, g1 at 0, ½, 1, without noise.
inline double passing(double g0, double gm, double g1) {
  const bool risesAndFalls = 4 * gm > 3 * g0 + g1 && 4 * gm > g0 + 3 * g1;
  if (!risesAndFalls) return 1;
  const double bend = 2 * (g0 - 2 * gm + g1), slope = 4 * gm - 3 * g0 - g1;
  const double s = -slope / (2 * bend);
  return mayPass(std::max(g0, g1), g0 + s * (slope + s * bend), 0) ? s : 1;
}

/// True if what is due may be above 0 within, so far as these three values tell: in most stretches it is not,
/// and that is known for little.
inline bool mayBeAbove(double g0, double gm, double g1) {
  constexpr double farther = 4;
  const auto [least, most] = std::minmax({g0, gm, g1});
  return most + farther * (most - least) > 0;
}

/// The Bézier points of a polynomial: it lies between the least and the largest.
using Bezier = std::array<double, 7>;

/// Of the one whose value, slope and second derivative are these at 0 and 1, and in which s³(1 − s)³ has this
/// coefficient.
inline Bezier bezier(const std::array<double, 3>& at0, const std::array<double, 3>& at1, double top) {
  const auto [g0, slope0, bend0] = at0;
  const auto [g1, slope1, bend1] = at1;
  const double quintic[] = {g0,
                            g0 + slope0 / 5,
                            g0 + 2 * slope0 / 5 + bend0 / 20,
                            g1 - 2 * slope1 / 5 + bend1 / 20,
                            g1 - slope1 / 5,
                            g1};
  Bezier b{g0};
  for (std::size_t k = 1; k < 6; ++k) {
    const double share = static_cast<double>(k) / 6;
    b[k] = share * quintic[k - 1] + (1 - share) * quintic[k];
  }
  b[6] = g1;
  b[3] += top / 20;
  return b;
}

/// Of its derivative, as one of the same degree.
inline Bezier slopeOf(const Bezier& g) {
  Bezier slope{};
  for (std::size_t k = 0; k < 7; ++k) {
    const double before = k > 0 ? g[k] - g[k - 1] : 0, after = k < 6 ? g[k + 1] - g[k] : 0;
    slope[k] = static_cast<double>(k) * before + static_cast<double>(6 - k) * after;
  }
  return slope;
}

/// Of both halves, by de Casteljau's algorithm.
inline std::pair<Bezier, Bezier> halves(const Bezier& g) {
  Bezier first = g, second = g;
  for (std::size_t k = 1; k < 7; ++k) {
    for (std::size_t j = 6; j >= k; --j) first[j] = (first[j - 1] + first[j]) / 2;
    for (std::size_t j = 0; j + k < 7; ++j) second[j] = (second[j] + second[j + 1]) / 2;
  }
  return {first, second};
}

/// A place where the polynomial is above `least`; 1: nowhere, or for less than 1/2^halvings.
inline double above(const Bezier& g, double least, int halvings = 14) {
  if (*std::max_element(g.begin(), g.end()) <= least) return 1;
  const auto& [first, second] = halves(g);
  if (second[0] > least) return 0.5;
  if (halvings == 0) return 1;
  if (const double s = above(first, least, halvings - 1); s < 1) return s / 2;
  const double s = above(second, least, halvings - 1);
  return s < 1 ? (1 + s) / 2 : 1;
}

/// The same before the place where the polynomial rises above 0 at last, if it is there at 1.
inline double aboveBefore(const Bezier& g, double least, int halvings = 6) {
  if (g[6] <= 0) return above(g, least);
  const double s = halvings > 0 ? aboveBefore(halves(g).first, least, halvings - 1) : 1;
  return s < 1 ? s / 2 : 1;
}

}  // namespace planar_chain
