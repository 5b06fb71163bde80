#include "ros/view/sketch.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace planar_chain {

namespace {

constexpr double headLength = 4, headWidth = 3.2;  // widths of the arrow
constexpr double facet = 0.15;                     // rad: circles are drawn as polygons

Vec2d onCircle(Vec2d centre, double radius, double angle) {
  return centre + Rotation<double>::of(angle) * Vec2d{radius, 0};
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

Sketch::Sketch(const std::string& frame, const std::string& name, int id, double height) : height_(height) {
  marker_.header.frame_id = frame;
  marker_.frame_locked = true;
  marker_.id = id;
  marker_.ns = name;
  marker_.type = visualization_msgs::Marker::TRIANGLE_LIST;
  marker_.pose.orientation.w = 1;
  marker_.scale.x = marker_.scale.y = marker_.scale.z = 1;
  marker_.color = colour(1, 1, 1);
}

void Sketch::corner(Vec2d a, const Colour& paint) {
  geometry_msgs::Point point;
  point.x = a.x;
  point.y = a.y;
  point.z = height_;
  marker_.points.push_back(point);
  marker_.colors.push_back(paint);
}

void Sketch::band(Vec2d a, Vec2d b, double widthA, double widthB, const Colour& colourA,
                  const Colour& colourB) {
  const double l = length(b - a);
  if (l == 0) return;
  const Vec2d across = 0.5 / l * perp(b - a);
  const Vec2d a1 = a - widthA * across, a2 = a + widthA * across;
  const Vec2d b1 = b - widthB * across, b2 = b + widthB * across;
  corner(a1, colourA), corner(b1, colourB), corner(b2, colourB);
  corner(a1, colourA), corner(b2, colourB), corner(a2, colourA);
}

void Sketch::arrow(Vec2d from, Vec2d to, double width, const Colour& paint) {
  const double l = length(to - from);
  if (l == 0) return;
  // An arrow shorter than its head is drawn as a smaller head.
  const double head = std::fmin(headLength * width, l);
  const double size = head / (headLength * width);
  const Vec2d neck = to - head / l * (to - from);
  band(from, neck, size * width, size * width, paint, paint);
  band(neck, to, size * headWidth * width, 0, paint, paint);
}

void Sketch::turn(Vec2d centre, double radius, double from, double sweep, double width, const Colour& paint) {
  const double head = std::copysign(std::fmin(headLength * width / radius, std::fabs(sweep)), sweep);
  const double shaft = sweep - head;
  const int pieces = std::max(1, static_cast<int>(std::fabs(shaft) / facet));
  for (int k = 0; k < pieces; ++k) {
    band(onCircle(centre, radius, from + shaft * k / pieces),
         onCircle(centre, radius, from + shaft * (k + 1) / pieces), width, width, paint, paint);
  }
  band(onCircle(centre, radius, from + shaft), onCircle(centre, radius, from + sweep), headWidth * width, 0,
       paint, paint);
}

void Sketch::coil(Vec2d centre, double inner, double outer, double from, double sweep, double width,
                  const Colour& paint) {
  const int pieces = std::max(1, static_cast<int>(std::fabs(sweep) / (2 * facet)));
  const auto at = [&](int k) {
    return onCircle(centre, inner + (outer - inner) * k / pieces, from + sweep * k / pieces);
  };
  for (int k = 0; k < pieces; ++k) band(at(k), at(k + 1), width, width, paint, paint);
}

void Sketch::sector(Vec2d centre, double radius, double from, double sweep, const Colour& paint) {
  const int pieces = std::max(1, static_cast<int>(std::fabs(sweep) / facet));
  for (int k = 0; k < pieces; ++k) {
    corner(centre, paint);
    corner(onCircle(centre, radius, from + sweep * k / pieces), paint);
    corner(onCircle(centre, radius, from + sweep * (k + 1) / pieces), paint);
  }
}

const visualization_msgs::Marker& Sketch::message(ros::Time stamp) {
  marker_.header.stamp = stamp;
  marker_.action =
      marker_.points.empty() ? visualization_msgs::Marker::DELETE : visualization_msgs::Marker::ADD;
  return marker_;
}

Sketches::Sketches(Frames frames, std::string name, double height)
    : frames_(std::move(frames)), name_(std::move(name)), height_(height) {}

void Sketches::clear() {
  for (auto& [link, sketch] : sketches_) sketch.clear();
}

Sketch& Sketches::on(int link) {
  const std::string& frame = link == base ? frames_.base : frames_.links[index(link)];
  return sketches_.try_emplace(link, frame, name_, link, height_).first->second;
}

const visualization_msgs::MarkerArray& Sketches::message(ros::Time stamp) {
  message_.markers.clear();
  for (auto& [link, sketch] : sketches_) message_.markers.push_back(sketch.message(stamp));
  return message_;
}

}  // namespace planar_chain
