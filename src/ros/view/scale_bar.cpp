#include "ros/view/scale_bar.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "ros/view/sketch.h"

namespace planar_chain {

namespace {

using visualization_msgs::Marker;

// In units of half the height of the view.
constexpr double longest = 1 / 3.75;  // a cell of the grid (src/tools/show.py)
constexpr double right = 1.2, bottom = -0.95, thickness = 0.012, tick = 0.04, textSize = 0.055;

constexpr double shortInMetres = 0.1;  // m: a shorter bar has its length in mm

/// The largest of 1, 2 or 5 times a power of ten that is at most this.
double roundedDown(double length) {
  const double power = std::pow(10, std::floor(std::log10(length)));
  return (5 * power <= length ? 5 : 2 * power <= length ? 2 : 1) * power;
}

}  // namespace

ScaleBar::ScaleBar(const Extent& view, const Frames& frames, int link) {
  const double length = roundedDown(longest * view.half), half = view.half;
  const Colour paint = colour(0.85, 0.88, 0.92);
  const Vec2d to = view.centre + half * Vec2d{right, bottom}, from = to - Vec2d{length, 0};
  Sketch sketch(frames, "scale", 0);
  sketch.on(link).band(from, to, thickness * half, thickness * half, paint);
  for (const Vec2d end : {from, to}) {
    const Vec2d up{0, tick / 2 * half};
    sketch.band(end - up, end + up, thickness * half, thickness * half, paint);
  }
  message_ = sketch.message(ros::Time());

  std::array<char, 32> text{};
  const bool isShort = length < shortInMetres;
  std::snprintf(text.data(), text.size(), isShort ? "%g mm" : "%g m", isShort ? 1000 * length : length);
  Marker words;
  words.header.frame_id = frames.of(link);
  words.frame_locked = true;
  words.ns = "scale";
  words.id = link + 1;
  words.type = Marker::TEXT_VIEW_FACING;
  words.text = text.data();
  copy(0.5 * (from + to) + Vec2d{0, (tick / 2 + textSize / 2) * half}, words.pose.position);
  words.pose.orientation.w = 1;
  words.scale.z = textSize * half;
  words.color = paint;
  message_.markers.push_back(words);
}

visualization_msgs::MarkerArray& ScaleBar::message(ros::Time stamp) {
  for (Marker& marker : message_.markers) marker.header.stamp = stamp;
  return message_;
}

}  // namespace planar_chain
