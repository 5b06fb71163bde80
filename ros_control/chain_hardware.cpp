#include "chain_hardware.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace planar_chain_control {

using planar_chain::Drive;
using planar_chain::index;

ChainHardware::ChainHardware(const planar_chain::Scene& scene)
    : simulation_(scene, 1), effort_(scene.chain.joints().size()), command_(scene.chain.joints().size()) {
  position_ = simulation_.q();
  velocity_ = simulation_.qd();
  std::vector<bool> isDriven(position_.size());
  for (const Drive& drive : scene.drives) {
    isDriven[index(drive.joint)] = true;
    command_[index(drive.joint)] = position_[index(drive.joint)];
  }
  before_ = command_;
  for (std::size_t i = 0; i < position_.size(); ++i) {
    const hardware_interface::JointStateHandle state(scene.chain.joints()[i].name, &position_[i],
                                                     &velocity_[i], &effort_[i]);
    states_.registerHandle(state);
    const hardware_interface::JointHandle command(state, &command_[i]);
    isDriven[i] ? positions_.registerHandle(command) : efforts_.registerHandle(command);
  }
  registerInterface(&states_);
  registerInterface(&efforts_);
  registerInterface(&positions_);
}

void ChainHardware::read(const ros::Time& /*time*/, const ros::Duration& /*period*/) {
  position_ = simulation_.q();
  velocity_ = simulation_.qd();
  simulation_.jointTorques(effort_.data());
}

void ChainHardware::write(const ros::Time& /*time*/, const ros::Duration& period) {
  for (const double command : command_) {
    if (!std::isfinite(command))
      throw std::runtime_error("a controller commands a number that is not finite");
  }
  const double now = simulation_.time(), length = period.toSec();

  // Driven joints: to the position at the end of the period, with the rate of the commands.
  std::vector<bool> isDriven(command_.size());
  const std::vector<Drive> drives = simulation_.scene().drives;
  for (const Drive& drive : drives) {
    const std::size_t i = index(drive.joint);
    isDriven[i] = true;
    const double rate = (command_[i] - before_[i]) / length;
    simulation_.follow(drive.joint, drive.law.to(now, now + length, command_[i], rate));
  }

  // The others.
  constexpr double forever = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < command_.size(); ++i) {
    if (!isDriven[i]) simulation_.holdTorque(static_cast<int>(i), command_[i], forever);
  }
  before_ = command_;
  if (!simulation_.advanceTo(now + length)) throw std::runtime_error(simulation_.fault());
}

}  // namespace planar_chain_control
