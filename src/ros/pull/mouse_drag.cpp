/// pull: drags the links of a running simulation with the mouse, in rviz. The parameter ~simulation is the
/// name of its node. Each link that has a frame has an interactive marker in it. rviz reports:
///
///     press      grab the point under the mouse, and hold it; the link is drawn bright
///     drag       a critically damped spring (pull.h) pulls the point towards the mouse
///     release    stop
///
/// The only output is ~link_force of the simulation's node. A force is computed for the state of each tick
/// and lasts until the next. So it ends with the ticks, the mouse button and this program. It also ends when
/// rviz, which repeats a drag at least four times a second, has been silent for a second of wall time. States
/// are subscribed to only during a drag. While the simulation is paused there are none: then the picture
/// shows the spring without its force.

#include <interactive_markers/interactive_marker_server.h>
#include <planar_chain/LinkForce.h>
#include <planar_chain/LinkStates.h>
#include <ros/console.h>
#include <ros/init.h>
#include <ros/names.h>
#include <ros/node_handle.h>
#include <ros/this_node.h>
#include <sensor_msgs/JointState.h>

#include <algorithm>
#include <clocale>
#include <cmath>
#include <iostream>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/pull.h"
#include "ros/messages/ticks.h"
#include "ros/node/parameters.h"
#include "ros/view/drawing.h"
#include "ros/view/sketch.h"

namespace planar_chain {
namespace {

constexpr double highestPulsation = 20;   // rad/s: the point arrives in a third of a second
constexpr double turnPerForce = 0.2;      // rad of the spring's motion while one force lasts, at most
constexpr double mostForces = 250;        // Hz
constexpr double overlap = 1e-6;          // s: the state at the end of a tick shows the force of that tick
constexpr double mostPictures = 50;       // Hz
constexpr double longestSilence = 1;      // s of wall time
constexpr double pausedAfter = 0.1;       // s of wall time without a state
constexpr double memory = 2;              // s
constexpr double heightOverBodies = 1.6;  // widths of a link: above everything that Views draws
constexpr double markerWidth = 2;         // widths of a link: easier to hit
constexpr double brightWidth = 1.5;       // widths of a bar, of a link that is grabbed

Vec2d inPlane(const geometry_msgs::Point& point) {
  return {point.x, point.y};
}

/// The area that reacts to the mouse. It is almost transparent, as the link is visible; rviz highlights it.
/// It reaches before the symbols and arrows on the link, which would take the mouse.
visualization_msgs::Marker boxAround(const Bar& bar, double unit) {
  const Vec2d along = bar.to - bar.from;
  const double angle = std::atan2(along.y, along.x);
  visualization_msgs::Marker box;
  box.type = visualization_msgs::Marker::CUBE;
  copy(0.5 * (bar.from + bar.to), box.pose.position);
  box.pose.orientation.z = std::sin(angle / 2);
  box.pose.orientation.w = std::cos(angle / 2);
  box.scale.y = markerWidth * unit;
  box.scale.x = length(along) + box.scale.y;
  box.scale.z = 2 * heightOverBodies * unit;
  box.color = colour(1, 1, 1, 0.002);
  return box;
}

class MouseDrag {
 public:
  /// The most links with a marker. In a longer chain they are evenly spread; rviz is slow with more.
  static constexpr int mostMarkers = 50;

