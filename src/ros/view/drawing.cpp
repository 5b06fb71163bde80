#include "ros/view/drawing.h"

#include <algorithm>
#include <cmath>

namespace planar_chain {

namespace {

constexpr double barWidth = 0.09;   // units
constexpr double leastBar = 0.016;  // reaches
constexpr double thin = 0.4;        // share of the width
constexpr int fewLinks = 8;         // a longer chain has units of an eighth of its reach
constexpr double fewWidths = 2;     // links shorter than this are short
constexpr double longest = 1.5;     // units, of an arrow
constexpr double beyond = 0.2;      // reaches, from the farthest points of the chain to the rim of the view

double largestLoad(const Scene& scene, double reach) {
  double largest = 0;
  for (const Load& load : scene.loads) {
    const double turning = std::fmax(std::fabs(load.moment), std::fabs(load.torque)) / reach;
    largest = std::fmax(largest, std::fmax(length(load.force), turning));
  }
  return largest;
}

/// True if the centre of mass is within half a width of the line through the pins.
bool isStraight(const Link& link, double width) {
  const double l = length(link.pin);
  return l > 0 ? std::fabs(cross(link.pin, link.com)) / l < width / 2 : length(link.com) < width / 2;
}

/// The length l of the uniform rod with this mass and moment of inertia I = m l²/12.
double rodLength(const Link& link) {
  return std::sqrt(12 * link.inertia / link.mass);
}

}  // namespace

Drawing::Drawing(const Scene& scene) : reach(0) {
  double mass = 0;
  for (const Link& link : scene.chain.links()) {
    reach += std::fmax(length(link.pin), length(link.com));
    mass += link.mass;
  }
  if (reach == 0) reach = 1;
  unit = reach / std::min(scene.chain.size(), fewLinks);
  bar = std::fmax(barWidth * unit, leastBar * reach);
  force = mass * length(scene.chain.gravity());
  if (force == 0) force = largestLoad(scene, reach);
  if (force == 0) force = 1;
  torque = force * reach / 2;
}

Vec2d Drawing::arrow(Vec2d f, Vec2d from) const {
  const double size = length(f);
  if (size == 0) return {};
  // Solve |from + room·f/|f|| = rim for the room, which is at least that of a stretched chain.
  const double along = dot(from, f) / size, rim = (1 + beyond) * reach;
  const double root = std::sqrt(std::fmax(0, along * along + rim * rim - dot(from, from)));
  const double room = std::fmax(beyond * reach, root - along);
  return std::fmin(unit / 2 * size / force, std::fmin(longest * unit, room)) / size * f;
}

bool isShort(const Link& link, const Drawing& drawing) {
  const double l = length(link.pin);
  return l > 0 && l < fewWidths * drawing.bar;
}

bool isPoint(const Link& link, const Drawing& drawing) {
  return !isShort(link, drawing) && isStraight(link, drawing.bar) && rodLength(link) < drawing.bar;
}

std::vector<Bar> barsOf(const Link& link, const Drawing& drawing) {
  const double l = length(link.pin);
  if (isShort(link, drawing)) return {{{}, link.pin}};
  const Bar pins{{}, link.pin, thin};
  if (!isStraight(link, drawing.bar)) return {{{}, link.com}, {link.com, link.pin}, pins};
  if (isPoint(link, drawing)) {
    // A bob beyond the outer pin hangs on a longer bar.
    return {dot(link.com, link.pin) > l * l || l == 0 ? Bar{{}, link.com, thin} : pins};
  }

  // Place the rod. If it spans the pins, it is the only bar.
  const Vec2d along = l > 0 ? 1 / l * link.pin : Vec2d{1, 0};
  const Vec2d half = rodLength(link) / 2 * along;
  const Bar rod{link.com - half, link.com + half};
  const bool spansThePins = length(rod.from) < drawing.bar / 2 && length(rod.to - link.pin) < drawing.bar / 2;
  if (spansThePins) return {{{}, link.pin}};
  return {rod, pins};
}

}  // namespace planar_chain
