#pragma once

/// Flat figures in the plane of motion, as rviz markers.

#include <std_msgs/ColorRGBA.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "planar_chain/planar.h"
#include "ros/messages/frames.h"

namespace planar_chain {

using Colour = std_msgs::ColorRGBA;

/// Each component is in 0 … 1.
Colour colour(double red, double green, double blue, double alpha = 1);

/// One marker of triangles per frame that has figures. Lengths in m, angles in rad, coordinates in the axes
/// of the frame.
class Sketch {
 public:
  static constexpr int base = -1;

  /// The figures lie at `height` (m) above the plane.
  Sketch(Frames frames, std::string name, double height);

  void clear();
  /// From here on draws in the frame of a link, or of the base. The first call for a link allocates its
  /// marker.
  Sketch& on(int link);
  /// A band from a to b. Width and colour change linearly.
  void band(Vec2d a, Vec2d b, double widthA, double widthB, const Colour& colourA, const Colour& colourB);
  void arrow(Vec2d from, Vec2d to, double width, const Colour& paint);
  /// An arrow along a circle, from angle `from` to `from + sweep`.
  void turn(Vec2d centre, double radius, double from, double sweep, double width, const Colour& paint);
  /// A spiral from the inner to the outer radius.
  void coil(Vec2d centre, double inner, double outer, double from, double sweep, double width,
            const Colour& paint);
  /// A sector of a disc.
  void sector(Vec2d centre, double radius, double from, double sweep, const Colour& paint);

  /// Returns the figures drawn since clear(). A marker without any is deleted in rviz.
  const visualization_msgs::MarkerArray& message(ros::Time stamp);

 private:
  void corner(Vec2d a, const Colour& paint);

  Frames frames_;
  std::string name_;
  double height_;
  visualization_msgs::MarkerArray message_;
  std::size_t current_ = 0;  ///< index of the marker that is drawn
};

}  // namespace planar_chain
