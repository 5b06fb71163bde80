#pragma once

/// The time and the energies, as texts of rviz in a corner of the view.

#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "planar_chain/simulation.h"
#include "ros/view/extent.h"

namespace planar_chain {

class EnergyText {
 public:
  /// frame: of the base, or what the view follows. reference: an energy, J, that is shown with four digits.
  EnergyText(const Extent& view, const std::string& frame, double reference);

  /// time: s. Returns a message that is valid until the next call: a text for each line, as two would part in
  /// a view that is turned.
  visualization_msgs::MarkerArray& write(double time, const EnergyBalance& balance, ros::Time stamp);

 private:
  void put(std::size_t line, const std::string& number);

  double reference_, size_, middle_;
  visualization_msgs::MarkerArray message_;
};

}  // namespace planar_chain
