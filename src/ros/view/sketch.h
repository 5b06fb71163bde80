#pragma once

/// Flat figures in the plane of motion, as markers for rviz.

#include <std_msgs/ColorRGBA.h>
#include <visualization_msgs/MarkerArray.h>

#include <map>
#include <string>
#include <vector>

#include "planar_chain/planar.h"
#include "ros/messages/frames.h"

namespace planar_chain {

std_msgs::ColorRGBA colour(double red, double green, double blue, double alpha = 1);

class Sketch {
 public:
  /// At `height` (m) above the plane of `frame`, and moving with it: rviz draws it where that is by then.
  Sketch(const std::string& frame, const std::string& name, int id, double height);

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

/// One in each frame where there is something to draw.
class Sketches {
 public:
  static constexpr int base = -1;

  Sketches(Frames frames, std::string name, double height);

  void clear();
  /// That in the frame of a link, or of the base; in the axes of that frame.
  Sketch& on(int link);
  const visualization_msgs::MarkerArray& message(ros::Time stamp);

 private:
  Frames frames_;
  std::string name_;
  double height_;
  std::map<int, Sketch> sketches_;
  visualization_msgs::MarkerArray message_;
};

}  // namespace planar_chain
