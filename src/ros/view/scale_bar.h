#pragma once

/// A bar in a corner of the view, with its length in words.

#include <visualization_msgs/MarkerArray.h>

#include "ros/messages/frames.h"
#include "ros/view/extent.h"

namespace planar_chain {

class ScaleBar {
 public:
  /// link: that the view follows, or Sketch::base.
  ScaleBar(const Extent& view, const Frames& frames, int link);

  /// Returns a message that is valid until the next call.
  visualization_msgs::MarkerArray& message(ros::Time stamp);

 private:
  visualization_msgs::MarkerArray message_;
};

}  // namespace planar_chain
