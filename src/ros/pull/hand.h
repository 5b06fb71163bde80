#pragma once

/// A hand in rviz: whoever drags a link with the mouse pulls it there. Sends ~link_force of the simulation's
/// contract, and nothing else.
///
/// On each link lies an interactive marker, in the link's own frame; from what rviz tells of it:
///
///     pressed    the point under the mouse is held where it is
///     dragged    a critically damped spring (pull.h) draws it to the mouse
///     let go     no more commands
///
/// The force is made anew for the state of each tick, and lasts until the next: so it ends with the ticks,
/// with the mouse button, with this program, and when rviz, which tells of a drag four times a second at
/// least, has been silent for a second of wall time. States are listened to during a drag, and only then.

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

class Hand {
 public:
  /// At most so many links have a marker; of longer chains as many, evenly spread.
  static constexpr int mostMarkers = 200;

  /// scene: that of the simulation whose node has this full name. Offers markers below this node's own name.
  Hand(const Scene& scene, const std::string& simulation);

 private:
  using Feedback = visualization_msgs::InteractiveMarkerFeedback;

  /// Where the point that is held was, and how its link stood, at an instant that rviz may refer to.
  struct Place {
    ros::Time stamp;
    Vec2d position;
    Rotation<double> turn;
  };
  struct Grip {
    int link;
    Vec2d point;            ///< of the link, in its frame, m
    Vec2d moved;            ///< from the point to the mouse, in the link's frame, m,
    ros::Time movedAt;      ///< as that stood then
    ros::WallTime heard;    ///< when rviz last told of it
    std::deque<Place> was;  ///< of late
    std::optional<Vec2d> target;
  };

  void offerMarker(int link);
  void take(const Feedback& feedback);
  void grasp(int link, const Feedback& feedback);
  void letGo();
  void pull(const sensor_msgs::JointState& state);
  /// Where the mouse is, once the state that rviz refers to is known.
  void findTarget();
  void show(const PointMotion& point, Vec2d force, ros::Time stamp);

  const Scene scene_;
  Frames frames_;
  Drawing drawing_;
  Pull pull_;
  std::map<std::string, int> links_;  ///< index by name
  int every_;                         ///< tick a command is sent
  double duration_;                   ///< s of sim time until the next
  double pulsation_;                  ///< of the spring, rad/s
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