  /// scene: of the simulation; simulation: the full name of its node. The markers' topics are below this
  /// node.
  MouseDrag(const Scene& scene, const std::string& simulation)
      : scene_(scene),
        simulation_(simulation),
        frames_(framesOf(scene, simulation)),
        drawing_(scene),
        pull_(scene_.chain),
        stride_(std::max(1, static_cast<int>(std::ceil(scene.publish.rate / mostForces)))),
        duration_(stride_ / scene.publish.rate),
        pulsation_(std::fmin(highestPulsation, turnPerForce / duration_)),
        sketch_(frames_, "pull", heightOverBodies * drawing_.bar),
        pictures_(1 / mostPictures),
        warnings_(1),
        outer_(ros::names::parentNamespace(simulation)),
        server_(ros::this_node::getName()),
        forceOut_(outer_.advertise<LinkForce>(simulation + "/link_force", 10)),
        pictureOut_(inner_.advertise<visualization_msgs::MarkerArray>("force", 2)) {
    if (scene_.base && !scene_.publish.linkStates) {
      ROS_ERROR("%s: publish/link_states: expected true, to drag a chain on a base, got false",
                simulation.c_str());
      return;
    }
    const int n = scene_.chain.size();
    const int apart = frames_.every * mostMarkers;
    const int stride = (n + apart - 1) / apart * frames_.every;
    for (int i = n - 1; i >= 0; i -= stride) {
      if (linkAt(i).mass > 0) offerMarker(i);  // a prismatic link without mass may be nothing but a direction
    }
    server_.applyChanges();
  }

 private:
  using Feedback = visualization_msgs::InteractiveMarkerFeedback;

  struct Grip {
    int link;
    Vec2d point;   ///< grabbed, link frame, m
    Vec2d offset;  ///< from the point to the mouse, link frame at offsetAt, m
    ros::Time offsetAt;
    ros::SteadyTime feedbackAt;      ///< the last feedback
    ros::SteadyTime stateAt;         ///< the arrival of the last state
    std::map<ros::Time, Pose> path;  ///< of the point in the last two seconds
    std::optional<Vec2d> target;     ///< the mouse, base frame, m
  };

  void offerMarker(int link) {
    visualization_msgs::InteractiveMarkerControl control;
    control.name = "pull";
    control.interaction_mode = visualization_msgs::InteractiveMarkerControl::MOVE_PLANE;
    // The mouse moves in the plane across the control's x axis, which is turned to +z here.
    control.orientation.y = -std::sqrt(0.5);
    control.orientation.w = std::sqrt(0.5);
    control.always_visible = true;
    for (const Bar& bar : figureOf(linkAt(link), drawing_).bars) {
      control.markers.push_back(boxAround(bar, drawing_.bar));
    }

    visualization_msgs::InteractiveMarker marker;
    // Without a stamp the marker moves with its frame.
    marker.header.frame_id = frames_.links[index(link)];
    marker.name = linkAt(link).name;
    marker.scale = static_cast<float>(drawing_.unit);
    marker.pose.orientation.w = 1;
    marker.controls.push_back(control);
    server_.insert(marker, [this, link](const Feedback::ConstPtr& feedback) { onFeedback(link, *feedback); });
  }

  // ---- What rviz reports ---------------------------------------------------------------------------

  void onFeedback(int link, const Feedback& feedback) {
    // Check the message.
    const std::string& frame = frames_.links[index(link)];
    const Vec2d offset = inPlane(feedback.pose.position), mouse = inPlane(feedback.mouse_point);
    if (feedback.header.frame_id != frame || !isFinite(offset) || !isFinite(mouse)) {
      if (warnings_.isDue()) {
        ROS_WARN("%s/feedback: expected finite numbers in frame %s, got (%g, %g) m and (%g, %g) m in %s",
                 ros::this_node::getName().c_str(), frame.c_str(), offset.x, offset.y, mouse.x, mouse.y,
                 feedback.header.frame_id.c_str());
      }
      return;
    }

    // Grab, drag or release.
    if (feedback.event_type == Feedback::MOUSE_DOWN) return grab(link, feedback);
    if (!grip_ || grip_->link != link) return;
    if (feedback.event_type == Feedback::MOUSE_UP) return release();
    grip_->feedbackAt = ros::SteadyTime::now();
    grip_->offset = offset;
    grip_->offsetAt = feedback.header.stamp;
    findTarget();
    if (isPaused() && pictures_.isDue()) {
      draw(grip_->point + offset, {}, ros::Time());
    }
  }

