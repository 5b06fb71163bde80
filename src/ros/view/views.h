#pragma once

/// What acts on the chain, and a long chain itself, as rviz markers: one view per kind.

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <visualization_msgs/Marker.h>

#include <algorithm>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "planar_chain/simulation.h"
#include "ros/messages/frames.h"
#include "ros/view/drawing.h"
#include "ros/view/sketch.h"

namespace planar_chain {

class Views {
 public:
  /// The most pins, springs and centres of mass that are drawn. In a longer chain they are evenly spread.
  static constexpr int most = 16;

  static constexpr const char* energy = "energy";  ///< the view that is a Marker

  /// The simulation must outlive this.
  Views(Simulation& simulation, const Frames& frames);

  /// Returns the names of the views that are a MarkerArray.
  std::vector<std::string> arrays() const;

  /// Draws the simulation's present state: calls send(name, message) for each view with wants(name). The
  /// message is valid until the next call.
  template <class Wants, class Send>
  void draw(ros::Time stamp, Wants wants, Send send) {
    const auto isWanted = [&](const View& view) { return wants(view.name); };
    if (std::any_of(views_.begin(), views_.end(), isWanted)) simulation_.linkMotions(motions_.data());
    for (View& view : views_) {
      if (!isWanted(view)) continue;
      view.sketch.clear();
      (this->*view.draw)(view.sketch);
      send(view.name, view.sketch.message(stamp));
    }
    if (wants(energy)) send(energy, writeEnergy(stamp));
  }

 private:
  struct View {
    std::string name;
    Sketch sketch;
    void (Views::*draw)(Sketch& sketch);
  };
  struct Spot {
    double time;  ///< s
    Vec2d tip;    ///< m, base frame
  };

  void drawLoads(Sketch& sketch);
  void drawLoad(Sketch& sketch, const Load& load, double factor);
  void drawPinForces(Sketch& sketch);
  void drawSprings(Sketch& sketch);
  void drawTrail(Sketch& sketch);
  void drawCentres(Sketch& sketch);
  void drawCentre(Sketch& sketch, Vec2d at, double radius);
  void drawChain(Sketch& sketch);
  visualization_msgs::Marker& writeEnergy(ros::Time stamp);
  Sketch& on(Sketch& sketch, int link) const;
  Pose poseOf(int link) const;
  Vec2d inLink(int link, Vec2d vector) const;
  Vec2d tip() const;

  Simulation& simulation_;
  const Chain& chain_;
  Frames frames_;
  Drawing drawing_;
  int stride_;  ///< from one drawn link to the next
  std::vector<LinkMotion> motions_;
  std::vector<double> torques_;
  std::deque<Spot> trail_;
  std::vector<View> views_;
  visualization_msgs::Marker energy_;
};

/// Views as topics of a node. A topic without subscribers is not computed.
class ViewTopics {
 public:
  /// Advertises view/NAME under `node` for each view. The simulation must outlive this.
  ViewTopics(ros::NodeHandle& node, Simulation& simulation, const Frames& frames);

  /// True if each view has subscribers.
  bool areSubscribed() const;
  /// Publishes the simulation's present state.
  void publish(ros::Time stamp);

 private:
  Views views_;
  std::map<std::string, ros::Publisher> out_;
};

}  // namespace planar_chain
