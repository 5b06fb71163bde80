#pragma once

/// Dragging links with the mouse in rviz. Each link has an interactive marker in its link frame. rviz
/// reports:
///
///     press      grab the point under the mouse, and hold it
///     drag       a critically damped spring (pull.h) pulls the point towards the mouse
///     release    stop
///
/// The only output is ~link_force of the simulation's node. A force is computed for the state of each tick
/// and lasts until the next. So it ends with the ticks, the mouse button and this program. It also ends when
/// rviz, which repeats a drag at least four times a second, has been silent for a second of wall time. States
/// are subscribed to only during a drag.

#include <interactive_markers/interactive_marker_server.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/subscriber.h>
#include <sensor_msgs/JointState.h>
#include <visualization_msgs/InteractiveMarkerFeedback.h>

#include <deque>
#include <map>
#include <optional>
#include <string>

#include "dynamics/pull.h"
#include "planar_chain/scene.h"
#include "ros/messages/frames.h"
#include "ros/messages/pace.h"
#include "ros/view/drawing.h"
#include "ros/view/sketch.h"

namespace planar_chain {

class MouseDrag {
 public:
  /// The most links with a marker. In a longer chain they are evenly spread.
  static constexpr int mostMarkers = 200;

  /// scene: of the simulation; simulation: the full name of its node. The markers' topics are below this
  /// node.
  MouseDrag(const Scene& scene, const std::string& simulation);

 private:
  using Feedback = visualization_msgs::InteractiveMarkerFeedback;

  /// The grabbed point and its link's rotation at an instant that rviz may refer to.
  struct Place {
    ros::Time stamp;
    Vec2d position;
    Rotation<double> turn;
  };
  struct Grip {
    int link;
    Vec2d point;   ///< grabbed, link frame, m
    Vec2d offset;  ///< from the point to the mouse, link frame at offsetAt, m
    ros::Time offsetAt;
    ros::WallTime feedbackAt;     ///< the last feedback
    std::deque<Place> path;       ///< the last two seconds
    std::optional<Vec2d> target;  ///< the mouse, base frame, m
  };

  void offerMarker(int link);
  void onFeedback(const Feedback& feedback);
  void grab(int link, const Feedback& feedback);
  void release();
  void onState(const sensor_msgs::JointState& state);
  void findTarget();
  void draw(const PointMotion& point, Vec2d force, ros::Time stamp);
  const Link& linkAt(int link) const { return scene_.chain.links()[index(link)]; }

  const Scene scene_;
  Frames frames_;
  Drawing drawing_;
  Pull pull_;
  std::map<std::string, int> links_;  ///< index by name
  int stride_;                        ///< ticks from one force to the next
  double duration_;                   ///< the same in s
  double pulsation_;                  ///< ω of the spring, rad/s
  std::optional<Grip> grip_;
  int ticks_ = 0;
  Sketches sketch_;
  Every pictures_, warnings_;

  ros::NodeHandle outer_, inner_{"~"};
  interactive_markers::InteractiveMarkerServer server_;
  ros::Publisher forceOut_, pictureOut_;
  ros::Subscriber statesIn_;
};

}  // namespace planar_chain