  void grab(int link, const Feedback& feedback) {
    if (grip_) release();
    const Vec2d point = feedback.mouse_point_valid ? inPlane(feedback.mouse_point) : linkAt(link).com;
    grip_ = Grip{link, point, {}, feedback.header.stamp, ros::SteadyTime::now(), {}, {}, {}};
    ticks_ = 0;
    draw(point, {}, ros::Time());
    const auto noDelay = ros::TransportHints().tcpNoDelay();
    statesIn_ = scene_.base
                    ? outer_.subscribe(simulation_ + "/link_states", 1, &MouseDrag::onLinks, this, noDelay)
                    : outer_.subscribe("joint_states", 1, &MouseDrag::onState, this, noDelay);
  }

  /// True if no states come. rviz then waits for the transforms of any stamp but 0.
  bool isPaused() const { return (ros::SteadyTime::now() - grip_->stateAt).toSec() > pausedAfter; }

  void release() {
    // Stop the forces, move the marker back to its link, and erase the picture.
    statesIn_.shutdown();
    geometry_msgs::Pose home;
    home.orientation.w = 1;
    server_.setPose(linkAt(grip_->link).name, home);
    server_.applyChanges();
    const ros::Time stamp = isPaused() ? ros::Time() : ros::Time::now();
    grip_.reset();
    sketch_.clear();
    pictureOut_.publish(sketch_.message(stamp));
  }

  /// Finds the mouse in the base frame, if the state at offsetAt is known.
  void findTarget() {
    const auto& path = grip_->path;
    if (path.empty() || grip_->offsetAt > path.rbegin()->first) return;
    const auto later = path.upper_bound(grip_->offsetAt);
    const Pose& pose = (later == path.begin() ? later : std::prev(later))->second;
    grip_->target = pose.origin + pose.turn * grip_->offset;
  }

  // ---- The force -----------------------------------------------------------------------------------

  void onState(const sensor_msgs::JointState& state) {
    const auto n = static_cast<std::size_t>(scene_.chain.size());
    if (!grip_ || state.position.size() != n || state.velocity.size() != n) return;
    root_ = {};
    for (int i = 0; i < scene_.chain.coordinates().leading(); ++i)
      root_ += state.position[index(i)] * scene_.chain.joints()[index(i)].axis + linkAt(i).pin;
    follow(pull_.motionOf(state.position.data(), state.velocity.data(), grip_->link, grip_->point),
           state.header.stamp);
  }
  /// For a chain on a base, as joint states do not have the motion of the base.
  void onLinks(const LinkStates& state) {
    const auto n = static_cast<std::size_t>(scene_.chain.size());
    if (!grip_ || state.pose.size() != n || state.velocity.size() != n) return;
    angles_.clear();
    displacements_.assign(n, 0);
    Vec2d pin;  // the outer one of the link inside; the first displacement moves no point against another
    for (int i = 0; i < scene_.chain.size(); ++i) {
      const geometry_msgs::Pose2D& pose = state.pose[index(i)];
      const auto turn = Rotation<double>::of(pose.theta);
      const Joint& joint = scene_.chain.joints()[index(i)];
      const Vec2d own = Vec2d{pose.x, pose.y} - turn * linkAt(i).com;
      if (i > 0 && joint.isPrismatic) displacements_[index(i)] = dot(own - pin, turn * joint.axis);
      if (i == scene_.chain.coordinates().leading()) root_ = own;
      angles_.push_back(pose.theta);
      pin = own + turn * linkAt(i).pin;
    }
    const geometry_msgs::Pose2D& pose = state.pose[index(grip_->link)];
    const geometry_msgs::Twist& rate = state.velocity[index(grip_->link)];
    const CentreMotion centre{{pose.x, pose.y}, {rate.linear.x, rate.linear.y}, rate.angular.z};
    follow(pull_.motionOf(angles_.data(), displacements_.data(), centre, grip_->link, grip_->point),
           state.header.stamp);
  }

