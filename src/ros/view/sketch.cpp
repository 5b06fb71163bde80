#include "ros/view/sketch.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace planar_chain {

namespace {

using visualization_msgs::Marker;

constexpr double headLength = 4, headWidth = 3.2;  // widths of the arrow
constexpr double facet = 0.35;                     // rad: circles are drawn as polygons

Vec2d onCircle(Vec2d centre, double radius, double angle) {
  return centre + Rotation<double>::of(angle) * Vec2d{radius, 0};
}

int piecesOf(double sweep) {
  return std::max(1, static_cast<int>(std::fabs(sweep) / facet));
}

}  // namespace

Colour colour(double red, double green, double blue, double alpha) {
  Colour paint;
  paint.r = static_cast<float>(red);
  paint.g = static_cast<float>(green);
  paint.b = static_cast<float>(blue);
  paint.a = static_cast<float>(alpha);
  return paint;
}

Sketch::Sketch(Frames frames, std::string name, double height, double lineWidth)
    : frames_(std::move(frames)), name_(std::move(name)), height_(height), lineWidth_(lineWidth) {}

void Sketch::clear() {
  for (Marker& marker : message_.markers) marker.points.clear(), marker.colors.clear();
}

Sketch& Sketch::on(int link, const Pose& pose) {
  pose_ = pose;
  auto& markers = message_.markers;
  const auto found = std::find_if(markers.begin(), markers.end(),
                                  [link](const Marker& marker) { return marker.id == link; });
  current_ = static_cast<std::size_t>(found - markers.begin());
  if (found != markers.end()) return *this;
  Marker marker;
  marker.header.frame_id = frames_.of(link);
  marker.frame_locked = true;
  marker.id = link;
  marker.ns = name_;
  marker.type = lineWidth_ > 0 ? Marker::LINE_STRIP : Marker::TRIANGLE_LIST;
  marker.pose.orientation.w = 1;
  marker.scale.x = lineWidth_ > 0 ? lineWidth_ : 1;
  marker.scale.y = marker.scale.z = 1;
  marker.color = colour(1, 1, 1, lineWidth_ > 0 ? 0.99 : 1);  // below 1 lines may be transparent
  markers.push_back(marker);
  return *this;
}

void Sketch::corner(Vec2d a, const Colour& paint) {
  geometry_msgs::Point point;
  copy(pose_.origin + pose_.turn * a, point);
  point.z = height_;
  message_.markers[current_].points.push_back(point);
  message_.markers[current_].colors.push_back(paint);
}

void Sketch::band(Vec2d a, Vec2d b, double widthA, double widthB, const Colour& paint) {
  const double l = length(b - a);
  if (l == 0) return;
  const Vec2d across = 0.5 / l * perp(b - a);
  const Vec2d a1 = a - widthA * across, a2 = a + widthA * across;
  const Vec2d b1 = b - widthB * across, b2 = b + widthB * across;
  for (const Vec2d& point : {a1, b1, b2, a1, b2, a2}) corner(point, paint);
}

void Sketch::zigzag(Vec2d a, Vec2d b, double swing, int turns, double width, const Colour& paint) {
  const double l = length(b - a);
  if (l == 0) return;
  const Vec2d across = swing / l * perp(b - a);
  const int corners = 2 * turns;
  Vec2d from = a;
  for (int k = 1; k <= corners; ++k) {
    const double side = k == corners ? 0 : k % 2 == 0 ? -1 : 1;
    const Vec2d to = a + static_cast<double>(k) / corners * (b - a) + side * across;
    band(from, to, width, width, paint);
    from = to;
  }
}

void Sketch::arrow(Vec2d from, Vec2d to, double width, const Colour& paint) {
  const double l = length(to - from);
  if (l == 0) return;
  // An arrow shorter than its head is drawn as a smaller head.
  const double head = std::fmin(headLength * width, l);
  const double size = head / (headLength * width);
  const Vec2d neck = to - head / l * (to - from);
  band(from, neck, size * width, size * width, paint);
  band(neck, to, size * headWidth * width, 0, paint);
}

void Sketch::turn(Vec2d centre, double radius, double sweep, double width, const Colour& paint) {
  const double head = std::copysign(std::fmin(headLength * width / radius, std::fabs(sweep)), sweep);
  const double from = -sweep / 2, neck = from + sweep - head;
  coil(centre, radius, radius, from, sweep - head, width, paint);
  band(onCircle(centre, radius, neck), onCircle(centre, radius, from + sweep), headWidth * width, 0, paint);
}

void Sketch::coil(Vec2d centre, double inner, double outer, double from, double sweep, double width,
                  const Colour& paint) {
  const int pieces = piecesOf(sweep);
  const auto at = [&](int k) {
    return onCircle(centre, inner + (outer - inner) * k / pieces, from + sweep * k / pieces);
  };
  for (int k = 0; k < pieces; ++k) band(at(k), at(k + 1), width, width, paint);
}

void Sketch::sector(Vec2d centre, double radius, double from, double sweep, const Colour& paint) {
  const int pieces = piecesOf(sweep);
  for (int k = 0; k < pieces; ++k) {
    corner(centre, paint);
    corner(onCircle(centre, radius, from + sweep * k / pieces), paint);
    corner(onCircle(centre, radius, from + sweep * (k + 1) / pieces), paint);
  }
}

visualization_msgs::MarkerArray& Sketch::message(ros::Time stamp) {
  for (Marker& marker : message_.markers) {
    marker.header.stamp = stamp;
    marker.action = marker.points.empty() ? Marker::DELETE : Marker::ADD;
  }
  return message_;
}

}  // namespace planar_chain
