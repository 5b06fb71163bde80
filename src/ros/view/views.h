#pragma once

/// What acts on the chain, as rviz markers: one topic per kind. A topic without subscribers is not computed.

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <visualization_msgs/Marker.h>

#include <deque>
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

  /// Advertises view/loads, pin_forces, springs, trail, centres and energy under `node`. The
  /// simulation must outlive this.
  Views(ros::NodeHandle& node, Simulation& simulation, const Frames& frames);

  /// Publishes the simulation's present state.
  void publish(ros::Time stamp);

 private:
  struct View {
    Sketch sketch;
    ros::Publisher out;
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
  void writeEnergy(const EnergyBalance& balance);
  Vec2d inLink(int link, Vec2d vector) const;

  Simulation& simulation_;
  const Chain& chain_;
  Drawing drawing_;
  int stride_;  ///< from one drawn link to the next
  std::vector<LinkMotion> motions_;
  std::vector<double> torques_;
  std::deque<Spot> trail_;
  std::vector<View> views_;
  visualization_msgs::Marker energy_;
  ros::Publisher energyOut_;
};

}  // namespace planar_chain
