#pragma once

/// A chain as hardware of ros_control. Joints with the key `drive` have a position interface, the others an
/// effort interface. All have a state interface: position, velocity, and the whole torque in the joint.

#include <hardware_interface/joint_command_interface.h>
#include <hardware_interface/joint_state_interface.h>
#include <hardware_interface/robot_hw.h>
#include <planar_chain/simulation.h>

#include <vector>

namespace planar_chain_control {

class ChainHardware : public hardware_interface::RobotHW {
 public:
  /// @throws planar_chain::Refused with all faults of the scene
  explicit ChainHardware(const planar_chain::Scene& scene);

  /// Takes the state of the chain.
  void read(const ros::Time& time, const ros::Duration& period) override;
  /// Holds the efforts, leads driven joints by cubics to their commanded positions, and moves the chain by
  /// `period`.
  /// @throws std::runtime_error when the integration fails or a command is not finite
  void write(const ros::Time& time, const ros::Duration& period) override;

  const planar_chain::Simulation& simulation() const { return simulation_; }

 private:
  planar_chain::Simulation simulation_;
  std::vector<double> position_, velocity_, effort_;  // rad, rad/s, N m; of slides m, m/s, N
  std::vector<double> command_,
      before_;  // positions of driven joints, efforts of others; before_: of the last write
  hardware_interface::JointStateInterface states_;
  hardware_interface::EffortJointInterface efforts_;
  hardware_interface::PositionJointInterface positions_;
};

}  // namespace planar_chain_control
