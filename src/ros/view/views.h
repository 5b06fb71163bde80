#pragma once

/// What acts, to be seen in rviz: a topic for each kind, made while somebody listens to it, and only then.

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
  /// Of long chains as many pins, springs and centres of mass are drawn, evenly spread.
  static constexpr int most = 16;

  /// Advertises ~view/loads, pin_forces, springs, trail, centres and energy.
  Views(ros::NodeHandle& node, const Scene& scene, const Frames& frames);

  /// Of the simulation's present state.
  void publish(const Simulation& simulation, ros::Time stamp);

 private:
  struct Spot {
    double time;  ///< s
    Vec2d tip;    ///< m
  };

  void drawLoads(const Simulation& simulation, double t);
  void drawLoad(const Chain& chain, const Load& load, double factor);
  void drawPinForces();
  void drawSprings(const Simulation& simulation, double t);
  void drawTrail(const Simulation& simulation);
  void drawCentres(const Chain& chain);
  void drawCentre(Sketch& sketch, Vec2d at, double radius);
  void tellEnergy(const EnergyBalance& balance);
  /// A vector of the base in the axes of a link.
  Vec2d seenBy(int link, Vec2d vector) const;

  Drawing drawing_;
  int stride_;  ///< from one link that is drawn to the next
  std::vector<LinkMotion> motions_;
  std::vector<double> torques_;
  std::deque<Spot> trail_;
  Sketches loads_, pinForces_, springs_, path_, centres_;
  visualization_msgs::Marker energy_;
  ros::Publisher loadsOut_, pinForcesOut_, springsOut_, trailOut_, centresOut_, energyOut_;
};

}  // namespace planar_chain