  void follow(const PointMotion& point, ros::Time stamp) {
    if ((ros::SteadyTime::now() - grip_->feedbackAt).toSec() > longestSilence) return release();

    grip_->stateAt = ros::SteadyTime::now();

    // Find the mouse. Stamps go back if the clock does.
    auto& path = grip_->path;
    if (!path.empty() && stamp <= path.rbegin()->first) path.clear();
    path[stamp] = {point.position, point.turn};
    while ((stamp - path.begin()->first).toSec() > memory) path.erase(path.begin());
    findTarget();
    if (!grip_->target || ticks_++ % stride_ != 0) return;

    // Send the force of the spring.
    const Vec2d force = pull_.force(point, *grip_->target, pulsation_);
    LinkForce command;
    command.link = linkAt(grip_->link).name;
    copy(grip_->point, command.point);
    copy(force, command.force);
    command.duration = duration_ + overlap;
    forceOut_.publish(command);
    if (!pictures_.isDue()) return;
    const Rotation<double> toLink{point.turn.c, -point.turn.s};
    draw(grip_->point + toLink * (*grip_->target - point.position),
         toLink * drawing_.arrow(force, point.position - root_), stamp);
  }

  /// Publishes the grabbed link, the spring to the mouse, and the arrow of the force as a picture; link
  /// frame, m.
  void draw(Vec2d mouse, Vec2d arrow, ros::Time stamp) {
    const Colour paint = colour(1, 0.9, 0.35), pale = colour(1, 0.9, 0.35, 0.35);
    const Vec2d from = grip_->point;
    const double w = drawing_.bar;
    sketch_.clear();
    Sketch& sketch = sketch_.on(grip_->link);
    for (const Bar& bar : figureOf(linkAt(grip_->link), drawing_).bars) {
      sketch.band(bar.from, bar.to, brightWidth * bar.share * w, brightWidth * bar.share * w, pale);
    }
    sketch.band(from, mouse, 0.12 * w, 0.12 * w, pale);
    sketch.sector(mouse, 0.3 * w, 0, 6.3, pale);
    sketch.arrow(from, from + arrow, 0.4 * w, paint);
    pictureOut_.publish(sketch_.message(stamp));
  }

  const Link& linkAt(int link) const { return scene_.chain.links()[index(link)]; }

  const Scene scene_;
  const std::string simulation_;
  Frames frames_;
  Drawing drawing_;
  Pull pull_;
  std::vector<double> angles_;         ///< of all links, rad
  std::vector<double> displacements_;  ///< of prismatic joints, m
  Vec2d root_;                         ///< the inner pin of the first link that turns, base frame, m
  int stride_;                         ///< ticks from one force to the next
  double duration_;                    ///< the same in s
  double pulsation_;                   ///< ω of the spring, rad/s
  std::optional<Grip> grip_;
  int ticks_ = 0;
  Sketch sketch_;
  Every pictures_, warnings_;

  ros::NodeHandle outer_, inner_{"~"};
  interactive_markers::InteractiveMarkerServer server_;
  ros::Publisher forceOut_, pictureOut_;
  ros::Subscriber statesIn_;
};

}  // namespace
}  // namespace planar_chain

constexpr const char* usage =
    "pull [_simulation:=NODE]\n"
    "Lets the mouse pull the links of a running simulation in rviz. sim.launch starts it with pull:=true.\n";

int main(int argc, char** argv) {
  std::setlocale(LC_CTYPE, "C.UTF-8");  // let the log write signs such as ²
  std::vector<std::string> given;
  ros::removeROSArgs(argc, argv, given);
  if (given.size() > 1) {
    const bool asks = given[1] == "--help" || given[1] == "-h";
    (asks ? std::cout : std::cerr) << usage;
    return asks ? 0 : 2;
  }
  ros::init(argc, argv, "pull");
  const ros::NodeHandle own("~");
  const auto simulation = own.param<std::string>("simulation", "planar_chain");
  return planar_chain::SceneParameters(simulation).run([&simulation](const planar_chain::Scene& scene) {
    const planar_chain::MouseDrag drag(scene, ros::names::resolve(simulation));
    ros::spin();
  });
}
