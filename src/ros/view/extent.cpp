#include "ros/view/extent.h"

#include <algorithm>
#include <cmath>

#include "ros/view/drawing.h"

namespace planar_chain {

namespace {

// Rails, in lengths of the chain:
constexpr double farLimit = 10;      // a limit farther away is not drawn
constexpr double freeLength = 2;     // of a side without a limit
constexpr double freeInside = 0.25;  // likewise, of a rail on a link that turns

// The view, as in show.py:
constexpr double margin = 1.25;  // from the first pin to the rim, in spans
constexpr double aspect = 1.27;  // its least width, in units of its height
constexpr int longChain = 16;    // links

struct Box {
  Vec2d low, high;  ///< m, base frame
};

/// Approximate: a spline may overshoot its points.
Range rangeOf(const MotionLaw& law) {
  const std::vector<MotionLaw::Piece>& pieces = law.pieces();
  const auto [least, most] = std::minmax_element(
      pieces.begin(), pieces.end(),
      [](const MotionLaw::Piece& a, const MotionLaw::Piece& b) { return a.c[0] < b.c[0]; });
  const double amplitude = std::fabs(law.amplitude());
  return {least->c[0] - amplitude, most->c[0] + amplitude};
}

/// Returns the box of the inner pin of the first link that turns.
Box rootOf(const Scene& scene, double links) {
  Box box;
  if (scene.base) {
    const Range x = rangeOf(scene.base->x), y = rangeOf(scene.base->y);
    box = {{x.from, y.from}, {x.to, y.to}};
  }
  const Range turns = scene.base ? rangeOf(scene.base->angle) : Range{0, 0};
  for (int i = 0; i < scene.chain.coordinates().leading() && !floats(scene.chain); ++i) {
    const Range rail = railOf(scene, i, links);
    const Vec2d axis = scene.chain.joints()[index(i)].axis;
    if (turns.from == 0 && turns.to == 0) {
      box.low +=
          {std::fmin(rail.from * axis.x, rail.to * axis.x), std::fmin(rail.from * axis.y, rail.to * axis.y)};
      box.high +=
          {std::fmax(rail.from * axis.x, rail.to * axis.x), std::fmax(rail.from * axis.y, rail.to * axis.y)};
    } else {
      const double most = std::fmax(std::fabs(rail.from), std::fabs(rail.to));
      box.low -= {most, most};
      box.high += {most, most};
    }
  }
  return box;
}

/// The largest initial height of a pin above the first pin of a link that turns, m.
double highest(const Scene& scene) {
  double angle = 0, height = 0, most = 0;
  for (std::size_t i = index(scene.chain.coordinates().leading()); i < scene.q.size(); ++i) {
    const Joint& joint = scene.chain.joints()[i];
    Vec2d pin = scene.chain.links()[i].pin;
    if (joint.isPrismatic) {
      pin += scene.q[i] * joint.axis;
    } else {
      angle += scene.q[i];
    }
    height += std::sin(angle) * pin.x + std::cos(angle) * pin.y;
    most = std::fmax(most, height);
  }
  return most;
}

}  // namespace

bool isInside(const Chain& chain, int joint) {
  return chain.coordinates().isPrismatic(joint) && joint >= chain.coordinates().leading();
}

Range railOf(const Scene& scene, int slider, double links) {
  const Joint& joint = scene.chain.joints()[index(slider)];
  Range range{scene.q[index(slider)], scene.q[index(slider)]};
  for (const Drive& drive : scene.drives) {
    if (drive.joint == slider) range = rangeOf(drive.law);
  }
  const bool ends = range.from - joint.lower <= farLimit * links;
  const bool endsAbove = joint.upper - range.to <= farLimit * links;
  const double free = links * (isInside(scene.chain, slider) ? freeInside : freeLength);
  return {ends ? std::fmin(joint.lower, range.from) : range.from - free,
          endsAbove ? std::fmax(joint.upper, range.to) : range.to + free};
}

double travelOf(const Scene& scene, int slider, double links) {
  const Range rail = railOf(scene, slider, links);
  return std::fmax(std::fabs(rail.from), std::fabs(rail.to));
}

Range lineOf(const Scene& scene, const Extent& extent) {
  const TipLaws& tip = *scene.tip;
  const Box root = rootOf(scene, extent.links);
  const Vec2d centre = 0.5 * (root.low + root.high) - Vec2d{tip.x.at(0).value, tip.y.at(0).value};
  const double radius = extent.reach + length(root.high - root.low) / 2, aside = cross(*tip.line, centre);
  const double half = std::sqrt(std::fmax(0, radius * radius - aside * aside));
  return {dot(*tip.line, centre) - half, dot(*tip.line, centre) + half};
}

Extent::Extent(const Scene& scene) {
  for (const Link& link : scene.chain.links()) links += std::fmax(length(link.pin), length(link.com));
  if (links == 0) links = 1;
  reach = links;
  for (int i = 0; i < scene.chain.size(); ++i) {
    if (isInside(scene.chain, i)) reach += travelOf(scene, i, links);
  }
  // The way from the ground pin over any pin to the tip is at most as long as the chain.
  const bool isPinned = scene.tip && !scene.tip->line && !scene.tip->moves() && !scene.base &&
                        scene.chain.coordinates().leading() == 0;
  if (isPinned) middle = 0.5 * Vec2d{scene.tip->x.at(0).value, scene.tip->y.at(0).value};
  span = isPinned ? reach / 2 : reach;

  const Box root = rootOf(scene, links);
  const double room = margin * span;
  const Vec2d low = root.low + middle - Vec2d{room, room};
  Vec2d high = root.high + middle + Vec2d{room, room};
  const Vec2d gravity = scene.chain.gravity();
  const bool falls = scene.loads.empty() && !scene.tip && gravity.x == 0 && gravity.y < 0 &&
                     std::all_of(scene.qd.begin(), scene.qd.end(), [](double rate) { return rate == 0; });
  if (scene.chain.size() > longChain && falls) high.y = root.high.y + highest(scene) + (margin - 1) * span;
  centre = 0.5 * (low + high);
  half = std::fmax((high.y - low.y) / 2, (high.x - low.x) / 2 / aspect);
}

}  // namespace planar_chain
