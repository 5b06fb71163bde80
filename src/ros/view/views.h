#pragma once

/// Forces, torques and motion of the chain, and a long chain itself, as rviz markers: one view per kind.

#include <map>
#include <string>
#include <vector>

#include "planar_chain/simulation.h"
#include "ros/messages/frames.h"
#include "ros/view/drawing.h"
#include "ros/view/energy_text.h"
#include "ros/view/scale_bar.h"
#include "ros/view/sketch.h"

namespace planar_chain {

class Views {
 public:
  /// The most pins, springs and centres of mass that are drawn. In a longer chain they are evenly spread.
  static constexpr int most = 16;

  /// The simulation must outlive this.
  Views(Simulation& simulation, const Frames& frames);

  /// Calls visit(name, make) for each view. make(stamp) draws the present state and returns a pointer to the
  /// message, which is valid until the next call.
  template <class Visit>
  void forEach(Visit visit) {
    hasMotions_ = false;
    for (View& view : views_) {
      visit(view.name, [&](ros::Time stamp) { return &draw(view, stamp); });
    }
    visit("energy", [this](ros::Time stamp) {
      return &energy_.write(simulation_.time(), simulation_.energyBalance(), stamp);
    });
    visit("scale", [this](ros::Time stamp) { return &scale_.message(stamp); });
  }

 private:
  struct View {
    std::string name;
    Sketch sketch;
    void (Views::*draw)(Sketch& sketch);
  };

  visualization_msgs::MarkerArray& draw(View& view, ros::Time stamp);
  void drawLoads(Sketch& sketch);
  void drawTurn(Sketch& sketch, int link, Vec2d centre, double torque, const Colour& paint);
  void drawInJoint(Sketch& sketch, int joint, double torque, const Colour& paint);
  void drawDrives(Sketch& sketch);
  void drawFriction(Sketch& sketch);
  void drawForce(Sketch& sketch, int link, Vec2d point, Vec2d force, const Colour& paint);
  void drawPinForces(Sketch& sketch);
  void drawSprings(Sketch& sketch);
  void drawGroundSprings(Sketch& sketch);
  void drawAlongAxis(Sketch& sketch, int joint, const Colour& paint);
  void drawLimits(Sketch& sketch);
  void drawTrail(Sketch& sketch);
  void drawCentres(Sketch& sketch);
  void drawCentre(Sketch& sketch, Vec2d at, double radius);
  void drawChain(Sketch& sketch);
  /// Calls act(load, factor) for the loads of the scene and the commands in force.
  template <class Act>
  void forLoads(Act act) const;
  Sketch& on(Sketch& sketch, int link, Vec2d origin = {}) const;
  Sketch& inside(Sketch& sketch, int joint) const;
  Pose poseOf(int link) const;
  Vec2d tip() const;

  Simulation& simulation_;
  const Chain& chain_;
  Frames frames_;
  Drawing drawing_;
  int stride_;  ///< from one drawn link to the next
  std::vector<LinkMotion> motions_;
  bool hasMotions_ = false;  ///< motions_ are those of the present state
  std::vector<double> torques_;
  std::map<double, Vec2d> trail_;  ///< the tip (m, base frame) by time (s)
  long long timesSet_ = 0;         ///< of the simulation, in the trail
  std::vector<View> views_;
  EnergyText energy_;
  ScaleBar scale_;
};

}  // namespace planar_chain
