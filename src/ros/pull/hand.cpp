#include "ros/pull/hand.h"

#include <planar_chain/LinkForce.h>
#include <ros/console.h>
#include <ros/names.h>
#include <ros/this_node.h>

#include <algorithm>
#include <cmath>

namespace planar_chain {

namespace {

constexpr double fastest = 20;            // rad/s: a point is there in a third of a second
constexpr double fewTicks = 0.2;          // rad of the spring's motion that a force may last
constexpr double mostCommands = 250;      // Hz
constexpr double overlap = 1e-6;          // s that a force outlasts its tick, whose end is told with it
constexpr double mostPictures = 50;       // Hz
constexpr double silence = 1;             // s of wall time
constexpr double memory = 2;              // s
constexpr double heightOverBodies = 1.6;  // widths of a link: over all that Views draws
constexpr double markerWidth = 2;         // of the link's own: easier to hit

/// What a mouse may take hold of: not to be seen, for the link itself is; rviz lights it up under the mouse.
visualization_msgs::Marker boxAround(const Bar& bar, double width) {
  const Vec2d along = bar.to - bar.from, middle = 0.5 * (bar.from + bar.to);
  const double angle = std::atan2(along.y, along.x);
  visualization_msgs::Marker box;
  box.type = visualization_msgs::Marker::CUBE;
  box.pose.position.x = middle.x;
  box.pose.position.y = middle.y;
  box.pose.orientation.z = std::sin(angle / 2);
  box.pose.orientation.w = std::cos(angle / 2);
  box.scale.x = length(along) + width;
  box.scale.y = width;
  box.scale.z = width;
  box.color = colour(1, 1, 1, 0.01);
  return box;
}

Vec2d inPlane(const geometry_msgs::Point& point) {
  return {point.x, point.y};
}

}  // namespace

Hand::Hand(const Scene& scene, const std::string& simulation)
    : scene_(scene),
      frames_(framesOf(scene, ros::names::parentNamespace(simulation))),
      drawing_(scene),
      pull_(scene_.chain),
      every_(std::max(1, static_cast<int>(std::ceil(scene.publish.rate / mostCommands)))),
      duration_(every_ / scene.publish.rate),
      pulsation_(std::fmin(fastest, fewTicks / duration_)),
      sketch_(frames_, "pull", heightOverBodies * drawing_.bar),
      pictures_(1 / mostPictures),
      warnings_(1),
      outer_(ros::names::parentNamespace(simulation)),
      server_(ros::this_node::getName()),
      forceOut_(outer_.advertise<LinkForce>(simulation + "/link_force", 10)),
      pictureOut_(inner_.advertise<visualization_msgs::MarkerArray>("force", 2)) {
  const int n = scene_.chain.size();
  const int stride = (n + mostMarkers - 1) / mostMarkers;
  for (int i = n - 1; i >= 0; i -= stride) offerMarker(i);
  server_.applyChanges();
}

void Hand::offerMarker(int link) {
  const Link& body = scene_.chain.links()[static_cast<std::size_t>(link)];
  visualization_msgs::InteractiveMarkerControl control;
  control.name = "pull";
  control.interaction_mode = visualization_msgs::InteractiveMarkerControl::MOVE_PLANE;
  // Across its x axis, which stands on the plane of motion.
  control.orientation.y = -std::sqrt(0.5);
  control.orientation.w = std::sqrt(0.5);
  control.always_visible = true;
  for (const Bar& bar : barsOf(body, drawing_)) {
    control.markers.push_back(boxAround(bar, markerWidth * drawing_.bar));
  }

  visualization_msgs::InteractiveMarker marker;
  marker.header.frame_id = frames_.links[static_cast<std::size_t>(link)];  // no stamp: it moves with the link
  marker.name = body.name;
  marker.scale = static_cast<float>(drawing_.unit);
  marker.pose.orientation.w = 1;
  marker.controls.push_back(control);
  server_.insert(marker, [this](const Feedback::ConstPtr& feedback) { take(*feedback); });
  links_[body.name] = link;
}

void Hand::take(const Feedback& feedback) {
  const auto found = links_.find(feedback.marker_name);
  if (found == links_.end()) return;
  const int link = found->second;
  const std::string& frame = frames_.links[static_cast<std::size_t>(link)];
  const bool isFaulty = feedback.header.frame_id != frame || !isFinite(inPlane(feedback.pose.position)) ||
                        !isFinite(inPlane(feedback.mouse_point));
  if (isFaulty && warnings_.falls(ros::WallTime::now().toSec())) {
    ROS_WARN("%s/feedback: expected finite numbers in frame %s, got (%g, %g) m and (%g, %g) m in %s",
             ros::this_node::getName().c_str(), frame.c_str(), feedback.pose.position.x,
             feedback.pose.position.y, feedback.mouse_point.x, feedback.mouse_point.y,
             feedback.header.frame_id.c_str());
  }
  if (isFaulty) return;

  switch (feedback.event_type) {
    case Feedback::MOUSE_DOWN:
      return grasp(link, feedback);
    case Feedback::POSE_UPDATE:
    case Feedback::KEEP_ALIVE:
      if (!grip_ || grip_->link != link) return;
      grip_->heard = ros::WallTime::now();
      grip_->moved = inPlane(feedback.pose.position);
      grip_->movedAt = feedback.header.stamp;
      return findTarget();
    case Feedback::MOUSE_UP:
      if (grip_ && grip_->link == link) letGo();
      return;
    default:
      return;
  }
}

void Hand::grasp(int link, const Feedback& feedback) {
  if (grip_) letGo();
  const Vec2d point = feedback.mouse_point_valid ? inPlane(feedback.mouse_point)
                                                 : scene_.chain.links()[static_cast<std::size_t>(link)].com;
  grip_ = Grip{link, point, {}, feedback.header.stamp, ros::WallTime::now(), {}, {}};
  ticks_ = 0;
  statesIn_ = outer_.subscribe("joint_states", 1, &Hand::pull, this, ros::TransportHints().tcpNoDelay());
}

void Hand::letGo() {
  statesIn_.shutdown();
  const std::string& name = scene_.chain.links()[static_cast<std::size_t>(grip_->link)].name;
  grip_.reset();
  geometry_msgs::Pose home;
  home.orientation.w = 1;
  server_.setPose(name, home);
  server_.applyChanges();
  sketch_.clear();
  pictureOut_.publish(sketch_.message(ros::Time::now()));
}

void Hand::pull(const sensor_msgs::JointState& state) {
  const auto n = static_cast<std::size_t>(scene_.chain.size());
  if (!grip_ || state.position.size() != n || state.velocity.size() != n) return;
  if ((ros::WallTime::now() - grip_->heard).toSec() > silence) return letGo();

  const PointMotion point =
      pull_.motionOf(state.position.data(), state.velocity.data(), grip_->link, grip_->point);
  auto& was = grip_->was;
  if (!was.empty() && state.header.stamp <= was.back().stamp) was.clear();  // time began anew
  was.push_back({state.header.stamp, point.position, point.turn});
  while ((was.back().stamp - was.front().stamp).toSec() > memory) was.pop_front();
  findTarget();
  if (!grip_->target || ticks_++ % every_ != 0) return;

  const Vec2d force = pull_.force(point, *grip_->target, pulsation_);
  LinkForce command;
  command.link = scene_.chain.links()[static_cast<std::size_t>(grip_->link)].name;
  command.point.x = grip_->point.x;
  command.point.y = grip_->point.y;
  command.force.x = force.x;
  command.force.y = force.y;
  command.duration = duration_ + overlap;
  forceOut_.publish(command);
  if (pictures_.falls(ros::WallTime::now().toSec())) show(point, force, state.header.stamp);
}

void Hand::findTarget() {
  const auto& was = grip_->was;
  if (was.empty() || grip_->movedAt > was.back().stamp) return;  // it comes with a later state
  const auto later =
      std::upper_bound(was.begin(), was.end(), grip_->movedAt,
                       [](ros::Time stamp, const Place& place) { return stamp < place.stamp; });
  const Place& place = later == was.begin() ? *later : *(later - 1);
  grip_->target = place.position + place.turn * grip_->moved;
}

void Hand::show(const PointMotion& point, Vec2d force, ros::Time stamp) {
  const std_msgs::ColorRGBA paint = colour(1, 0.9, 0.35), pale = colour(1, 0.9, 0.35, 0.35);
  const Rotation<double> back{point.turn.c, -point.turn.s};
  const Vec2d from = grip_->point, mouse = from + back * (*grip_->target - point.position);
  const double w = drawing_.bar;
  sketch_.clear();
  Sketch& sketch = sketch_.on(grip_->link);
  sketch.band(from, mouse, 0.12 * w, 0.12 * w, pale, pale);
  sketch.sector(mouse, 0.3 * w, 0, 6.3, pale);
  sketch.arrow(from, from + back * drawing_.arrow(force), 0.4 * w, paint);
  pictureOut_.publish(sketch_.message(stamp));
}

}  // namespace planar_chain
