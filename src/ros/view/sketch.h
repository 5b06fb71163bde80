#pragma once

/// Flat figures in the plane of motion, as rviz markers.

#include <std_msgs/ColorRGBA.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "planar_chain/planar.h"
#include "ros/messages/frames.h"

namespace planar_chain {

/// Sets x and y of a point, vector or pose.
template <class Message>
void copy(Vec2d from, Message& to) {
  to.x = from.x;
  to.y = from.y;
}

using Colour = std_msgs::ColorRGBA;

/// Each component is in 0 … 1.
Colour colour(double red, double green, double blue, double alpha = 1);

/// The pose of a link frame in the base frame.
struct Pose {
  Vec2d origin;  ///< m
  Rotation<double> turn;
};

/// One marker of triangles, or one line, per frame that has figures. Lengths in m, angles in rad, coordinates
/// in the axes of the frame.
class Sketch {
 public:
  static constexpr int base = -1;

  /// The figures lie at `height` (m) above the plane. With a lineWidth (m) corners are joined by a line.
  Sketch(Frames frames, std::string name, double height, double lineWidth = 0);

  void clear();
  /// From here on draws in the frame of a link, or of the base. The first call for a link allocates its
  /// marker. pose: of the coordinates that follow, in that frame.
  Sketch& on(int link, const Pose& pose = {});
  /// A corner of a triangle, or of the line.
  void corner(Vec2d a, const Colour& paint);
  /// A band from a to b. The width changes linearly.
  void band(Vec2d a, Vec2d b, double widthA, double widthB, const Colour& paint);
  /// Bands from a to b that swing by `swing` to both sides, as often.
  void zigzag(Vec2d a, Vec2d b, double swing, int turns, double width, const Colour& paint);
  void arrow(Vec2d from, Vec2d to, double width, const Colour& paint);
  /// An arrow along a circle, from angle −sweep/2 to sweep/2.
  void turn(Vec2d centre, double radius, double sweep, double width, const Colour& paint);
  /// A spiral from the inner to the outer radius.
  void coil(Vec2d centre, double inner, double outer, double from, double sweep, double width,
            const Colour& paint);
  /// A sector of a disc.
  void sector(Vec2d centre, double radius, double from, double sweep, const Colour& paint);

  /// Returns the figures drawn since clear(). A marker without any is deleted in rviz.
  visualization_msgs::MarkerArray& message(ros::Time stamp);

 private:
  Frames frames_;
  std::string name_;
  double height_, lineWidth_;
  visualization_msgs::MarkerArray message_;
  std::size_t current_ = 0;  ///< index of the marker that is drawn
  Pose pose_;
};

}  // namespace planar_chain
