#pragma once

/// Flat figures in the plane of motion, as one marker for rviz.

#include <std_msgs/ColorRGBA.h>
#include <visualization_msgs/Marker.h>

#include <string>

#include "planar_chain/planar.h"

namespace planar_chain {

std_msgs::ColorRGBA colour(double red, double green, double blue, double alpha = 1);

class Sketch {
 public:
  /// At `height` (m) above the plane of `frame`.
  Sketch(const std::string& frame, const std::string& name, double height);

  void clear() { marker_.points.clear(), marker_.colors.clear(); }
  /// A band from a to b, which may fade and taper. Widths in m.
  void band(Vec2d a, Vec2d b, double widthA, double widthB, const std_msgs::ColorRGBA& colourA,
            const std_msgs::ColorRGBA& colourB);
  void arrow(Vec2d from, Vec2d to, double width, const std_msgs::ColorRGBA& paint);
  /// An arrow on a circle, from angle `from` on by `sweep` (rad, either sign).
  void turn(Vec2d centre, double radius, double from, double sweep, double width,
            const std_msgs::ColorRGBA& paint);
  /// A spiral from the inner radius to the outer one.
  void coil(Vec2d centre, double inner, double outer, double from, double sweep, double width,
            const std_msgs::ColorRGBA& paint);
  /// Part of a disc, as turn().
  void sector(Vec2d centre, double radius, double from, double sweep, const std_msgs::ColorRGBA& paint);

  /// What was drawn since clear(); one that takes the last away, if that is nothing.
  const visualization_msgs::Marker& message(ros::Time stamp);

 private:
  void corner(Vec2d a, const std_msgs::ColorRGBA& paint);

  double height_;
  visualization_msgs::Marker marker_;
};

}  // namespace planar_chain
